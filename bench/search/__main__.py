"""Plays episodes, plays one again, or tells what was played: `make bench-search`, see README.md beside this.

python -m bench.search play --sets mapped,moved --episodes 20
python -m bench.search replay out/bench/search/viewpoints/mapped/0003.json
python -m bench.search report
"""

import argparse
import asyncio
import json
import logging
import os
import sys
import time
from collections.abc import Iterator
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import structlog

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
    playing.add_argument("--policy", default="viewpoints")
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
    quiet()
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
    from bench.search.sets import SETS, TEST_HOMES, TUNE_HOMES

    homes = TEST_HOMES if options.homes == "test" else TUNE_HOMES
    names = list(SETS) if options.sets == "all" else options.sets.split(",")
    numbers = range(options.first, options.first + options.episodes)
    jobs = [(name, number) for number in numbers for name in names]
    left = [job for job in jobs if options.anew or not file_of(options.out, options.policy, *job).exists()]
    say(f"{len(jobs)} episodes, {len(jobs) - len(left)} there already")
    if left:
        prepare_exports(options.detector)
    until_s = time.monotonic() + options.minutes * 60.0
    began_s, done, broken = time.monotonic(), 0, 0
    with ProcessPoolExecutor(options.jobs, mp_context=get_context("spawn"), initializer=quiet) as pool:
        by_home: dict[int, list[tuple[str, int]]] = {}
        for name, number in left:
            by_home.setdefault(number % len(homes), []).append((name, number))
        futures: list[Future[list[dict[str, Any]]]] = [
            pool.submit(worked, [job], options.policy, options.detector, homes, options.out, until_s)
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


def worked(
    jobs: list[tuple[str, int]], policy: str, detector: str, homes: tuple[int, ...], out: Path, until_s: float
) -> list[dict[str, Any]]:
    """In a process of its own; `until_s` is monotonic time, the same in every process."""
    from bench.search.play import played
    from bench.search.sets import episode

    records: list[dict[str, Any]] = []
    for name, number in jobs:
        if time.monotonic() > until_s:
            break
        one = episode(name, number, homes).model_copy(update={"policy": policy, "detector": detector})
        models, settings = loaded(detector)
        record = played(one, models, settings, tours=out / "tours")
        file = file_of(out, policy, name, number)
        file.parent.mkdir(parents=True, exist_ok=True)
        partial = file.with_suffix(".partial")
        partial.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
        partial.replace(file)
        records.append(record)
    return records


def replay(options: argparse.Namespace) -> int:
    from bench.search.episode import Episode
    from bench.search.play import played

    before = json.loads(options.record.read_text(encoding="utf-8"))
    one = Episode.model_validate(before["episode"])
    models, settings = loaded(one.detector)
    now = played(one, models, settings, tours=options.out / "tours", keep=options.keep)
    say(line_of(now))
    same = now["digest"] == before["digest"]
    say("the same, bit for bit" if same else "NOT the same: " + "; ".join(differences(before, now)))
    return 0 if same else 1


def report(out: Path) -> int:
    from bench.search.report import by_set, misses, records_in, table

    records = records_in(out)
    told = by_set(records)
    out.mkdir(parents=True, exist_ok=True)
    (out / "report.json").write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
    text = "\n".join([table(told), "", "Not as it should be:", "", *misses(records)])
    (out / "report.md").write_text(text + "\n", encoding="utf-8")
    say(text)
    return 0


_LOADED: dict[str, Any] = {}


def loaded(detector: str) -> Any:
    """The models and every service's settings, once a process."""
    if detector not in _LOADED:
        from bench.world.mesh import MeshSettings
        from inference.adapters.loading import loader

        settings = inference_settings(detector)
        _LOADED[detector] = loader(settings)(), MeshSettings(Path(), inference=settings)
    return _LOADED[detector]


def inference_settings(detector: str) -> Any:
    """One backend by name: which is the fastest is not the same each time."""
    from inference.settings import Backend, ModelSet, Settings

    return Settings(model_set=ModelSet(detector), detector_backend=Backend.OPENVINO)


def prepare_exports(detector: str) -> None:
    from inference.adapters.loading import detector_exports

    exports = detector_exports(inference_settings(detector))
    if exports.missing():
        say("exporting the detector")
        trouble = asyncio.run(exports.make())
        if trouble:
            raise SystemExit(f"the detector could not be exported: {trouble}")


def file_of(out: Path, policy: str, set_name: str, number: int) -> Path:
    return out / policy / set_name / f"{number:04d}.json"


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


def say(text: str) -> None:
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


def quiet() -> None:
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    structlog.configure(wrapper_class=structlog.make_filtering_bound_logger(logging.CRITICAL))
    logging.disable(logging.CRITICAL)


if __name__ == "__main__":
    sys.exit(main())
