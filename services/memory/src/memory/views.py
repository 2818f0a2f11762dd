"""Sightings that say the same count once: same thing (or label and colour), 0.25 m cell, 30 degree sector (pure)."""

import math
from dataclasses import dataclass, replace

from contracts.geometry import Pose2D
from contracts.memory import Observation
from memory.belief import FIRST, after_sighting
from memory.frames import Frame

CELL_M = 0.25
SECTORS = 12
SECTOR_RAD = 2.0 * math.pi / SECTORS
LOOKED_M = 0.4
LOOKED_RAD = math.radians(20.0)
"""A look from this near a view's place, in a direction this near to its own, shows what the view showed."""
LOOKED_AGAIN_S = 2.0


@dataclass(frozen=True, slots=True)
class ViewCell:
    """What makes two sightings the same view. `thing_id` is none where the thing's own place was not measured; only
    then is `colour` part of it (empty: not known), for else it is the thing's."""

    label: str
    colour: str
    cell_x: int
    cell_y: int
    sector: int
    thing_id: int | None = None
    map_number: int = 0


@dataclass(frozen=True, slots=True)
class AggregatedView:
    """What is kept of all sightings of one place: how many, the last, and the best with the pose it had.

    `belief` is used where there is no thing whose belief it would be.
    """

    place: ViewCell
    pose: Pose2D
    confidence: float
    last_seen_s: float
    count: int = 1
    belief: float = FIRST


def view_cell(observation: Observation, thing_id: int | None = None, map_number: int = 0) -> ViewCell:
    pose = observation.pose
    return ViewCell(
        label=observation.label,
        colour="" if thing_id is not None else observation.colour or "",
        cell_x=math.floor(pose.x / CELL_M),
        cell_y=math.floor(pose.y / CELL_M),
        sector=math.floor((pose.yaw % (2.0 * math.pi)) / SECTOR_RAD) % SECTORS,
        thing_id=thing_id,
        map_number=map_number,
    )


def view_of(observation: Observation, thing_id: int | None = None, map_number: int = 0) -> AggregatedView:
    return AggregatedView(
        view_cell(observation, thing_id, map_number),
        observation.pose,
        observation.confidence,
        observation.stamp_s,
        belief=after_sighting(FIRST, observation.confidence),
    )


def merged(old: AggregatedView, new: AggregatedView) -> AggregatedView:
    """Both are of one place. On equal confidence the older pose stays, so that a parked robot rewrites nothing."""
    best = new if new.confidence > old.confidence else old
    return replace(
        old,
        pose=best.pose,
        confidence=best.confidence,
        last_seen_s=max(old.last_seen_s, new.last_seen_s),
        count=old.count + new.count,
        belief=max(old.belief, new.belief),
    )


def view_at(
    label: str,
    colour: str,
    pose: Pose2D,
    *,
    confidence: float,
    last_seen_s: float,
    count: int,
    thing_id: int | None,
    map_number: int,
) -> AggregatedView:
    """A view that comes from elsewhere, put in its place."""
    observation = Observation(label=label, colour=colour or None, pose=pose, confidence=confidence, stamp_s=last_seen_s)
    return replace(view_of(observation, thing_id, map_number), count=count)


def contradicted(label: str, pose: Pose2D, believed_s: float, frame: Frame) -> bool:
    """Whether the frame looked from about there in about that direction for such a thing, and saw none."""
    return (
        label not in frame.seen_labels
        and (frame.looked_for is None or label in frame.looked_for)
        and frame.stamp_s > believed_s + LOOKED_AGAIN_S
        and math.hypot(pose.x - frame.pose.x, pose.y - frame.pose.y) <= LOOKED_M
        and abs(math.remainder(pose.yaw - frame.pose.yaw, 2.0 * math.pi)) <= LOOKED_RAD
    )
