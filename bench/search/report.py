"""Tables of what was played: by set and policy, with Wilson intervals; and where the seconds went."""

import json
from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bench.search.episode import variant_of
from bench.search.play import FOUND_WITHIN_M
from bench.seeing.statistics import share

Row = dict[str, Any]
NEAR, FAR = (str(within_m) for within_m in FOUND_WITHIN_M)
HONEST = frozenset({"not_found", "unsure"})


def records_in(folder: Path) -> list[dict[str, Any]]:
    return [
        json.loads(path.read_text(encoding="utf-8")) for path in sorted(folder.glob("*/*/[0-9][0-9][0-9][0-9].json"))
    ]


def is_found(row: Row, within: str) -> bool:
    return row["outcome"] == "found" and bool(row.get("score", {}).get("within", {}).get(within))


def is_right(row: Row) -> bool:
    """Found within reach, or honestly not found where it is not there."""
    return is_found(row, NEAR) if row["there"] else row["outcome"] in HONEST


def is_false_find(row: Row) -> bool:
    """It says found, and no such thing is before it."""
    return row["outcome"] == "found" and bool(row.get("score", {}).get("false_find", not row["there"]))


def spl(row: Row, within: str = NEAR) -> float:
    """Success weighted by path length (Anderson et al., 2018): the shortest way over the way driven."""
    shortest_m = row["shortest_m"][within]
    if not is_found(row, within) or shortest_m is None:
        return 0.0
    return shortest_m / max(shortest_m, row["metres"], 1e-6)


def figures(records: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Of the episodes of one set and policy. `seconds` and what follows are of finds within 1.0 m."""
    rows = [row for record in records for row in record["missions"]]
    there = [row for row in rows if row["there"]]
    gone = [row for row in rows if not row["there"]]
    found = [row for row in there if is_found(row, FAR)]
    with_floor = [row for row in found if row["floor_s"][NEAR] is not None]
    over_s = [row["seconds"] - row["floor_s"][NEAR] for row in with_floor]
    times = [row["seconds"] / max(row["floor_s"][NEAR], 1.0) for row in with_floor]
    models = [sum(n for name, n in record.get("calls", {}).items() if "/camera/frame" in name) for record in records]
    return {
        "episodes": len(records),
        "missions": len(rows),
        "found_0.45": share(sum(is_found(row, NEAR) for row in there), len(there)),
        "found_1.0": share(len(found), len(there)),
        "spl": round(float(np.mean([spl(row) for row in there])), 3) if there else None,
        "seconds": middle([row["seconds"] for row in found]),
        "over_floor_s": middle(over_s),
        "times_floor": middle(times),
        "metres": middle([row["metres"] for row in found]),
        "false_finds": share(sum(is_false_find(row) for row in rows), len(rows)),
        "honest_without": share(sum(row["outcome"] in HONEST for row in gone), len(gone)),
        "outcomes": dict(sorted(Counter(row["outcome"] for row in rows).items())),
        "pictures_looked_at": middle(models),
        "votes": sum(n for record in records for name, n in record.get("calls", {}).items() if "/validate" in name),
        "collisions": sum(record.get("collisions", 0) for record in records),
        "problems": [problem for record in records for problem in record["problems"]],
        "activity_s": activity(records),
        "standing_share": _ratio(
            sum(record.get("standing_s", 0.0) for record in records), sum(activity(records).values())
        ),
        "real_time": _ratio(
            sum(record["wall"]["simulated_s"] for record in records),
            sum(record["wall"]["cpu_s"] - record["wall"]["tour_cpu_s"] for record in records),
        ),
    }


def _variant(episode: dict[str, Any]) -> str:
    return variant_of(episode["policy"], episode.get("changes", ()), episode.get("detector", "sim"))


def activity(records: Iterable[dict[str, Any]]) -> dict[str, float]:
    """Seconds by what the mission was at, whatever its state."""
    sums: Counter[str] = Counter()
    for record in records:
        for name, seconds in record.get("activity", {}).items():
            sums[name.partition(": ")[2]] += seconds
    return {name: round(seconds, 1) for name, seconds in sums.most_common()}


def middle(values: Sequence[float]) -> dict[str, float] | None:
    if not values:
        return None
    low, median, high = np.percentile(values, [25, 50, 75]).tolist()
    return {"median": round(median, 2), "p25": round(low, 2), "p75": round(high, 2)}


def _ratio(part: float, of: float) -> float | None:
    return round(part / of, 3) if of > 0.0 else None


def by_set(records: Iterable[dict[str, Any]]) -> dict[str, dict[str, Any]]:
    groups: dict[str, list[dict[str, Any]]] = defaultdict(list)
    for record in records:
        groups[f"{_variant(record['episode'])}/{record['episode']['set_name']}"].append(record)
    return {name: figures(group) for name, group in groups.items()}


COLUMNS = ("policy/set", "missions", "found 0.45 m", "found 1.0 m", "SPL", "seconds", "over floor", "x floor",
           "metres", "false finds", "honest without", "standing", "x real time")  # fmt: skip


def table(told: dict[str, dict[str, Any]]) -> str:
    """As Markdown."""
    lines = ["| " + " | ".join(COLUMNS) + " |", "|" + "---|" * len(COLUMNS)]
    for name, one in told.items():
        cells = [name, one["missions"], _share(one["found_0.45"]), _share(one["found_1.0"]), one["spl"],
                 _median(one["seconds"]), _median(one["over_floor_s"]), _median(one["times_floor"]),
                 _median(one["metres"]), _share(one["false_finds"]), _share(one["honest_without"]),
                 one["standing_share"], one["real_time"]]  # fmt: skip
        lines.append("| " + " | ".join("" if cell is None else str(cell) for cell in cells) + " |")
    lines += ["", "Where the seconds went:", ""]
    lines += [f"- {name}: " + ", ".join(f"{what} {seconds:g} s" for what, seconds in one["activity_s"].items())
              for name, one in told.items()]  # fmt: skip
    failures = [f"- {name}: {problem}" for name, one in told.items() for problem in one["problems"]]
    return "\n".join([*lines, *(["", "Problems:", "", *failures] if failures else [])])


def misses(records: Iterable[dict[str, Any]]) -> list[str]:
    """One line for each mission that did not end as it should."""
    lines: list[str] = []
    for record in records:
        episode = record["episode"]
        for row in record["missions"]:
            if is_right(row):
                continue
            score, away = row.get("score", {}), ""
            if "true_distance_m" in score:
                away = f" ({score['true_distance_m']:.2f} m from it)"
            lines.append(f"- {_variant(episode)}/{episode['set_name']}/{episode['number']:04d} '{row['command']}': "
                         f"{row['outcome']}{away}: {row['reason'][:200]}")  # fmt: skip
    return lines


def _share(told: dict[str, Any]) -> str:
    if not told["of"]:
        return ""
    low, high = told["wilson_95"]
    return f"{told['n']}/{told['of']} ({low * 100:.0f}-{high * 100:.0f} %)"


def _median(told: dict[str, float] | None) -> str:
    return "" if told is None else f"{told['median']:g}"
