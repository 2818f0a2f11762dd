"""The map's marks as JSON, each part drawn once however many look; a part that looks the same keeps its version."""

import json
from collections.abc import Callable
from dataclasses import dataclass

from ui import scene
from ui.latest_facts import Situation
from ui.map_view import MapFrame, MapPicture

ROBOT_DIAMETER_M = 0.34


@dataclass(slots=True)
class Part:
    source: tuple[str, object]
    text: str
    version: int


class Marks:
    """`parts` answers with the newest; who looks compares versions."""

    def __init__(self, silence_s_max: float) -> None:
        self._silence_s_max = silence_s_max
        self._parts: dict[str, Part] = {}

    def parts(self, picture: MapPicture, situation: Situation, now_s: float) -> dict[str, Part]:
        pose = situation.robot.pose if situation.robot is not None else None
        fresh = now_s - situation.robot_at_s <= self._silence_s_max
        scan = situation.scan if fresh else None
        status, memory = situation.mission, situation.remembered
        draws: dict[str, tuple[object, Callable[[MapFrame], scene.Part]]] = {
            "map": (None, lambda frame: _frame(picture, frame)),
            "robot": ((pose, fresh), lambda frame: scene.robot(frame, pose, fresh=fresh)),
            "laser": (scan, lambda frame: scene.laser(frame, scan, pose)),
            "paths": (
                situation.paths_version,
                lambda frame: scene.paths(frame, situation.trail, situation.planned, situation.goal),
            ),
            "search": (status, lambda frame: scene.search(frame, status)),
            "memory": (memory, lambda frame: scene.remembered(frame, memory.objects, memory.views, now_s=now_s)),
        }
        for name, (source, draw) in draws.items():
            self._update(name, (picture.version, source), lambda draw=draw: draw(picture.frame))
        return self._parts

    def _update(self, name: str, source: tuple[str, object], draw: Callable[[], scene.Part]) -> None:
        part = self._parts.get(name)
        if part is not None and _same(part.source, source):
            return
        text = json.dumps(draw(), separators=(",", ":"))
        if part is None:
            self._parts[name] = Part(source, text, 1)
            return
        part.source = source
        if text != part.text:
            part.text = text
            part.version += 1


def _same(before: tuple[str, object], now: tuple[str, object]) -> bool:
    """Big messages are compared by identity, small ones by value: equal ones drawn again keep their version anyway."""
    small = isinstance(now[1], (int, tuple)) and before[1] == now[1]
    return before[0] == now[0] and (before[1] is now[1] or small)


def _frame(picture: MapPicture, frame: MapFrame) -> scene.Part:
    return {
        "version": picture.version,
        "width": frame.width_px,
        "height": frame.height_px,
        "robot_px": round(frame.px(ROBOT_DIAMETER_M), 2),
    }
