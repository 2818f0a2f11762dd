"""How many HTTP calls a mission makes: of whom, by whom, on which route.

`make bench-calls`, or `python -m bench.calls --missions 20`. Plays episodes of `bench/search`'s set `mapped`: the four
services themselves, in simulated time. Writes out/bench/calls.json.
"""

import argparse
import sys
from collections import Counter
from collections.abc import Mapping
from pathlib import Path

from bench.results import save
from bench.search.play import played
from bench.search.running import begin, loaded, prepare_exports
from bench.search.sets import TUNE_HOMES, episode

TOURS = Path("out/bench/search/tours")


def table(calls: Mapping[str, int], missions: int, seconds: float) -> str:
    lines = [f"{missions} missions, {seconds:.0f} s; calls a mission:"]
    lines += [f"{name:70} {count / missions:9.1f}" for name, count in sorted(calls.items(), key=_by_pair)]
    lines.append(f"{'all':70} {sum(calls.values()) / missions:9.1f}")
    return "\n".join(lines)


def _by_pair(one: tuple[str, int]) -> tuple[str, str, int]:
    caller, _, route = one[0].split()
    return caller, route.partition("/")[0], -one[1]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--missions", type=int, default=20)
    parser.add_argument("--out", type=Path, default=Path("out/bench/calls.json"))
    options = parser.parse_args()
    begin()
    prepare_exports("sim")
    models, settings = loaded("sim")
    calls, seconds = Counter[str](), 0.0
    for number in range(options.missions):
        (row,) = played(episode("mapped", number, TUNE_HOMES), models, settings, tours=TOURS)["missions"]
        calls.update(row["calls"])
        seconds += row["seconds"]
    save(options.out, {"missions": options.missions, "seconds": round(seconds), "calls": dict(sorted(calls.items()))})
    sys.stdout.write(table(calls, options.missions, seconds) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
