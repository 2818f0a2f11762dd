"""Plays seeded fetches with the simulated arm and tells how many worked: `make bench-fetch`.

python -m bench.fetch --fetches 20
"""

import argparse
import json
import sys
from collections import Counter
from pathlib import Path
from typing import Any

from bench.fetch.play import episodes, played
from bench.seeing.statistics import wilson

OUT = Path("out/bench/fetch")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fetches", type=int, default=20)
    parser.add_argument("--first", type=int, default=1, help="seed of the first fetch")
    parser.add_argument("--out", type=Path, default=OUT)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    rows: list[dict[str, Any]] = []
    for episode in episodes(options.fetches, options.first):
        row = played(episode)
        rows.append(row)
        (options.out / f"{episode.seed}.json").write_text(json.dumps(row) + "\n", encoding="utf-8")
        say(json.dumps(row))
    say(report(rows))
    return 0


def report(rows: list[dict[str, Any]]) -> str:
    """By place and kind, in Markdown: how many of how many, with Wilson's 95 % interval, and why not."""
    lines = ["| thing | grasped | 95 % | brought | why not |", "|---|---|---|---|---|"]
    places = list(dict.fromkeys(row["place"] for row in rows))
    kinds = list(dict.fromkeys(row["kind"] for row in rows))
    groups = [("all", rows)]
    groups += [(place, [row for row in rows if row["place"] == place]) for place in places]
    groups += [(kind, [row for row in rows if row["kind"] == kind]) for kind in kinds]
    for name, group in groups:
        hits = sum(row["grasped"] for row in group)
        low, high = wilson(hits, len(group))
        causes = Counter(row["cause"] or row["end"] for row in group if not row["brought"])
        why = ", ".join(f"{cause} {count}" for cause, count in causes.most_common())
        lines.append(
            f"| {name} | {hits} of {len(group)} | {100 * low:.0f} to {100 * high:.0f} % "
            f"| {sum(row['brought'] for row in group)} | {why} |"
        )
    false = sum(row["said_held_without_it"] for row in rows)
    slips = sorted(row["slipped_mm"] for row in rows if row["grasped"])
    most = f", slipped {slips[-1]} mm at most while held" if slips else ""
    return "\n".join([*lines, "", f"{false} said to be held that were not{most}."])


def say(text: str) -> None:
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main())
