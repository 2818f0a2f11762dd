"""Chaining planar frames: map -> odom -> base_link."""

import math

from contracts.geometry import Pose2D


def compose(parent: Pose2D, child: Pose2D) -> Pose2D:
    """A pose given in the frame of `parent`, in the frame that `parent` is given in."""
    c, s = math.cos(parent.yaw), math.sin(parent.yaw)
    return Pose2D(
        x=parent.x + c * child.x - s * child.y,
        y=parent.y + s * child.x + c * child.y,
        yaw=math.remainder(parent.yaw + child.yaw, math.tau),
    )


def inverse(pose: Pose2D) -> Pose2D:
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    return Pose2D(x=-c * pose.x - s * pose.y, y=s * pose.x - c * pose.y, yaw=math.remainder(-pose.yaw, math.tau))
