"""What is drawn over a camera frame (requirement A7): the target red with "TARGET:", others green. Pure."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from contracts.geometry import Pose2D
from contracts.vision import Detection, Detections, Target

AGE_S_MAX: Final = 1.0
TURN_RAD_MAX: Final = math.radians(4.0)
MOVE_M_MAX: Final = 0.10
BOXES_MAX: Final = 40


@dataclass(frozen=True, slots=True)
class CameraFrame:
    """A camera picture as robot_bridge gives it; `pose` is base_link in map when it was taken."""

    stamp_s: float
    jpeg: bytes
    width_px: int
    height_px: int
    pose: Pose2D | None


def boxes(frame: CameraFrame, seen: Detections | None, target: Target | None) -> list[Mapping[str, Any]]:
    """Boxes in fractions of the picture's sides. None where the detections are of another view than this frame's."""
    if seen is None or not same_view(frame, seen):
        return []
    width, height = seen.image_width_px, seen.image_height_px
    ordered = sorted(seen.detections, key=lambda one: -one.confidence)[:BOXES_MAX]
    found: list[Mapping[str, Any]] = []
    marked = [(target is not None and target.may_be(one.label, one.colour), one) for one in ordered]
    for wanted, one in sorted(marked, key=lambda two: two[0]):
        left, top, right, bottom = one.bbox_xyxy
        corners = (left / width, top / height, right / width, bottom / height)
        found.append({"at": [round(value, 4) for value in corners], "text": caption(one, wanted), "target": wanted})
    return found


def caption(one: Detection, wanted: bool) -> str:
    colour = f"{one.colour} " if one.colour else ""
    return f"{'TARGET: ' if wanted else ''}{colour}{one.label} {one.confidence:.2f}"


def same_view(frame: CameraFrame, seen: Detections) -> bool:
    """Boxes a little older than the frame still fit it, unless the robot has turned or driven since."""
    if abs(frame.stamp_s - seen.stamp_s) > AGE_S_MAX:
        return False
    if frame.pose is None or seen.pose is None:
        return True
    turned_rad = abs(math.remainder(frame.pose.yaw - seen.pose.yaw, math.tau))
    moved_m = math.dist((frame.pose.x, frame.pose.y), (seen.pose.x, seen.pose.y))
    return turned_rad <= TURN_RAD_MAX and moved_m <= MOVE_M_MAX
