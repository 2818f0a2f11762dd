"""What is drawn over the map, in pixels of the map's picture, by parts that change at different times. Pure."""

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from contracts.geometry import Pose2D
from contracts.laser import LaserScan
from contracts.memory import ObjectState, RememberedObject, View
from contracts.mission import MissionStatus
from contracts.robot import Goal
from ui.map_view import MapFrame

Part = dict[str, Any]


def robot(frame: MapFrame, pose: Pose2D | None, *, fresh: bool) -> Part:
    if pose is None:
        return {"at": None, "fresh": False}
    x, y = frame.to_px(pose.x, pose.y)
    return {
        "at": [round(x, 2), round(y, 2)],
        "turn": round(math.radians(frame.heading_deg(pose.yaw)), 3),
        "fresh": fresh,
        "metres": [round(pose.x, 2), round(pose.y, 2)],
    }


def laser(frame: MapFrame, scan: LaserScan | None, pose: Pose2D | None) -> Part:
    """Points where the beams ended; drawn from where the scan was taken."""
    stood = scan.pose if scan is not None and scan.pose is not None else pose
    if scan is None or stood is None or not scan.points_m:
        return {"points": []}
    points = np.asarray(scan.points_m)
    cos, sin = math.cos(stood.yaw), math.sin(stood.yaw)
    x = stood.x + cos * points[:, 0] - sin * points[:, 1]
    y = stood.y + sin * points[:, 0] + cos * points[:, 1]
    column, row = frame.pixels(x, y)
    return {"points": np.round(np.stack([column, row], axis=1), 1).ravel().tolist()}


def paths(frame: MapFrame, trail: Sequence[Pose2D], planned: Sequence[Pose2D], goal: Goal | None) -> Part:
    """Where it drove, where it means to drive, and the goal it drives to."""
    return {
        "trail": _line(frame, trail),
        "planned": _line(frame, planned),
        "goal": _at(frame, goal.pose) if goal is not None else None,
    }


def search(frame: MapFrame, status: MissionStatus | None) -> Part:
    mission = status.mission if status is not None else None
    todo = status.scan_points if status is not None else ()
    done = status.scan_points_done if status is not None else ()
    target = mission.target_pose if mission is not None else None
    return {
        "todo": [_at(frame, point) for point in todo],
        "done": [_at(frame, point) for point in done],
        "target": _at(frame, target) if target is not None else None,
    }


def remembered(frame: MapFrame, objects: Iterable[RememberedObject], views: Iterable[View], *, now_s: float) -> Part:
    """Things by belief and age, and the places they were seen from."""
    return {
        "objects": [
            {
                "id": one.id,
                "at": [round(value, 1) for value in frame.to_px(one.position.x, one.position.y)],
                "text": one.description,
                "belief": round(one.belief, 2),
                "gone": one.state in {ObjectState.LOST, ObjectState.MOVED},
                "hours": round(max(0.0, now_s - one.last_seen_s) / 3600.0, 1),
            }
            for one in objects
        ],
        "views": [[*_at(frame, one.pose), round(math.radians(frame.heading_deg(one.pose.yaw)), 2)] for one in views],
    }


def _line(frame: MapFrame, poses: Sequence[Pose2D]) -> list[float]:
    return [value for pose in poses for value in _at(frame, pose)]


def _at(frame: MapFrame, pose: Pose2D) -> list[float]:
    x, y = frame.to_px(pose.x, pose.y)
    return [round(x, 1), round(y, 1)]
