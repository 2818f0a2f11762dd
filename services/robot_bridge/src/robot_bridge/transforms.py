"""Where things are and were: the robot's planar pose over time, and the fixed frames of its sensors."""

import math
import threading
from bisect import bisect_right
from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray
from pytransform3d.transformations import (  # pyright: ignore[reportMissingTypeStubs]
    transform_from_pq,  # pyright: ignore[reportUnknownVariableType]
)

from contracts.geometry import Point3D, Pose2D

Matrix = NDArray[np.float64]

HISTORY_S = 20.0
"""How far back a pose can be asked for."""
EXTRAPOLATION_S = 0.25
"""How far past the newest sample the newest pose still counts as the pose then."""


def wrap(angle_rad: float) -> float:
    """The same angle in (-pi, pi]."""
    return -((math.pi - angle_rad) % (2.0 * math.pi) - math.pi)


def compose(a: Pose2D, b: Pose2D) -> Pose2D:
    """`b`, given in the frame that `a` places, in the frame `a` is given in."""
    c, s = math.cos(a.yaw), math.sin(a.yaw)
    return Pose2D(x=a.x + c * b.x - s * b.y, y=a.y + s * b.x + c * b.y, yaw=wrap(a.yaw + b.yaw))


def inverse(pose: Pose2D) -> Pose2D:
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    return Pose2D(x=-c * pose.x - s * pose.y, y=s * pose.x - c * pose.y, yaw=wrap(-pose.yaw))


def apart_m(a: Pose2D, b: Pose2D) -> float:
    return math.hypot(b.x - a.x, b.y - a.y)


def matrix(position_m: tuple[float, float, float], quaternion_xyzw: tuple[float, float, float, float]) -> Matrix:
    """A 4x4 transform from ROS's position and quaternion; raises `ValueError` where they are no transform."""
    x, y, z, w = quaternion_xyzw
    norm = math.sqrt(x * x + y * y + z * z + w * w)
    if not math.isfinite(norm + sum(position_m)) or norm < 1e-6:
        raise ValueError("not a rotation")
    pq = np.array([*position_m, w / norm, x / norm, y / norm, z / norm])
    return cast(Matrix, transform_from_pq(pq))


def planar(transform: Matrix) -> Pose2D:
    """The part of a 4x4 transform that a robot on a floor has."""
    yaw = math.atan2(float(transform[1, 0]), float(transform[0, 0]))
    return Pose2D(x=float(transform[0, 3]), y=float(transform[1, 3]), yaw=yaw)


def in_map(robot: Pose2D, point: Point3D) -> Point3D:
    """A point of base_link in the frame the robot's pose is given in."""
    placed = compose(robot, Pose2D(x=point.x, y=point.y, yaw=0.0))
    return Point3D(x=placed.x, y=placed.y, z=point.z)


@dataclass(frozen=True, slots=True)
class _Sample:
    stamp_s: float
    pose: Pose2D


