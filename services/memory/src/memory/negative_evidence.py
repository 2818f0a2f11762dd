"""Which remembered things a look should have shown (pure): in view, in range, and not behind something."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from contracts.geometry import Pose2D
from contracts.measuring import Measurement
from contracts.memory import Look
from geometry.grids import OccupancyGrid
from memory.belief import detectability
from memory.class_priors import kind_of
from memory.frames import Camera, Miss, Projected, project
from memory.objects import MapObject

MARGIN = 0.12
"""Of the picture: nearer to its border a thing may be out of view by the error of the robot's pose alone."""
NEAR_M_MIN = 0.35
CHANCE_MIN = 0.1
"""Below this a look says nothing."""
HIDDEN_M = 0.25
"""Something nearer than the thing by more than this hides it."""
SIZE_M = 0.08
"""Half the width of the piece of the picture whose depth is asked for."""
BEFORE_IT_M = 0.6
"""The map may be occupied this near to a thing: what it stands on."""


@dataclass(frozen=True, slots=True)
class Expected:
    """A thing that a look should show, if nothing hides it."""

    thing: MapObject
    at: Projected
    chance: float

    @property
    def box(self) -> tuple[float, float, float, float]:
        return self.at.box(SIZE_M)

    def miss(self) -> Miss:
        return Miss(self.thing.id, self.thing.label, self.chance)


def expected(look: Look, things: Iterable[MapObject], camera: Camera, range_m: float) -> list[Expected]:
    """Everything that was looked for, in view and in range, whether it was seen or not."""
    size_px = (look.image_width_px, look.image_height_px)
    limit_m = look.range_m if look.range_m is not None else range_m
    found: list[Expected] = []
    for thing in things:
        if look.labels is not None and thing.label not in look.labels:
            continue
        kind = kind_of(thing.label)
        at = project((thing.x, thing.y, thing.z), look.pose, camera.of(look), size_px)
        if at is None or not NEAR_M_MIN <= at.distance_m <= limit_m * kind.reach or not _inside(at, size_px):
            continue
        chance = detectability(at.distance_m, kind.reach, thing.confidence)
        if chance >= CHANCE_MIN:
            found.append(Expected(thing, at, chance))
    return found


def seen_in(one: Expected, look: Look) -> bool:
    """A box of its label covers its place, or was measured near it."""
    radius_m = kind_of(one.thing.label).radius_m
    for box in look.seen:
        if box.label != one.thing.label:
            continue
        if box.position is not None:
            if one.thing.away_m(box.position.x, box.position.y) <= radius_m:
                return True
        elif _near(box.bbox_xyxy, one.at, radius_m):
            return True
    return False


def covered(one: Expected, look: Look) -> bool:
    """A box of any label lies over its place: it may be behind it, or be it under another name."""
    u, v = one.at.u, one.at.v
    return any(
        box.bbox_xyxy[0] <= u <= box.bbox_xyxy[2] and box.bbox_xyxy[1] <= v <= box.bbox_xyxy[3] for box in look.seen
    )


def hidden_by_depth(one: Expected, depth_m: float, sigma_m: float) -> bool:
    """`depth_m` is what was measured in its direction, along the optical axis."""
    return depth_m < one.at.ahead_m - max(HIDDEN_M, 2.0 * sigma_m)


def range_towards(one: Expected, look: Look) -> float | None:
    """Of the look's own columns, the one that shows the thing; none where nothing was measured."""
    if not look.ranges_m:
        return None
    column = int(one.at.u / look.image_width_px * len(look.ranges_m))
    return look.ranges_m[min(max(column, 0), len(look.ranges_m) - 1)]


def clear(ground: OccupancyGrid, pose: Pose2D, thing: MapObject) -> bool:
    """Nothing in the map stands between, but for what is close to the thing itself."""
    away_m = thing.away_m(pose.x, pose.y)
    reach_m = away_m - BEFORE_IT_M
    if reach_m <= 0.0:
        return True
    share = np.arange(0.0, reach_m, ground.resolution_m / 2.0) / away_m
    x, y = pose.x + (thing.x - pose.x) * share, pose.y + (thing.y - pose.y) * share
    return not ground.at(x, y, ground.occupied).any()


def classify(
    look: Look,
    wanted: Sequence[Expected],
    measured: Callable[[Expected], Measurement | None],
    ground: OccupancyGrid | None,
) -> tuple[list[Expected], list[Expected], list[Expected]]:
    """(seen, missing, undetermined). Undetermined: hidden, ambiguous, or what neither depth nor a map can tell."""
    seen: list[Expected] = []
    missing: list[Expected] = []
    undetermined: list[Expected] = []
    for one in wanted:
        if seen_in(one, look):
            seen.append(one)
        elif covered(one, look) or not _in_sight(one, look, measured(one), ground):
            undetermined.append(one)
        else:
            missing.append(one)
    return seen, missing, undetermined


def _in_sight(one: Expected, look: Look, measured: Measurement | None, ground: OccupancyGrid | None) -> bool:
    if ground is not None and not clear(ground, look.pose, one.thing):
        return False
    if measured is not None and measured.depth_m is not None:
        return not hidden_by_depth(one, measured.depth_m, measured.sigma_m or 0.0)
    return ground is not None


def _inside(at: Projected, size_px: tuple[int, int]) -> bool:
    width, height = size_px
    return MARGIN * width <= at.u <= (1.0 - MARGIN) * width and MARGIN * height <= at.v <= (1.0 - MARGIN) * height


def _near(box: Sequence[float], at: Projected, radius_m: float) -> bool:
    """The box's middle is no farther from the expected place than the kind's radius at that distance."""
    u, v = (box[0] + box[2]) / 2.0, (box[1] + box[3]) / 2.0
    return math.hypot(u - at.u, v - at.v) <= max(8.0, radius_m / at.distance_m * at.focal_px)
