"""Observations and views for tests, by hand and by hypothesis."""

import math

from hypothesis import strategies as st

from contracts.geometry import Pose2D
from contracts.memory import Observation, View


def seen(
    label: str = "bottle",
    x: float = 0.0,
    y: float = 0.0,
    yaw: float = 0.0,
    *,
    confidence: float = 0.5,
    stamp_s: float = 1.0,
    colour: str | None = None,
) -> Observation:
    pose = Pose2D(x=x, y=y, yaw=yaw)
    return Observation(label=label, confidence=confidence, pose=pose, stamp_s=stamp_s, colour=colour)


def view(number: int, observation: Observation) -> View:
    return View(id=number, **observation.model_dump())


labels = st.sampled_from(["bottle", "cup", "teddy bear", "'; DROP TABLE views; --", "käse", "%", "a/b"])
poses = st.builds(
    Pose2D,
    x=st.floats(-2.0, 2.0),
    y=st.floats(-2.0, 2.0),
    yaw=st.floats(-2.0 * math.pi, 2.0 * math.pi),
)
observations = st.builds(
    Observation,
    label=labels,
    confidence=st.one_of(st.sampled_from([0.25, 0.5, 0.75]), st.floats(0.0, 1.0)),
    pose=poses,
    stamp_s=st.floats(0.0, 1e6),
    colour=st.sampled_from([None, "red", "blue"]),
)
