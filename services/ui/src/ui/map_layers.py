"""The map's layers as JSON, in pixels of the map's picture. Each is drawn once for all viewers.

A layer that looks the same keeps its version.
"""

import json
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from contracts.geometry import Pose2D
from contracts.laser import LaserScan
from contracts.memory import ObjectState, RememberedObject, View
from contracts.mission import MissionStatus
from contracts.robot import Goal
from ui import belief_layer, rooms_layer
from ui.latest_facts import LatestFacts
from ui.map_view import MapFrame, MapPicture

Drawn = dict[str, Any]
ROBOT_DIAMETER_M = 0.34


@dataclass(slots=True)
class Layer:
    source: tuple[str, object]
    text: str
    version: int


class MapLayers:
    """`parts` answers with the newest; who looks compares versions."""

    def __init__(self, silence_s_max: float) -> None:
        self._silence_s_max = silence_s_max
        self._layers: dict[str, Layer] = {}

    def newest(self, picture: MapPicture, facts: LatestFacts, now_s: float) -> dict[str, Layer]:
        pose = facts.robot.pose if facts.robot is not None else None
        fresh = now_s - facts.robot_at_s <= self._silence_s_max
        scan = facts.scan if fresh else None
        status, memory, belief, known = facts.mission, facts.remembered, facts.belief, facts.rooms
        draws: dict[str, tuple[object, Callable[[MapFrame], Drawn]]] = {
            "map": (None, lambda frame: _frame(picture, frame)),
            "robot": ((pose, fresh), lambda frame: robot(frame, pose, fresh=fresh)),
            "laser": (scan, lambda frame: laser(frame, scan, pose)),
            "paths": (
                facts.paths_version,
                lambda frame: paths(frame, facts.trail, facts.planned, facts.goal),
            ),
            "belief": (
                (belief, facts.mission_id, facts.map_id),
                lambda frame: belief_layer.belief(frame, belief, mission_id=facts.mission_id, map_id=facts.map_id),
            ),
            "rooms": (
                (known, facts.map_id),
                lambda frame: rooms_layer.rooms(frame, known, map_id=facts.map_id),
            ),
            "search": (status, lambda frame: search(frame, status)),
            "memory": (memory, lambda frame: remembered(frame, memory.objects, memory.views, now_s=now_s)),
        }
        for name, (source, draw) in draws.items():
            self._update(name, (picture.version, source), lambda draw=draw: draw(picture.frame))
        return self._layers

    def _update(self, name: str, source: tuple[str, object], draw: Callable[[], Drawn]) -> None:
        layer = self._layers.get(name)
        if layer is not None and _same(layer.source, source):
            return
        text = json.dumps(draw(), separators=(",", ":"))
        if layer is None:
            self._layers[name] = Layer(source, text, 1)
            return
        layer.source = source
        if text != layer.text:
            layer.text = text
            layer.version += 1


def _same(before: tuple[str, object], now: tuple[str, object]) -> bool:
    """Big messages are compared by identity, small ones by value: equal ones drawn again keep their version anyway."""
    small = isinstance(now[1], (int, tuple)) and before[1] == now[1]
    return before[0] == now[0] and (before[1] is now[1] or small)


def _frame(picture: MapPicture, frame: MapFrame) -> Drawn:
    return {
        "version": picture.version,
        "width": frame.width_px,
        "height": frame.height_px,
        "robot_px": round(frame.px(ROBOT_DIAMETER_M), 2),
    }


def robot(frame: MapFrame, pose: Pose2D | None, *, fresh: bool) -> Drawn:
    if pose is None:
        return {"at": None, "fresh": False}
    x, y = frame.to_px(pose.x, pose.y)
    return {
        "at": [round(x, 2), round(y, 2)],
        "turn": round(math.radians(frame.heading_deg(pose.yaw)), 3),
        "fresh": fresh,
        "metres": [round(pose.x, 2), round(pose.y, 2)],
    }


def laser(frame: MapFrame, scan: LaserScan | None, pose: Pose2D | None) -> Drawn:
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


def paths(frame: MapFrame, trail: Sequence[Pose2D], planned: Sequence[Pose2D], goal: Goal | None) -> Drawn:
    """Where it drove, where it means to drive, and the goal it drives to."""
    return {
        "trail": _line(frame, trail),
        "planned": _line(frame, planned),
        "goal": _at(frame, goal.pose) if goal is not None else None,
    }


def search(frame: MapFrame, status: MissionStatus | None) -> Drawn:
    mission = status.mission if status is not None else None
    todo = status.scan_points if status is not None else ()
    done = status.scan_points_done if status is not None else ()
    target = mission.target_pose if mission is not None else None
    return {
        "todo": [_at(frame, point) for point in todo],
        "done": [_at(frame, point) for point in done],
        "target": _at(frame, target) if target is not None else None,
    }


def remembered(frame: MapFrame, objects: Iterable[RememberedObject], views: Iterable[View], *, now_s: float) -> Drawn:
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
