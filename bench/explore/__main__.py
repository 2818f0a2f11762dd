"""Explores simulated homes that nobody has mapped, or tells what was explored: `make bench-explore`.

python -m bench.explore play --homes 3 --policies sensible,frontiers,reactive,hostile,killed
python -m bench.explore report                      # the table of what was played so far, in Markdown
"""

import argparse
import json
import os
import statistics
import sys
import time
from pathlib import Path
from typing import Any

from bench.explore.play import POLICIES, played
from bench.search.running import begin, say

OUT = Path("out/bench/explore")
FIRST = 7100
COLUMNS = (
    "policy", "homes", "seen (least)", "seen (mean)", "s to 90 %", "m to 90 %", "s in all", "m in all",
    "collisions", "of these in the laser's sight", "ended at home", "model calls", "tokens", "refused",
)  # fmt: skip


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=OUT)
    doing = parser.add_subparsers(dest="doing", required=True)
    playing = doing.add_parser("play")
    playing.add_argument("--homes", type=int, default=3)
    playing.add_argument("--first", type=int, default=FIRST, help="seed of the first home")
    playing.add_argument("--policies", default=",".join(POLICIES))
    playing.add_argument(
        "--duration", type=float, default=900.0, help="s that an exploration may take before it returns"
    )
    playing.add_argument("--minutes", type=float, default=float("inf"), help="begin none later than this")
    playing.add_argument("--floor-things", action="store_true", help="leave what the laser is too high to see")
    playing.add_argument("--anew", action="store_true", help="also what was played before")
    doing.add_parser("report")
    options = parser.parse_args()
    if options.doing == "play":
        begin()
        if os.environ.get("PYTHONHASHSEED") != "0":
            say("PYTHONHASHSEED is not 0: the same exploration may not come out the same twice")
        _play(options)
    say(report(options.out))
    return 0


def _play(options: argparse.Namespace) -> None:
    until_s = time.monotonic() + 60.0 * options.minutes
    for home in range(options.first, options.first + options.homes):
        for policy in options.policies.split(","):
            file: Path = options.out / policy / f"{home}.json"
            if time.monotonic() > until_s or (file.exists() and not options.anew):
                continue
            record = played(home, policy, seed=home, duration_s=options.duration, floor_things=options.floor_things)
            file.parent.mkdir(parents=True, exist_ok=True)
            partial = file.with_suffix(".partial")
            partial.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
            partial.replace(file)
            say(f"{policy} {home}: {record.get('end')}, seen {record.get('seen')}, {record['cpu_s']} s of a core")


def report(out: Path) -> str:
    """The table, a row for each policy of which there is a record."""
    lines = ["| " + " | ".join(COLUMNS) + " |", "|---|" + "---:|" * (len(COLUMNS) - 1)]
    for policy in POLICIES:
        records = [json.loads(file.read_text(encoding="utf-8")) for file in sorted((out / policy).glob("*.json"))]
        records = [one for one in records if "problem" not in one]
        if records:
            lines.append("| " + " | ".join(_row(policy, records)) + " |")
    return "\n".join(lines)


def _row(policy: str, records: list[dict[str, Any]]) -> list[str]:
    def total(name: str) -> str:
        return str(sum(one[name] for one in records))

    def mean(name: str) -> str:
        return f"{statistics.mean(one[name] for one in records):.0f}"

    seen = [one["seen"] for one in records]
    refused = sum(
        count
        for one in records
        for verdict, count in one["verdicts"].items()
        if verdict not in {"accepted", "slowed", "shortened"}
    )
    return [
        policy,
        str(len(records)),
        f"{min(seen):.1%}",
        f"{statistics.mean(seen):.1%}",
        _to(records, 0),
        _to(records, 1),
        mean("seconds"),
        mean("metres"),
        total("collisions"),
        str(sum(sum(one["touched_in_sight"].values()) for one in records)),
        f"{sum(one['from_home_m'] <= 0.6 for one in records)} of {len(records)}",
        total("calls"),
        total("tokens"),
        str(refused),
    ]


def _to(records: list[dict[str, Any]], which: int) -> str:
    reached = [one["reached"]["0.9"][which] for one in records if "0.9" in one["reached"]]
    if not reached:
        return "–"
    missing = "" if len(reached) == len(records) else f" ({len(reached)} of {len(records)})"
    return f"{statistics.mean(reached):.0f}{missing}"


if __name__ == "__main__":
    sys.exit(main())
