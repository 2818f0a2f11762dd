"""One frame as memory takes it: what was seen, and what should have been (pure)."""

import math
import unicodedata
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import groupby

from contracts.description import RobotDescription
from contracts.geometry import Pose2D
from contracts.measuring import Measurement
from contracts.memory import Look, Observation
from contracts.vision import Detection, Detections
from geometry.boxes import iou

SAME_BOX = 0.6
"""Two boxes of one label that overlap by this share of their union are one thing, drawn twice."""


@dataclass(frozen=True, slots=True)
class Miss:
    """A thing that should have been seen and was not: with which chance one look from there shows it."""

    thing_id: int
    label: str
    detectability: float


@dataclass(frozen=True, slots=True)
class Frame:
    """What one picture says. `looked_for`: the labels whose absence means something; none: every label.

    `misses` were judged before the frame's sightings were matched: a thing that is matched after all is seen.
    """

    pose: Pose2D
    stamp_s: float
    seen: tuple[Observation, ...] = ()
    misses: tuple[Miss, ...] = ()
    is_look: bool = False
    looked_for: frozenset[str] | None = None
    seen_labels: frozenset[str] = frozenset()
    """Also of boxes that are not remembered from here, such as those of POST /looks."""
    map_number: int = 0
    """Of the map that the pose is in."""


def frames_of(observations: Sequence[Observation], map_number: int = 0) -> list[Frame]:
    """Observations with one stamp and pose, sent together, are of one frame."""
    return [
        Frame(pose=pose, stamp_s=stamp_s, seen=tuple(group), map_number=map_number)
        for (stamp_s, pose), group in groupby(observations, key=lambda one: (one.stamp_s, one.pose))
    ]


def not_after(frame: Frame, now_s: float) -> Frame:
    """A stamp from the future says that two clocks differ: what it tells was seen now."""
    if frame.stamp_s <= now_s:
        return frame
    seen = tuple(one.model_copy(update={"stamp_s": now_s}) for one in frame.seen)
    return replace(frame, stamp_s=now_s, seen=seen)


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


def worth_keeping(message: Detections, excluded: Exclusion, confidence_min: float) -> list[Detection]:
    """What of one frame is worth remembering; a thing boxed twice counts once, with its surer box."""
    kept: list[Detection] = []
    for one in sorted(message.detections, key=lambda detection: -detection.confidence):
        if one.confidence < confidence_min or one.label in excluded or not one.label.isprintable():
            continue
        if any(one.label == other.label and iou(one.bbox_xyxy, other.bbox_xyxy) > SAME_BOX for other in kept):
            continue
        kept.append(one)
    return kept


def observations(
    message: Detections, pose: Pose2D, excluded: Exclusion, confidence_min: float
) -> tuple[Observation, ...]:
    """What one frame says of things, each with its place where it was measured. `pose`: the robot's, in map."""
    return tuple(_observation(message, pose, one) for one in worth_keeping(message, excluded, confidence_min))


def _observation(message: Detections, pose: Pose2D, one: Detection) -> Observation:
    measured = one.measurement or Measurement()
    return Observation(
        label=one.label,
        confidence=one.confidence,
        pose=pose,
        stamp_s=message.stamp_s,
        colour=one.colour if (one.colour or "").isprintable() else None,
        position=measured.map_point,
        sigma_m=measured.sigma_m,
    )


@dataclass(frozen=True, slots=True)
class Camera:
    """A level pinhole camera on the robot's x axis, as robot_bridge describes it."""

    hfov_rad: float
    height_m: float
    forward_m: float

    @classmethod
    def on(cls, robot: RobotDescription) -> "Camera":
        place = robot.camera.position_in_base
        return cls(hfov_rad=robot.camera.hfov_rad, height_m=place.z, forward_m=place.x)

    def of(self, look: Look) -> "Camera":
        return self if look.hfov_rad is None else replace(self, hfov_rad=look.hfov_rad)


@dataclass(frozen=True, slots=True)
class Projected:
    """Where a point of the map is in a picture: px, how far from the camera (m, horizontally), and how far ahead of it
    (m, along the optical axis)."""

    u: float
    v: float
    distance_m: float
    ahead_m: float
    focal_px: float

    def box(self, radius_m: float) -> tuple[float, float, float, float]:
        half = max(2.0, radius_m / self.distance_m * self.focal_px)
        return self.u - half, self.v - half, self.u + half, self.v + half


def project(
    point: tuple[float, float, float], pose: Pose2D, camera: Camera, size_px: tuple[int, int]
) -> Projected | None:
    """None where the point is not in front of the camera."""
    eye_x = pose.x + camera.forward_m * math.cos(pose.yaw)
    eye_y = pose.y + camera.forward_m * math.sin(pose.yaw)
    dx, dy = point[0] - eye_x, point[1] - eye_y
    ahead = dx * math.cos(pose.yaw) + dy * math.sin(pose.yaw)
    left = -dx * math.sin(pose.yaw) + dy * math.cos(pose.yaw)
    if ahead < 0.05:
        return None
    focal_px = size_px[0] / (2.0 * math.tan(camera.hfov_rad / 2.0))
    return Projected(
        u=size_px[0] / 2.0 - focal_px * left / ahead,
        v=size_px[1] / 2.0 - focal_px * (point[2] - camera.height_m) / ahead,
        distance_m=math.hypot(dx, dy),
        ahead_m=ahead,
        focal_px=focal_px,
    )


@dataclass(frozen=True, slots=True)
class Tally:
    """What a look did to what was remembered."""

    confirmed: int = 0
    missed: int = 0
    undetermined: int = 0
