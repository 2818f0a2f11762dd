"""The fault campaign: hundreds of seeded missions with delays, drops, duplicates, crashes and lies, each one judged.

`make bench-campaign`, or `python -m bench.campaign --missions 500 --first 0`. Writes out/bench/campaign.json. Ends with
status 1 when a mission hung, crashed, moved the robot while stopped, or ended dishonestly.
"""

import argparse
import json
import logging
import math
import sys
import time
from collections import Counter, defaultdict
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from bench.missions.place import SimulatedPlace
from bench.missions.run import Run, run_mission
from bench.missions.scenario import HOMES, Scenario, scenario, wanted_in
from bench.missions.verdict import Verdict, judge
from bench.results import quiet, save
from bench.world.clock import NothingLeftError, SpinningError, run_simulated
from coordinator.core.recording import read, replay

MUST_BE_NONE = ("hangs", "crashes", "motion_while_stopped", "replays_that_differ", "dishonest")
PLAIN = (
    "missions", *MUST_BE_NONE, "false_finds", "deceived", "found_without_faults", "correct_of_found", "simulated_s",
    "wall_s",
)  # fmt: skip
REPLAY_EVERY = 10
"""Of that many missions one is decided again from its recording."""


def played(one: Scenario, place: SimulatedPlace) -> tuple[Run, Verdict]:
    """The mission of a scenario, judged. What the simulation cannot go on with counts as a hang or a crash."""
    run = Run(one)
    try:
        run = run_simulated(lambda: run_mission(place, one))
    except (NothingLeftError, SpinningError) as error:
        run.problems.append(f"hang: {error}")
    except Exception as error:
        logging.getLogger(__name__).exception("mission %d", one.seed)
        run.problems.append(f"crash: {type(error).__name__}: {error}")
    if one.seed % REPLAY_EVERY == 0 and run.recording:
        other = sum(not step.same for step in replay(read(run.recording)))
        if other:
            run.problems.append(f"replay: {other} of its steps are decided otherwise")
    return run, judge(run, place)


def row_of(run: Run, verdict: Verdict, wall_s: float) -> dict[str, Any]:
    one, mission = run.scenario, run.mission
    return {
        "seed": one.seed,
        "command": one.command,
        "present": one.present.value,
        "remembered": one.remembered.value,
        "docked": one.docked,
        "rules": one.rules,
        "faults": list(one.faults.names),
        "ending": verdict.ending,
        "correct": verdict.correct,
        "deceived": verdict.deceived,
        "dishonest": verdict.dishonest,
        "problems": run.problems,
        "reason": run.refused or (mission.reason if mission is not None else ""),
        "told_m": mission.measured_distance_m if mission is not None else None,
        "true_m": verdict.true_distance_m,
        "took_s": round(run.took_s, 1),
        "way_m": round(run.way_m, 2),
        "events": len(run.events),
        "wall_s": round(wall_s, 3),
    }


def campaign(seeds: list[int], *, jobs: int = 1, within_s: float = math.inf) -> list[dict[str, Any]]:
    """Every seed's row; missions not begun in time are left out. Those of one home are played together: making a home
    takes a second.
    """
    play = partial(in_one_home, until_s=time.monotonic() + within_s)
    homes: dict[int, list[int]] = defaultdict(list)
    for seed in seeds:
        homes[seed % HOMES].append(seed)
    rows: list[dict[str, Any]] = []
    if jobs == 1:
        for of_home in homes.values():
            rows += play(of_home)
    else:
        with ProcessPoolExecutor(jobs, mp_context=get_context("spawn"), initializer=quiet) as pool:
            for some in pool.map(play, homes.values()):
                rows += some
    return sorted(rows, key=lambda row: row["seed"])


def in_one_home(seeds: list[int], *, until_s: float = math.inf, **rules: Any) -> list[dict[str, Any]]:
    """Seeds that differ by a multiple of `HOMES`. `until_s` is monotonic time, the same in every process."""
    if time.monotonic() > until_s:
        return []
    home = seeds[0] % HOMES
    place = SimulatedPlace(home, *wanted_in(home))
    rows: list[dict[str, Any]] = []
    for seed in seeds:
        if time.monotonic() > until_s:
            break
        began = time.perf_counter()
        one = scenario(seed)
        run, verdict = played(replace(one, rules={**one.rules, **rules}), place)
        rows.append(row_of(run, verdict, time.perf_counter() - began))
        if run.problems or verdict.dishonest:
            print_row(rows[-1])
    place.close()
    return rows


