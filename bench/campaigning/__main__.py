"""Hundreds of seeded missions through the whole mesh with faults injected, each one judged; or one again.

python -m bench.campaigning play --missions 500 --first 0 --jobs 2
python -m bench.campaigning replay out/bench/campaign/0007.json
Goes on where it was ended. Status 1 when a mission hung, crashed, moved the robot while stopped, or ended dishonestly.
"""

import argparse
import json
import os
import sys
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from bench.campaigning.episode import FaultedEpisode, faulted
from bench.campaigning.play import played
from bench.search.__main__ import differences
from bench.search.running import begin, loaded, prepare_exports, say

OUT = Path("out/bench/campaign")
PROBLEMS = ("hang", "crash", "motion", "replay")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=OUT)
    doing = parser.add_subparsers(dest="doing", required=True)
    playing = doing.add_parser("play")
    playing.add_argument("--missions", type=int, default=500)
    playing.add_argument("--first", type=int, default=0, help="the first seed")
    playing.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    playing.add_argument("--minutes", type=float, default=float("inf"), help="begin no mission later than this")
    doing.add_parser("replay").add_argument("record", type=Path)
    options = parser.parse_args()
    begin()
    return play(options) if options.doing == "play" else again(options.record, options.out)


def play(options: argparse.Namespace) -> int:
    os.environ["PYTHONHASHSEED"] = "0"  # of the workers
    prepare_exports("sim")
    options.out.mkdir(parents=True, exist_ok=True)
    seeds = range(options.first, options.first + options.missions)
    left = [seed for seed in seeds if not (options.out / f"{seed:04d}.json").exists()]
    until_s, done = time.monotonic() + options.minutes * 60.0, 0
    with ProcessPoolExecutor(options.jobs, mp_context=get_context("spawn"), initializer=begin) as pool:
        for future in as_completed([pool.submit(worked, seed, options.out, until_s) for seed in left]):
            if (record := future.result()) is not None:
                done += 1
                say(f"{done}/{len(left)} {line_of(record)}")
    records = [json.loads(file.read_text(encoding="utf-8")) for file in sorted(options.out.glob("[0-9]*.json"))]
    figures = summary(records)
    (options.out / "campaign.json").write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")
    say(json.dumps(figures, indent=1))
    return 1 if figures["dishonest"] or any(figures[name] for name in PROBLEMS) else 0


def worked(seed: int, out: Path, until_s: float) -> dict[str, Any] | None:
    """In a process of its own; none where it is too late to begin."""
    if time.monotonic() > until_s:
        return None
    models, settings = loaded("sim")
    record = played(faulted(seed), models, settings, tours=out / "tours")
    partial = out / f"{seed:04d}.partial"
    partial.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    partial.replace(partial.with_suffix(".json"))
    return record


def again(file: Path, out: Path) -> int:
    before = json.loads(file.read_text(encoding="utf-8"))
    models, settings = loaded("sim")
    now = played(FaultedEpisode.model_validate(before["faulted"]), models, settings, tours=out / "tours")
    say(line_of(now))
    same = now["digest"] == before["digest"]
    say("the same, bit for bit" if same else "NOT the same: " + "; ".join(differences(before, now)))
    return 0 if same else 1


def line_of(record: dict[str, Any]) -> str:
    one = record["faulted"]
    what = "; ".join([*record["problems"], record["dishonest"]]).strip("; ")
    return (f"seed {one['seed']}, {one['episode']['set_name']}: {record['ending']} after {record['took_s']:.0f} s"
            f"  [{', '.join(one['faults']['names'])}] {what} ({record['wall']['seconds']:.0f} s)")  # fmt: skip


def summary(records: list[dict[str, Any]]) -> dict[str, Any]:
    by_fault: dict[str, Counter[str]] = {}
    for record in records:
        for name in record["faulted"]["faults"]["names"] or ["none"]:
            by_fault.setdefault(name, Counter())[record["ending"]] += 1
    found = [record for record in records if record["ending"] == "found"]
    return {
        "missions": len(records),
        **{name: sum(any(p.startswith(name) for p in r["problems"]) for r in records) for name in PROBLEMS},
        "dishonest": sum(bool(record["dishonest"]) for record in records),
        "false_finds": sum(bool(record["score"].get("false_find")) for record in found),
        "correct_of_found": [sum(record["correct"] for record in found), len(found)],
        "simulated_s": round(sum(record["took_s"] for record in records)),
        "endings": dict(sorted(Counter(record["ending"] for record in records).items())),
        "endings_by_fault": {name: dict(sorted(counts.items())) for name, counts in sorted(by_fault.items())},
    }


if __name__ == "__main__":
    sys.exit(main())
