"""Sightings that say the same count once: same label and colour, same 0.25 m cell, same 30 degree sector (pure)."""

import math
import unicodedata
from collections.abc import Iterable
from dataclasses import dataclass

from contracts.geometry import Pose2D
from contracts.memory import Observation
from contracts.vision import Detections

CELL_M = 0.25
SECTORS = 12
SECTOR_RAD = 2.0 * math.pi / SECTORS


@dataclass(frozen=True, slots=True)
class Place:
    """What makes two sightings the same view. `colour` is empty where it is not known."""

    label: str
    colour: str
    cell_x: int
    cell_y: int
    sector: int


@dataclass(frozen=True, slots=True)
class Sighting:
    """What is kept of all sightings of one place: how many, the last, and the best with the pose it had."""

    place: Place
    pose: Pose2D
    confidence: float
    last_seen_s: float
    count: int = 1


def place_of(observation: Observation) -> Place:
    pose = observation.pose
    return Place(
        label=observation.label,
        colour=observation.colour or "",
        cell_x=math.floor(pose.x / CELL_M),
        cell_y=math.floor(pose.y / CELL_M),
        sector=math.floor((pose.yaw % (2.0 * math.pi)) / SECTOR_RAD) % SECTORS,
    )


def sighting_of(observation: Observation) -> Sighting:
    return Sighting(place_of(observation), observation.pose, observation.confidence, observation.stamp_s)


def merged(old: Sighting, new: Sighting) -> Sighting:
    """Both are of one place. On equal confidence the older pose stays, so that a parked robot rewrites nothing."""
    best = new if new.confidence > old.confidence else old
    last_seen_s = max(old.last_seen_s, new.last_seen_s)
    return Sighting(old.place, best.pose, best.confidence, last_seen_s, old.count + new.count)


def merge(observations: Iterable[Observation]) -> dict[Place, Sighting]:
    """One sighting a place, in the order the places first came."""
    found: dict[Place, Sighting] = {}
    for observation in observations:
        new = sighting_of(observation)
        old = found.get(new.place)
        found[new.place] = new if old is None else merged(old, new)
    return found


@dataclass(frozen=True, slots=True)
class Exclusion:
    """Labels that are never kept; case, surrounding space and look-alike letter forms do not get round it."""

    labels: frozenset[str]

    @classmethod
    def of(cls, labels: Iterable[str]) -> "Exclusion":
        return cls(frozenset(_plain(label) for label in labels))

    def __contains__(self, label: str) -> bool:
        return _plain(label) in self.labels


def _plain(label: str) -> str:
    return unicodedata.normalize("NFKC", label).strip().casefold()


def observations_of(message: Detections, excluded: Exclusion, confidence_min: float) -> list[Observation]:
    """What of one frame is worth remembering; nothing where the robot did not know where it was."""
    if message.pose is None:
        return []
    return [
        Observation(
            label=detection.label,
            confidence=detection.confidence,
            pose=message.pose,
            stamp_s=message.stamp_s,
            colour=detection.colour if (detection.colour or "").isprintable() else None,
        )
        for detection in message.detections
        if detection.confidence >= confidence_min and detection.label not in excluded
    ]
