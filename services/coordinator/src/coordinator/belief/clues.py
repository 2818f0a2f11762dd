"""What speaks for a place before anything was looked at: memory's things, and what usually stands near what."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from contracts.memory import RecalledView, RememberedObject
from contracts.vision import Target
from geometry.poses import wrap


@dataclass(frozen=True, slots=True)
class Clue:
    """A place in map. Of the thing itself, `weight` is how probably it is there; else how many times more probable the
    places round it are than others.
    """

    x: float
    y: float
    sigma_m: float
    weight: float
    why: str
    itself: bool = True


SIGMA_M_MIN = 0.15
VIEW_AHEAD_M, VIEW_SIGMA_M = 2.5, 1.2
"""Of a view without a measured place: somewhere before the camera, more often far than near."""
VIEW_SHARE = 0.5
SHOWN_RAD, SHOWN_M = 0.6, 8.0
"""What such a view shows lies in this direction of it, and so near: of a thing in it whose place is known it tells
nothing new.
"""
ITSELF_MAX = 0.85
"""Things are carried about: memory alone is never surer than this that one stands where it stood."""
CLEARLY_WORSE = 0.5
"""Of another's agreement with the description: another colour (0.15), and not an unknown one (0.6; memory's recall)."""
NEAR_SIGMA_M = 1.2
TIMES_NEAR, TIMES_SAME = 2.5, 2.0
NEAR_MAX = 40

_KITCHEN = ("refrigerator", "oven", "sink", "microwave", "toaster", "dining table")
_LIVING = ("couch", "tv", "bed", "dining table")
_DESK = ("laptop", "keyboard", "mouse", "tv", "dining table")
_BATH = ("sink", "toilet")
_HALL = ("bed", "couch", "bench", "chair")
NEAR: dict[str, tuple[str, ...]] = {
    **dict.fromkeys(
        ("bottle", "wine glass", "cup", "fork", "knife", "spoon", "bowl", "banana", "apple", "sandwich", "orange",
         "broccoli", "carrot", "hot dog", "pizza", "donut", "cake", "toaster", "microwave", "oven", "sink",
         "refrigerator"), _KITCHEN),
    **dict.fromkeys(
        ("remote", "teddy bear", "vase", "potted plant", "clock", "cat", "dog", "bird", "tv", "couch"), _LIVING),
    **dict.fromkeys(("book", "laptop", "mouse", "keyboard", "cell phone", "scissors"), _DESK),
    **dict.fromkeys(("toothbrush", "hair drier", "toilet"), _BATH),
    **dict.fromkeys(("backpack", "handbag", "suitcase", "umbrella", "tie"), _HALL),
    **dict.fromkeys(("chair", "dining table"), ("dining table", "chair")),
}  # fmt: skip
"""By hand, from what homes are like. A class without an entry may be anywhere: what lives out of doors, mostly."""


def clues(target: Target, recalled: Sequence[RecalledView], things: Sequence[RememberedObject]) -> tuple[Clue, ...]:
    """From what memory recalls of the target, and from all the things that it remembers."""
    own: dict[tuple[float, float], Clue] = {}
    agrees: dict[tuple[float, float], float] = {}
    unplaced: set[tuple[float, float]] = set()
    placed = [one.thing for one in recalled if one.thing is not None]
    for one in recalled:
        if one.thing is None and any(_shows(one, thing) for thing in placed):
            continue
        clue = _of(one)
        place = (clue.x, clue.y)
        if place not in own or own[place].weight < clue.weight:
            own[place], agrees[place] = clue, one.parts.agreement if one.parts is not None else 1.0
        if one.thing is None:
            unplaced.add(place)
    own |= _as_of_one_thing({place: own[place] for place in unplaced})
    own = {place: replace(clue, weight=clue.weight * _unexplained(place, own, agrees)) for place, clue in own.items()}
    near = [clue for thing in things if (clue := _near(target, thing)) is not None]
    return (*own.values(), *near[:NEAR_MAX])


def _unexplained(
    place: tuple[float, float], own: Mapping[tuple[float, float], Clue], agrees: Mapping[tuple[float, float], float]
) -> float:
    """The probability that the target is none of the things that fit the description clearly better. A blue suitcase
    may be the yellow one, seen in a bad light; it hardly is where memory has a yellow one elsewhere."""
    better = (own[other].weight for other in own if agrees[place] < CLEARLY_WORSE * agrees[other])
    return math.prod(1.0 - weight for weight in better)


def _as_of_one_thing(views: Mapping[tuple[float, float], Clue]) -> dict[tuple[float, float], Clue]:
    """Many views without a distance may all show one thing: together they are worth what the best of them is."""
    total = sum(clue.weight for clue in views.values())
    best = max((clue.weight for clue in views.values()), default=0.0)
    return {place: replace(clue, weight=clue.weight * best / total) for place, clue in views.items() if total > 0.0}


def _of(recalled: RecalledView) -> Clue:
    view, thing, parts = recalled.view, recalled.thing, recalled.parts
    share = parts.relation * parts.agreement if parts is not None else 1.0
    why = recalled.reason or f"{view.label} seen before"
    if thing is not None:
        weight = min(ITSELF_MAX, thing.belief * share)
        return Clue(thing.position.x, thing.position.y, max(SIGMA_M_MIN, thing.uncertainty_m), weight, why)
    pose = recalled.pose or view.pose
    x, y = pose.x + VIEW_AHEAD_M * math.cos(pose.yaw), pose.y + VIEW_AHEAD_M * math.sin(pose.yaw)
    weight = (parts.belief if parts is not None else 0.5) * view.confidence * share
    return Clue(x, y, VIEW_SIGMA_M, min(ITSELF_MAX, weight * VIEW_SHARE), why)


def _shows(recalled: RecalledView, thing: RememberedObject) -> bool:
    pose, at = recalled.pose or recalled.view.pose, thing.position
    bearing_rad = math.atan2(at.y - pose.y, at.x - pose.x)
    near = math.hypot(at.x - pose.x, at.y - pose.y) <= SHOWN_M
    return near and abs(wrap(bearing_rad - pose.yaw)) <= SHOWN_RAD


def _near(target: Target, thing: RememberedObject) -> Clue | None:
    times = TIMES_SAME if thing.label == target.label else TIMES_NEAR
    if thing.label != target.label and thing.label not in NEAR.get(target.label, ()):
        return None
    times = 1.0 + (times - 1.0) * thing.belief
    return Clue(thing.position.x, thing.position.y, NEAR_SIGMA_M, times, f"near the {thing.label}", itself=False)
