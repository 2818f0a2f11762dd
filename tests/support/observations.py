"""Observations, looks and views for tests, by hand and by hypothesis."""

import math
from typing import Any

from hypothesis import strategies as st

from contracts.geometry import Point3D, Pose2D
from contracts.memory import Look, Observation, RecallRequest, SeenBox
from contracts.vision import Target
from memory.belief import FIRST, after_sighting
from memory.ports import StoredView

HFOV_RAD = 0.942
SIDE_PX = 250


def seen(
    label: str = "bottle",
    x: float = 0.0,
    y: float = 0.0,
    yaw: float = 0.0,
    *,
    confidence: float = 0.5,
    stamp_s: float = 1.0,
    colour: str | None = None,
    at: tuple[float, float] | tuple[float, float, float] | None = None,
) -> Observation:
    """`at` is where the thing itself is."""
    pose = Pose2D(x=x, y=y, yaw=yaw)
    position = Point3D(x=at[0], y=at[1], z=at[2] if len(at) == 3 else 0.3) if at is not None else None
    return Observation(label=label, confidence=confidence, pose=pose, stamp_s=stamp_s, colour=colour, position=position)


def asking(label: str, description: str = "", **more: Any) -> RecallRequest:
    return RecallRequest(target=Target(label=label, description=description or label), **more)


def look(
    x: float = 0.0,
    y: float = 0.0,
    yaw: float = 0.0,
    *boxes: SeenBox,
    stamp_s: float = 2.0,
    far_m: float | None = 5.0,
    labels: tuple[str, ...] | None = None,
) -> Look:
    """With nothing nearer than `far_m` in the picture; none: without any depth."""
    return Look(
        pose=Pose2D(x=x, y=y, yaw=yaw),
        stamp_s=stamp_s,
        image_width_px=SIDE_PX,
        image_height_px=SIDE_PX,
        hfov_rad=HFOV_RAD,
        seen=boxes,
        labels=labels,
        ranges_m=None if far_m is None else (far_m,) * 16,
    )


def view(number: int, observation: Observation, thing_id: int | None = None) -> StoredView:
    return StoredView(
        id=number,
        label=observation.label,
        colour=observation.colour or "",
        x=observation.pose.x,
        y=observation.pose.y,
        yaw=observation.pose.yaw,
        confidence=observation.confidence,
        last_seen_s=observation.stamp_s,
        count=1,
        belief=after_sighting(FIRST, observation.confidence),
        believed_s=observation.stamp_s,
        map_number=0,
        thing_id=thing_id,
    )


labels = st.sampled_from(["bottle", "cup", "teddy bear", "'; DROP TABLE views; --", "käse", "%", "a/b"])
poses = st.builds(
    Pose2D,
    x=st.floats(-2.0, 2.0),
    y=st.floats(-2.0, 2.0),
    yaw=st.floats(-2.0 * math.pi, 2.0 * math.pi),
)
positions = st.builds(Point3D, x=st.floats(-2.0, 2.0), y=st.floats(-2.0, 2.0), z=st.floats(0.0, 1.0))
observations = st.builds(
    Observation,
    label=labels,
    confidence=st.one_of(st.sampled_from([0.25, 0.5, 0.75]), st.floats(0.0, 1.0)),
    pose=poses,
    stamp_s=st.floats(0.0, 1e6),
    colour=st.sampled_from([None, "red", "blue"]),
    position=st.one_of(st.none(), positions),
)
