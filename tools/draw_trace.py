"""Draws the way of a mission from the typed word to the wheels: `make trace MISSION=<id>`, or without an id the newest.

Reads the spans that the services wrote where `ATOM_TRACES` names a folder; needs no service and no network. What was
done many times in one place is one line with many bars. Writes a picture beside the text.
"""

import argparse
import contextlib
import json
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

SERVICES: Final = ("ui", "coordinator", "inference", "memory", "robot_bridge")
COLOURS: Final = dict(zip(SERVICES, ("#8e6bbf", "#3b76af", "#ef8636", "#519e3e", "#c53a32"), strict=True))
PLUMBING: Final = "mesh.http"
WIDTH: Final = 56
MARKS: Final = {"twist": "^", "vote": "v"}


class NoSuchTraceError(Exception):
    """Says what was looked for, and where."""


@dataclass(frozen=True)
class Span:
    """As a line of the file has it; times in s since the epoch."""

    trace_id: str
    span_id: str
    parent_id: str
    service: str
    module: str
    name: str
    start_s: float
    end_s: float
    failed: str
    attributes: dict[str, Any]
    events: list[tuple[str, float, dict[str, Any]]]

    @classmethod
    def read(cls, said: dict[str, Any]) -> "Span":
        events = [(one["name"], one["stamp_ns"] / 1e9, one["attributes"]) for one in said["events"]]
        times = {"start_s": said["start_ns"] / 1e9, "end_s": said["end_ns"] / 1e9}
        known = {name: said[name] for name in cls.__dataclass_fields__ if name in said and name != "events"}
        return cls(**known, **times, events=events)


@dataclass
class Row:
    """Everything of one name in one place of the tree."""

    service: str
    name: str
    depth: int
    spans: list[Span] = field(default_factory=list[Span])
    below: "dict[tuple[str, str], Row]" = field(default_factory=dict[tuple[str, str], "Row"])

    @property
    def seconds(self) -> float:
        return sum(one.end_s - one.start_s for one in self.spans)

    @property
    def label(self) -> str:
        return f"{'  ' * self.depth}{self.name}{f' x{len(self.spans)}' if len(self.spans) > 1 else ''}"


def spans_in(folder: Path) -> list[Span]:
    """A torn line is left out: a service may be writing it, or was killed while it did."""
    spans: list[Span] = []
    for file in sorted(folder.glob("*.jsonl*")):
        for line in file.read_text(encoding="utf-8").splitlines():
            with contextlib.suppress(json.JSONDecodeError):
                spans.append(Span.read(json.loads(line)))
    return spans


def of_mission(spans: Sequence[Span], mission: str) -> tuple[Span, list[Span]]:
    """The span of the mission whose id begins so ('' = the newest), and all spans of its trace but those of other
    missions. Raises `NoSuchTraceError`."""
    found = [
        one for one in spans if one.name == "mission" and str(one.attributes.get("mission.id", "")).startswith(mission)
    ]
    if not found:
        raise NoSuchTraceError(f"no mission '{mission}' among {len(spans)} spans: it is not over, or was not recorded")
    whole = max(found, key=lambda one: one.start_s)
    by_id = {one.span_id: one for one in spans if one.trace_id == whole.trace_id}

    def is_drawn(one: Span | None) -> bool:
        return one is None or one is whole or (one.name != "mission" and is_drawn(by_id.get(one.parent_id)))

    return whole, [one for one in by_id.values() if is_drawn(one)]


def rows_of(spans: Sequence[Span]) -> list[Row]:
    """The tree, top down. A call and its handling in the other service are one line."""
    by_id = {one.span_id: one for one in spans}
    answered = {one.parent_id for one in spans if one.module != PLUMBING}
    tops: dict[tuple[str, str], Row] = {}

    def path(one: Span) -> list[tuple[str, str]]:
        parent = by_id.get(one.parent_id)
        above = path(parent) if parent is not None else []
        return (
            above if one.module == PLUMBING and one.span_id in answered else [*above, (_service(one, above), one.name)]
        )

    for one in sorted(spans, key=lambda span: span.start_s):
        if one.module == PLUMBING and one.span_id in answered:
            continue
        level, row = tops, None
        for depth, key in enumerate(path(one)):
            row = level.setdefault(key, Row(*key, depth))
            level = row.below
        if row is not None:
            row.spans.append(one)
    return [row for top in tops.values() for row in _flat(top)]


def _service(one: Span, above: list[tuple[str, str]]) -> str:
    own = one.module.partition(".")[0]
    return own if own in SERVICES else above[-1][0] if above else one.service


def _flat(row: Row) -> Iterable[Row]:
    yield row
    for one in row.below.values():
        yield from _flat(one)


