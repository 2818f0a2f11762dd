"""Rigid transforms as arrays and as planar poses."""

import math
from typing import cast

import numpy as np
from numpy.typing import NDArray
from pytransform3d.rotations import active_matrix_from_angle  # pyright: ignore[reportUnknownVariableType]
from pytransform3d.transformations import (
    transform_from,  # pyright: ignore[reportUnknownVariableType]
    transform_from_pq,  # pyright: ignore[reportUnknownVariableType]
)

from contracts.geometry import Point3D, Pose2D
from geometry.poses import compose

Matrix = NDArray[np.float64]
"""(4, 4) homogeneous: a frame's pose in another, or what moves points from the first into the second."""


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


def upright(pose: Pose2D) -> Matrix:
    """A planar pose as a transform in space."""
    return cast(Matrix, transform_from(active_matrix_from_angle(2, pose.yaw), np.array([pose.x, pose.y, 0.0])))