class _Track:
    """Poses of one frame in another over the last `HISTORY_S`, in the order of their stamps."""

    def __init__(self) -> None:
        self._samples: list[_Sample] = []

    def add(self, stamp_s: float, pose: Pose2D) -> None:
        samples = self._samples
        if samples and stamp_s <= samples[-1].stamp_s:
            if stamp_s > samples[-1].stamp_s - HISTORY_S:
                return  # late or repeated
            samples.clear()  # the clock was set back (a simulation restarted): the past is another world
        samples.append(_Sample(stamp_s, pose))
        if len(samples) > 64 and samples[len(samples) // 2].stamp_s < stamp_s - HISTORY_S:
            del samples[: len(samples) // 2]

    @property
    def newest(self) -> _Sample | None:
        return self._samples[-1] if self._samples else None

    def at(self, stamp_s: float, *, extrapolation_s: float) -> Pose2D | None:
        """Linear between neighbours; none before the first or too long after the last."""
        samples = self._samples
        after = bisect_right(samples, stamp_s, key=lambda sample: sample.stamp_s)
        if after == 0:
            return None
        before = samples[after - 1]
        if after == len(samples):
            return before.pose if stamp_s - before.stamp_s <= extrapolation_s else None
        following = samples[after]
        part = (stamp_s - before.stamp_s) / (following.stamp_s - before.stamp_s)
        a, b = before.pose, following.pose
        return Pose2D(
            x=a.x + part * (b.x - a.x), y=a.y + part * (b.y - a.y), yaw=wrap(a.yaw + part * wrap(b.yaw - a.yaw))
        )


class PoseBuffer:
    """base_link in map at any recent moment: odometry (fast, drifting) composed with map->odom (slow, correcting).

    `map->odom` comes from TF, or from a localiser's pose (`add_localisation`) where TF is silent. Any thread.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._odom_to_base = _Track()
        self._map_to_odom = _Track()
        self._corrected_s: float | None = None
        self._has_tf = False

    def add_odometry(self, stamp_s: float, pose: Pose2D) -> None:
        with self._lock:
            self._odom_to_base.add(stamp_s, pose)

    def add_map_to_odom(self, stamp_s: float, pose: Pose2D, *, received_s: float) -> None:
        with self._lock:
            if not self._has_tf:
                self._map_to_odom = _Track()
                self._has_tf = True
            self._map_to_odom.add(stamp_s, pose)
            self._corrected_s = received_s

    def add_localisation(self, stamp_s: float, pose: Pose2D, *, received_s: float) -> None:
        """A localiser's base_link in map; says where odom must be. Ignored once TF says it itself."""
        with self._lock:
            if self._has_tf:
                return
            newest = self._odom_to_base.newest
            odometry = self._odom_to_base.at(stamp_s, extrapolation_s=1.0)
            if odometry is None and newest is not None:
                odometry = newest.pose
            if odometry is not None:
                self._map_to_odom.add(stamp_s, compose(pose, inverse(odometry)))
                self._corrected_s = received_s

    def age_s(self, now_s: float) -> float | None:
        """Seconds since the localiser last spoke; none while not localised."""
        corrected_s = self._corrected_s
        return max(0.0, now_s - corrected_s) if corrected_s is not None else None

    def newest(self) -> Pose2D | None:
        """base_link in map by the newest odometry; none while not localised."""
        with self._lock:
            odometry, correction = self._odom_to_base.newest, self._map_to_odom.newest
        return compose(correction.pose, odometry.pose) if odometry is not None and correction is not None else None

    def at(self, stamp_s: float) -> Pose2D | None:
        """base_link in map at `stamp_s` (the robot's clock); none when that is not known."""
        with self._lock:
            odometry = self._odom_to_base.at(stamp_s, extrapolation_s=EXTRAPOLATION_S)
            correction = self._map_to_odom.at(stamp_s, extrapolation_s=math.inf)
        return compose(correction, odometry) if odometry is not None and correction is not None else None


class StaticFrames:
    """The fixed tree of frames below base_link (tf_static). Any thread."""

    def __init__(self, base_frame: str = "base_link") -> None:
        self._base_frame = base_frame
        self._parents: dict[str, tuple[str, Matrix]] = {}
        self._resolved: dict[str, Matrix] = {}

    def set_base(self, base_frame: str) -> None:
        self._base_frame = base_frame

    def add(self, parent: str, child: str, child_in_parent: Matrix) -> None:
        """Any order; a later transform of the same child replaces the earlier."""
        parents = dict(self._parents)
        parents[child.lstrip("/")] = (parent.lstrip("/"), child_in_parent)
        self._parents = parents
        self._resolved = {}

    def in_base(self, frame: str) -> Matrix | None:
        """The frame in base_link, 4x4; none when no chain of fixed transforms leads there."""
        frame = frame.lstrip("/")
        if (known := self._resolved.get(frame)) is not None:
            return known
        to_base = self._to_root(self._base_frame)
        to_frame = self._to_root(frame)
        common = next((name for name in to_frame if name in to_base), None)
        if common is None:
            return None
        resolved = np.linalg.inv(to_base[common]) @ to_frame[common]
        self._resolved = {**self._resolved, frame: resolved}
        return resolved

    def _to_root(self, frame: str) -> dict[str, Matrix]:
        """The frame's transform in itself and in each of its ancestors, nearest first."""
        found: dict[str, Matrix] = {frame: np.eye(4)}
        transform = np.eye(4)
        while (step := self._parents.get(frame)) is not None:
            frame, in_parent = step
            if frame in found:  # a loop is a robot's mistake, not ours to hang on
                break
            transform = in_parent @ transform
            found[frame] = transform
        return found
