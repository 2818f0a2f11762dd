"""How people's own sayings are read (tests/data/people.csv): mood, class, colour, restriction, number; by halves."""

import csv
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from contracts.reading import Mood, RestrictionKind
from contracts.vision import ParsedTarget, ParsedTask

TABLE = Path(__file__).parents[1] / "tests" / "data" / "people.csv"
NAMING = frozenset((Mood.FIND, Mood.COUNT))
"""Moods whose thing is compared; '*' in the table stands for any."""

Row = dict[str, str]


def rows(half: str | None = None) -> list[Row]:
    """`half` is 'tuned' or 'held_out'; the held-out half was written first and is never tuned on."""
    every = csv.DictReader(TABLE.read_text(encoding="utf-8").splitlines())
    return [row for row in every if half in {None, row["half"]}]


def faults(row: Row, task: ParsedTask) -> set[str]:
    """What was read wrong: mood, class, colour, restriction, number; 'starts' for a search nobody asked for."""
    mood, found = Mood(row["mood"]), set[str]()
    if task.mood is not mood:
        found.add("mood")
    if mood is not Mood.FIND and starts(task):
        found.add("starts")
    if mood in NAMING:
        found |= _of_the_thing(row, task) | _of_the_restrictions(row, task)
    return found


def starts(task: ParsedTask) -> bool:
    return task.mood is Mood.FIND and bool(known(task))


def report(read: Sequence[tuple[Row, ParsedTask]]) -> dict[str, Any]:
    """Shares right, over the rows each is asked of."""
    right: Counter[str] = Counter()
    for row, task in read:
        wrong = faults(row, task)
        right.update(
            {"whole", "mood", "class", "colour", "restriction", "number"} - wrong - ({"whole"} if wrong else set())
        )
    denied = [(row, task) for row, task in read if row["mood"] == Mood.DENIED]
    unasked = [row["text"] for row, task in read if "starts" in faults(row, task)]
    shares = {name: round(right[name] / max(1, len(read)), 4) for name in sorted(right)}
    return {
        "sayings": len(read),
        "right": shares,
        "denied": len(denied),
        "denied_that_start": sum(starts(task) for _, task in denied),
        "start_though_not_asked": len(unasked),
    }


def known(task: ParsedTask) -> list[ParsedTarget]:
    return [one for one in task.targets if one.yolo_class != "none"]


def _of_the_thing(row: Row, task: ParsedTask) -> set[str]:
    wanted = [one for one in row["class"].split(";") if one not in {"", "none"}]
    if row["class"] == "*":
        return set()
    things = known(task)
    described = things[0].description.split() if things else []
    colours = {*described, *(one.value for one in task.restrictions if one.kind is RestrictionKind.ANY)}
    wrong = {"class"} if [one.yolo_class for one in things] != wanted else set[str]()
    return wrong | ({"colour"} if row["colour"] and row["colour"] not in colours else set())


def _of_the_restrictions(row: Row, task: ParsedTask) -> set[str]:
    wanted = {
        f"not_colour:{colour}" if kind == "not_colour" else kind
        for kind, _, colours in (one.partition(":") for one in row["restriction"].split(";") if one)
        for colour in (colours.split("+") if colours else [""])
    }
    number = RestrictionKind.NUMBER
    told = {
        f"{one.kind.value}:{one.value}" if one.kind is RestrictionKind.NOT_COLOUR else one.kind.value
        for one in task.restrictions
        if one.kind is not number
    }
    said = next((one.value for one in task.restrictions if one.kind is number), "")
    return ({"restriction"} if told != wanted else set[str]()) | ({"number"} if said != row["count"] else set[str]())
