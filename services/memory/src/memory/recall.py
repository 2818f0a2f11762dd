"""Where to look for a thing, best place first (requirement A5); pure."""

import math
import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from enum import IntEnum

from contracts.coco import COLOURS
from contracts.geometry import Pose2D
from contracts.memory import RecalledView, RecallRequest, View

SAME_DIRECTION_RAD = math.radians(60.0)
SAME_PLACE_M = 0.05
"""Nobody is sent twice to one place, whatever separation was asked for."""
SPELLINGS = {"gray": "grey", "violet": "purple"}
WORD = re.compile(r"[a-z]+")


class Agreement(IntEnum):
    """How a view's colour goes with the colours asked for, best first."""

    AGREES = 0
    UNKNOWN = 1
    """Either colour is not known."""
    DIFFERS = 2


def rank(
    request: RecallRequest, of_memory_object: Sequence[View], of_label: Sequence[View]
) -> tuple[RecalledView, ...]:
    """The memory object's views, then the label's own.

    Within each: views of the colour asked for, of unknown colour, of another colour; then by confidence, and of equals
    the nearer to `request.pose`. A view close to a chosen one that looks the same way is left out.
    """
    wanted = colours_in(request.description, request.label)
    groups = [("label", of_label)]
    if request.memory_object is not None and request.memory_object != request.label:
        groups.insert(0, ("memory_object", of_memory_object))
    chosen: list[RecalledView] = []
    taken = Taken(max(request.min_separation_m, SAME_PLACE_M))
    for source, views in groups:
        for view in _best_first(views, wanted, request.pose):
            if len(chosen) == request.limit:
                return tuple(chosen)
            if taken.claims(view.pose):
                chosen.append(
                    RecalledView(view=view, source=source, reason=_reason(view, source, wanted, request.label))
                )
    return tuple(chosen)


def colours_in(description: str, label: str = "") -> frozenset[str]:
    """The colour words a description asks for. Of an orange, "orange" is the name unless it is said twice."""
    said: list[str] = WORD.findall(description.lower())
    words = [SPELLINGS.get(word, word) for word in said]
    if label == "orange" and words.count("orange") < 2:
        words = [word for word in words if word != "orange"]
    return frozenset(word for word in words if word in COLOURS)


class Taken:
    """Poses already chosen, in buckets as wide as the separation: each claim looks at nine of them, not at all."""

    def __init__(self, separation_m: float) -> None:
        self._separation_m = separation_m
        self._buckets: dict[tuple[int, int], list[Pose2D]] = defaultdict(list)

    def claims(self, pose: Pose2D) -> bool:
        """True, and the place is taken, unless a taken one is that near and looks the same way within 60 degrees."""
        if any(self._alike(pose, other) for other in self._around(pose)):
            return False
        self._buckets[self._bucket(pose)].append(pose)
        return True

    def _alike(self, one: Pose2D, other: Pose2D) -> bool:
        turn = abs(math.remainder(one.yaw - other.yaw, 2.0 * math.pi))
        return turn < SAME_DIRECTION_RAD and math.hypot(one.x - other.x, one.y - other.y) < self._separation_m

    def _around(self, pose: Pose2D) -> Iterator[Pose2D]:
        column, row = self._bucket(pose)
        for c in (column - 1, column, column + 1):
            for r in (row - 1, row, row + 1):
                yield from self._buckets.get((c, r), ())

    def _bucket(self, pose: Pose2D) -> tuple[int, int]:
        return math.floor(pose.x / self._separation_m), math.floor(pose.y / self._separation_m)


def _best_first(views: Iterable[View], wanted: frozenset[str], here: Pose2D | None) -> list[View]:
    def key(view: View) -> tuple[int, float, float, int]:
        away_m = 0.0 if here is None else math.hypot(view.pose.x - here.x, view.pose.y - here.y)
        return _agreement(view, wanted), -view.confidence, away_m, view.id

    return sorted(views, key=key)


def _agreement(view: View, wanted: frozenset[str]) -> Agreement:
    if not wanted or view.colour is None:
        return Agreement.UNKNOWN
    return Agreement.AGREES if SPELLINGS.get(view.colour, view.colour) in wanted else Agreement.DIFFERS


def _reason(view: View, source: str, wanted: frozenset[str], label: str) -> str:
    thing = f"{view.colour} {view.label}" if view.colour else view.label
    told = f"saw {thing} from here with confidence {view.confidence:.2f}"
    if source == "memory_object":
        told = f"{told}, where {label} may be near"
    match _agreement(view, wanted):
        case Agreement.AGREES:
            return f"{told}: the colour asked for"
        case Agreement.DIFFERS:
            return f"{told}: not the colour asked for"
        case Agreement.UNKNOWN:
            return f"{told}: colour not known" if wanted else told
