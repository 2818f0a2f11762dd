"""What memory's things come to: how many there are, at how many places, and what changed. Pure."""

import math
from collections.abc import Sequence

from contracts.memory import ObjectState, RememberedObject

ONE_PLACE_M = 1.0
THERE = frozenset((ObjectState.PRESENT, ObjectState.DOUBTFUL))
GONE = frozenset((ObjectState.LOST, ObjectState.MOVED))


def tally(things: Sequence[RememberedObject], what: str, colour: str | None) -> str:
    """'2 of them (bottle), at 2 places; ...'. What is gone, doubtful or of an unknown colour is told apart."""
    there = [one for one in things if one.state in THERE and (colour is None or one.colour == colour)]
    doubtful = sum(one.state is ObjectState.DOUBTFUL for one in there)
    gone = sum(one.state is ObjectState.LOST for one in things if colour is None or one.colour == colour)
    unsure = sum(one.state in THERE and one.colour is None for one in things) if colour is not None else 0
    if not there and not gone and not unsure:
        return f"I remember none ({what})."
    parts = [f"I remember {len(there)} ({what})" + (f", at {_in_words(places(there))}" if there else "")]
    parts += [f"{doubtful} of them may be gone"] if doubtful else []
    parts += [f"{unsure} more of a colour I do not know"] if unsure else []
    parts += [f"{gone} more I looked for and did not see again"] if gone else []
    return "; ".join(parts) + "."


def places(things: Sequence[RememberedObject]) -> int:
    """Things within a metre of one another stand at one place."""
    marks: list[RememberedObject] = []
    for one in things:
        if all(apart_m(one, mark) > ONE_PLACE_M for mark in marks):
            marks.append(one)
    return len(marks)


def changes(things: Sequence[RememberedObject], since_s: float) -> list[tuple[str, RememberedObject]]:
    """('moved' | 'gone' | 'new', thing) for what changed after `since_s`, newest first."""
    found: list[tuple[float, str, RememberedObject]] = []
    for one in things:
        if one.state is ObjectState.LOST and (one.last_missed_s or 0.0) >= since_s:
            found.append((one.last_missed_s or 0.0, "gone", one))
        elif one.state in THERE and one.first_seen_s >= since_s:
            found.append((one.first_seen_s, "moved" if one.moved_from is not None else "new", one))
    return [(what, one) for _, what, one in sorted(found, key=lambda three: -three[0])]


def _in_words(count: int) -> str:
    return "one place" if count == 1 else f"{count} places"


def apart_m(one: RememberedObject, other: RememberedObject) -> float:
    return math.hypot(one.position.x - other.position.x, one.position.y - other.position.y)