def print_row(row: dict[str, Any]) -> None:
    what = "; ".join([*row["problems"][:2], row["dishonest"]]).strip("; ")
    sys.stdout.write(f"seed {row['seed']}: {row['ending']}: {what}  [{', '.join(row['faults'])}] {row['rules']}\n"
                     f"    {row['reason'][:160]}\n")  # fmt: skip
    sys.stdout.flush()


def summary(rows: list[dict[str, Any]]) -> dict[str, Any]:
    def group(key: Any) -> dict[str, dict[str, int]]:
        table: dict[str, Counter[str]] = defaultdict(Counter)
        for row in rows:
            table[key(row)][row["ending"]] += 1
        return {name: dict(sorted(counts.items())) for name, counts in sorted(table.items())}

    there = [r for r in rows if r["present"] == "there" and not r["faults"]]
    by_fault: dict[str, Counter[str]] = defaultdict(Counter)
    for row in rows:
        for name in row["faults"] or ["none"]:
            by_fault[name][row["ending"]] += 1
    return {
        "missions": len(rows),
        "hangs": sum(any(p.startswith("hang") for p in r["problems"]) for r in rows),
        "crashes": sum(any(p.startswith("crash") for p in r["problems"]) for r in rows),
        "motion_while_stopped": sum(any(p.startswith("motion") for p in r["problems"]) for r in rows),
        "replays_that_differ": sum(any(p.startswith("replay") for p in r["problems"]) for r in rows),
        "dishonest": sum(bool(r["dishonest"]) for r in rows),
        "false_finds": sum(r["ending"] == "found" and "no such thing" in r["dishonest"] for r in rows),
        "deceived": sum(r["deceived"] for r in rows),
        "found_without_faults": [sum(r["ending"] == "found" for r in there), len(there)],
        "correct_of_found": [sum(r["correct"] for r in rows), sum(r["ending"] == "found" for r in rows)],
        "simulated_s": round(sum(r["took_s"] for r in rows)),
        "wall_s": round(sum(r["wall_s"] for r in rows), 1),
        "endings": dict(sorted(Counter(r["ending"] for r in rows).items())),
        "endings_by_presence": group(lambda r: f"{r['present']}, memory {r['remembered']}"),
        "endings_by_fault": {name: dict(sorted(counts.items())) for name, counts in sorted(by_fault.items())},
    }


def table(figures: dict[str, Any]) -> str:
    endings = sorted(figures["endings"])
    lines = [f"{'':28}" + "".join(f"{name:>12}" for name in endings)]
    for title in ("endings_by_presence", "endings_by_fault"):
        lines += [
            f"{name:28}" + "".join(f"{counts.get(ending, 0):>12}" for ending in endings)
            for name, counts in figures[title].items()
        ]
        lines.append("")
    lines.append(f"{'all':28}" + "".join(f"{figures['endings'][ending]:>12}" for ending in endings))
    lines += [f"{name.replace('_', ' ')}: {figures[name]}" for name in PLAIN]
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--missions", type=int, default=500)
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--out", type=Path, default=Path("out/bench/campaign.json"))
    parser.add_argument("--add", action="store_true", help="keep the other seeds' rows that --out holds already")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--minutes", type=float, default=math.inf, help="begin no mission later than this")
    parser.add_argument("--quick", action="store_true", help="20 missions")
    options = parser.parse_args()
    quiet()
    count = 20 if options.quick else options.missions
    rows = campaign(list(range(options.first, options.first + count)), jobs=options.jobs, within_s=options.minutes * 60)
    if options.add and options.out.exists():
        new = {row["seed"] for row in rows}
        old = json.loads(options.out.read_text(encoding="utf-8"))["rows"]
        rows = sorted([*rows, *(row for row in old if row["seed"] not in new)], key=lambda row: row["seed"])
    figures = summary(rows)
    save(options.out, {**figures, "rows": rows})
    sys.stdout.write(table(figures) + "\n")
    return 1 if any(figures[name] for name in MUST_BE_NONE) else 0


if __name__ == "__main__":
    sys.exit(main())
