"""How what an exploration remembers grows: one action, one dead end, one discovery more; the oldest go first."""

import math
from typing import Final

from contracts.exploration import (
    ACTIONS_KEPT,
    DISCOVERIES_KEPT,
    PLACES_KEPT,
    Discovery,
    DoneAction,
    ExplorationMemory,
    KnownFrontier,
    MapPoint,
)
from contracts.geometry import Pose2D
from coordinator.exploration.frontiers import Frontier

TRAIL_M: Final = 0.5
SAME_PLACE_M: Final = 1.0
GIVEN_UP_M: Final = 0.6
FRONTIERS_KEPT: Final = 20
DEAD_ENDS_KEPT: Final = 50


def done(memory: ExplorationMemory, action: DoneAction) -> ExplorationMemory:
    """One action more."""
    actions = (*memory.actions, action)[-ACTIONS_KEPT:]
    return memory.model_copy(update={"actions": actions, "actions_done": memory.actions_done + 1})


def found(memory: ExplorationMemory, discovery: Discovery) -> ExplorationMemory:
    return memory.model_copy(update={"discoveries": (*memory.discoveries, discovery)[-DISCOVERIES_KEPT:]})


def been_at(memory: ExplorationMemory, pose: Pose2D) -> ExplorationMemory:
    """Where it has been, unless the last such place is near."""
    last = memory.trail[-1] if memory.trail else None
    if last is not None and _apart_m(last, pose) < TRAIL_M:
        return memory
    return memory.model_copy(update={"trail": (*memory.trail, point(pose))[-PLACES_KEPT:]})


def dead_end_at(memory: ExplorationMemory, pose: Pose2D) -> ExplorationMemory:
    if any(_apart_m(one, pose) < SAME_PLACE_M for one in memory.dead_ends):
        return memory
    return memory.model_copy(update={"dead_ends": (*memory.dead_ends, point(pose))[-DEAD_ENDS_KEPT:]})


def gave_up(memory: ExplorationMemory, pose: Pose2D) -> ExplorationMemory:
    return memory.model_copy(update={"given_up": (*memory.given_up, point(pose))[-PLACES_KEPT:]})


def knows_frontiers(memory: ExplorationMemory, frontiers: tuple[Frontier, ...]) -> ExplorationMemory:
    known = tuple(
        KnownFrontier(number=one.number, x_m=one.pose.x, y_m=one.pose.y, border_m=one.border_m)
        for one in frontiers[:FRONTIERS_KEPT]
    )
    return memory.model_copy(update={"frontiers": known})


def left(memory: ExplorationMemory, frontiers: tuple[Frontier, ...]) -> tuple[Frontier, ...]:
    """Those that were not given up."""
    return tuple(one for one in frontiers if all(_apart_m(point_, one.pose) > GIVEN_UP_M for point_ in memory.given_up))


def point(pose: Pose2D) -> MapPoint:
    return MapPoint(x_m=pose.x, y_m=pose.y)


def _apart_m(one: MapPoint, pose: Pose2D) -> float:
    return math.hypot(one.x_m - pose.x, one.y_m - pose.y)
