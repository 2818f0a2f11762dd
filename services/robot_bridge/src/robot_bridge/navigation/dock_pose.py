"""Where the dock is, in each map: set, or remembered from the last time the robot was docked and localised there."""

import json
from pathlib import Path
from typing import Any

import structlog
from pydantic import Field, ValidationError

from contracts.base import Message
from contracts.geometry import Pose2D
from contracts.robot import KnownMap
from geometry.poses import apart_m
from robot_bridge.navigation.map_book import MAPS_MAX
from robot_bridge.sensing.snapshot import Snapshot

log = structlog.get_logger()

FILE = "dock.json"
MOVED_M = 0.15
BEFORE_MAPS = ""
"""Stands for the map of a place that was learned before maps had ids: the first map that comes."""


class Learned(Message):
    """The file: base_link in map while docked, by the map's id, the newest last."""

    docks: dict[str, Pose2D] = Field(default_factory=dict[str, Pose2D])


class DockPose:
    """A place learned in one map means nothing in another: there the dock is not known, and that is said."""

    def __init__(self, state_dir: Path, set_to: Pose2D | None) -> None:
        self._file = state_dir / FILE
        self._set_to = set_to
        self._docks = self._load()

    def in_map(self, current: KnownMap | None) -> Pose2D | None:
        """base_link in map while docked; none where it is not known in this map, or no map is known."""
        if self._set_to is not None or current is None:
            return self._set_to
        return next(
            (self._docks[name] for name in (current.id, *current.was, BEFORE_MAPS) if name in self._docks), None
        )

    def is_known_elsewhere(self, current: KnownMap | None) -> bool:
        """It was learned, in another map."""
        return bool(self._docks) and current is not None and self.in_map(current) is None

    def learn(self, snapshot: Snapshot, current: KnownMap | None) -> None:
        """Once a second: a robot that stands on its dock and knows where it is knows where the dock is."""
        if self._set_to is not None or current is None:
            return
        docks = dict(self._docks)
        if BEFORE_MAPS in docks:
            docks.setdefault(current.id, docks.pop(BEFORE_MAPS))
        docked = snapshot.dock is not None and snapshot.dock.is_docked
        known = docks.get(current.id)
        if docked and snapshot.pose is not None and (known is None or apart_m(known, snapshot.pose) > MOVED_M):
            docks.pop(current.id, None)
            docks[current.id] = snapshot.pose
            log.info("the dock is here", x=round(snapshot.pose.x, 2), y=round(snapshot.pose.y, 2), map=current.id)
        if docks != self._docks:
            self._docks = dict(list(docks.items())[-MAPS_MAX:])
            self._store()

    def _store(self) -> None:
        try:
            self._file.parent.mkdir(parents=True, exist_ok=True)
            self._file.write_text(Learned(docks=self._docks).model_dump_json())
        except OSError as error:
            log.warning("where the dock is could not be stored", error=str(error))

    def _load(self) -> dict[str, Pose2D]:
        try:
            read: Any = json.loads(self._file.read_text())
            if "docks" in read:
                return dict(Learned.model_validate(read).docks)
            return {BEFORE_MAPS: Pose2D.model_validate(read)}
        except (OSError, ValueError, TypeError, ValidationError):
            return {}