def told(whole: Span, rows: Sequence[Row]) -> str:
    """The picture in letters."""
    begin_s, end_s = _times(rows)
    scale = WIDTH / max(end_s - begin_s, 1e-9)
    lines = [_title(whole), ""]
    for row in rows:
        bar = [" "] * WIDTH
        for one in row.spans:
            first = min(WIDTH - 1, int((one.start_s - begin_s) * scale))
            last = min(WIDTH - 1, max(first, int((one.end_s - begin_s) * scale)))
            bar[first : last + 1] = ["x" if one.failed else "="] * (last + 1 - first)
            for name, stamp_s, _ in one.events:
                bar[min(WIDTH - 1, max(0, int((stamp_s - begin_s) * scale)))] = MARKS.get(name, "*")
        lines.append(f"{row.service:12} {row.label[:44]:44} |{''.join(bar)}| {row.seconds:9.3f} s")
    twist = _first_twist(rows)
    lines += ["", "= at work  x failed  ^ the first velocity sent for it  v a vote"]
    return "\n".join([*lines, *([twist] if twist else [])])


def _times(rows: Sequence[Row]) -> tuple[float, float]:
    spans = [one for row in rows for one in row.spans]
    return min(one.start_s for one in spans), max(one.end_s for one in spans)


def _title(whole: Span) -> str:
    about = whole.attributes
    outcome, seconds = about.get("mission.outcome", ""), whole.end_s - whole.start_s
    return f"'{about.get('mission.command', '')}': {outcome} after {seconds:.1f} s; trace {whole.trace_id}"


def _first_twist(rows: Sequence[Row]) -> str:
    begin_s, _ = _times(rows)
    sent = [
        (stamp_s, row, about)
        for row in rows
        for one in row.spans
        for name, stamp_s, about in one.events
        if name == "twist" and (about["linear_x"] or about["angular_z"])
    ]
    if not sent:
        return ""
    stamp_s, row, about = min(sent, key=lambda one: one[0])
    speeds = f"{about['linear_x']:.2f} m/s, {about['angular_z']:.2f} rad/s"
    return (
        f"the wheels turned {stamp_s - begin_s:.3f} s after the first word: {speeds} for {row.name} ({about['source']})"
    )


def draw(whole: Span, rows: Sequence[Row], file: Path) -> None:
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt
    from matplotlib.patches import Patch

    begin_s, _ = _times(rows)
    figure, axes = plt.subplots(figsize=(13, 0.9 + 0.24 * len(rows)), layout="constrained")
    for y, row in enumerate(rows):
        colour = COLOURS.get(row.service, "#777777")
        bars = [(one.start_s - begin_s, max(one.end_s - one.start_s, 0.02)) for one in row.spans]
        edges = ["black" if one.failed else colour for one in row.spans]
        axes.broken_barh(bars, (y - 0.38, 0.76), facecolors=colour, edgecolors=edges, linewidth=0.6)
        for name, marker in (("twist", "^"), ("vote", "v")):
            at = [stamp_s - begin_s for one in row.spans for kind, stamp_s, _ in one.events if kind == name]
            axes.plot(at, [y] * len(at), linestyle="", marker=marker, markersize=4, color="black")
    axes.set_yticks(range(len(rows)), [row.label.replace("  ", "    ") for row in rows], ha="left", fontsize=8)
    axes.tick_params(axis="y", pad=235, length=0)
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.set_xlim(left=0.0)
    axes.grid(axis="x", alpha=0.3)
    axes.set_xlabel("seconds since the first word; triangle up: the first velocity sent, down: a vote", fontsize=8)
    axes.set_title(_title(whole), fontsize=9)
    used = [name for name in SERVICES if any(row.service == name for row in rows)]
    axes.legend(handles=[Patch(color=COLOURS[name], label=name) for name in used], fontsize=8, loc="lower left")
    file.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(file, dpi=110)
    plt.close(figure)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mission", nargs="?", default="", help="its id, or the beginning of it; none = the newest")
    parser.add_argument("--traces", type=Path, required=True, help="the folder that ATOM_TRACES names")
    parser.add_argument("--out", type=Path, help="the picture; out/traces/<id>.png by default")
    options = parser.parse_args()
    try:
        whole, spans = of_mission(spans_in(options.traces), options.mission)
    except NoSuchTraceError as error:
        sys.stderr.write(f"{error} ({options.traces})\n")
        return 1
    rows = rows_of(spans)
    file = options.out or Path("out/traces") / f"{whole.attributes['mission.id'][:12]}.png"
    draw(whole, rows, file)
    sys.stdout.write(f"{told(whole, rows)}\n{file}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
