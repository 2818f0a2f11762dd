"""Plays episodes, plays one again, or tells what was played: `make bench-search`, see README.md beside this.

python -m bench.search play --sets mapped,moved --episodes 20
python -m bench.search replay out/bench/search/belief/mapped/0003.json
python -m bench.search report
"""

import argparse
import json
import os
import sys
import time
from collections.abc import Iterator
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from bench.search.episode import Episode, variant_of
from bench.search.gallery import gallery
from bench.search.play import played
from bench.search.policies import POLICIES, deciding
from bench.search.report import by_set, misses, records_in, table
from bench.search.running import begin, loaded, prepare_exports, say, worked
from bench.search.sets import SETS, TEST_HOMES, TUNE_HOMES
from coordinator.settings import Settings

OUT = Path("out/bench/search")
DETECTORS = ("sim", "coco")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=OUT)
    doing = parser.add_subparsers(dest="doing", required=True)
    playing = doing.add_parser("play")
    playing.add_argument("--sets", default="all", help="with commas, or 'all'")
    playing.add_argument("--episodes", type=int, default=20, help="of each set")
    playing.add_argument("--first", type=int, default=0)
    playing.add_argument("--policy", choices=POLICIES, default="belief")
    playing.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE", help="of the coordinator's settings"
    )
    playing.add_argument("--homes", choices=("test", "tune"), default="test")
    playing.add_argument("--detector", choices=DETECTORS, default="sim")
    playing.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    playing.add_argument("--minutes", type=float, default=float("inf"), help="begin no episode later than this")
    playing.add_argument("--anew", action="store_true", help="also what was played before")
    again = doing.add_parser("replay")
    again.add_argument("record", type=Path)
    again.add_argument("--keep", type=Path, help="a folder for the robot's disk: its databases and the recording")
    doing.add_parser("report")
    options = parser.parse_args()
    begin()
    match options.doing:
        case "play":
            return play(options)
        case "replay":
            return replay(options)
        case _:
            return report(options.out)


def play(options: argparse.Namespace) -> int:
    """Those of one home one after another in one process, so that a home's tour is made once."""
    os.environ["PYTHONHASHSEED"] = "0"  # of the workers
    homes = TEST_HOMES if options.homes == "test" else TUNE_HOMES
    names = list(SETS) if options.sets == "all" else options.sets.split(",")
    numbers = range(options.first, options.first + options.episodes)
    jobs = [(name, number) for number in numbers for name in names]
    deciding(Settings(), options.policy, options.set)  # refused now, not by each worker
    like = {"policy": options.policy, "changes": tuple(sorted(options.set)), "detector": options.detector}
    folder = options.out / variant_of(**like)
    left = [(name, k) for name, k in jobs if options.anew or not (folder / name / f"{k:04d}.json").exists()]
    say(f"{len(jobs)} episodes, {len(jobs) - len(left)} there already")
    if left:
        prepare_exports(options.detector)
    until_s = time.monotonic() + options.minutes * 60.0
    began_s, done, broken = time.monotonic(), 0, 0
    with ProcessPoolExecutor(options.jobs, mp_context=get_context("spawn"), initializer=begin) as pool:
        by_home: dict[int, list[tuple[str, int]]] = {}
        for name, number in left:
            by_home.setdefault(number % len(homes), []).append((name, number))
        futures: list[Future[list[dict[str, Any]]]] = [
            pool.submit(worked, [job], like, homes, options.out, until_s)
            for some in by_home.values() for job in some
        ]  # fmt: skip
        for future in as_completed(futures):
            for record in future.result():
                done += 1
                broken += bool(record["problems"])
                took_s = time.monotonic() - began_s
                say(f"{done}/{len(left)} {line_of(record)}  [{took_s / done * (len(left) - done) / 60:.0f} min left]")
    report(options.out)
    return 1 if broken else 0


def replay(options: argparse.Namespace) -> int:
    before = json.loads(options.record.read_text(encoding="utf-8"))
    one = Episode.model_validate(before["episode"])
    models, settings = loaded(one.detector)
    now = played(one, models, settings, tours=options.out / "tours", keep=options.keep)
    say(line_of(now))
    same = now["digest"] == before["digest"]
    say("the same, bit for bit" if same else "NOT the same: " + "; ".join(differences(before, now)))
    return 0 if same else 1


def report(out: Path) -> int:
    records = records_in(out)
    told = by_set(records)
    out.mkdir(parents=True, exist_ok=True)
    (out / "report.json").write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
    page = gallery(records, out / "gallery")
    text = "\n".join([table(told), "", "Not as it should be:", "", *misses(records)])
    (out / "report.md").write_text(text + "\n", encoding="utf-8")
    say(f"{text}\n\n{page}")
    return 0


def line_of(record: dict[str, Any]) -> str:
    episode, wall = record["episode"], record["wall"]
    endings = ", ".join(f"{row['outcome']} {row.get('seconds', 0.0):.0f} s" for row in record["missions"])
    return f"{episode['set_name']}/{episode['number']:04d}: {endings}{'; '.join(['', *record['problems']])}" + (
        f"  ({wall['simulated_s']:.0f} s in {wall['cpu_s']:.0f} s of a core)"
    )


def differences(one: Any, other: Any, path: str = "", most: int = 5) -> list[str]:
    """Where two records differ first."""
    return [text for text, _ in zip(_differences(one, other, path), range(most), strict=False)]


def _differences(one: Any, other: Any, path: str) -> Iterator[str]:
    if isinstance(one, dict) and isinstance(other, dict):
        for key in one.keys() | other.keys() - {"wall", "digest"}:
            if key not in {"wall", "digest"}:
                yield from _differences(one.get(key), other.get(key), f"{path}/{key}")
    elif isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        for k, (a, b) in enumerate(zip(one, other, strict=True)):
            yield from _differences(a, b, f"{path}/{k}")
    elif one != other:
        yield f"{path}: {str(one)[:80]} and {str(other)[:80]}"


if __name__ == "__main__":
    sys.exit(main())
