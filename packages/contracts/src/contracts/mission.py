"""Missions: the ten states of requirement A12, the endings, and the timeline."""

from enum import StrEnum
from typing import Any

from pydantic import Field

from contracts.base import Message, StampS
from contracts.geometry import Pose2D
from contracts.vision import Target, Vote


class MissionState(StrEnum):
    IDLE = "IDLE"
    """Nothing to do."""
    MEMORY_NAV = "MEMORY_NAV"
    """Driving to a place where such a thing was seen."""
    SCANNING = "SCANNING"
    """Turning on the spot and looking."""
    MOVING_TO_SCAN = "MOVING_TO_SCAN"
    """Driving to the next place of the search."""
    CENTERING = "CENTERING"
    """Turning until the target is in the middle of the picture."""
    DEPTH_CHECK = "DEPTH_CHECK"
    """Standing still: measuring the distance and validating."""
    APPROACHING = "APPROACHING"
    """Driving up to a validated target."""
    DRIVING_1M = "DRIVING_1M"
    """Taking one step of a metre towards a far target."""
    DONE = "DONE"
    """The mission has ended; resets by itself."""
    EMERGENCY_STOP = "EMERGENCY_STOP"
    """Stopped until RESUME."""


class Outcome(StrEnum):
    FOUND = "found"
    NOT_FOUND = "not_found"
    UNSURE = "unsure"
    CANCELED = "canceled"
    ABORTED = "aborted"


class StartMission(Message):
    command: str = Field(min_length=1, max_length=500, description="e.g. 'find the red bottle'")


class Mission(Message):
    id: str
    command: str
    target: Target | None = None
    parser: str = ""
    state: MissionState
    paused: bool = False
    outcome: Outcome | None = Field(default=None, description="none while it runs")
    reason: str = ""
    started_s: StampS
    ended_s: float | None = None
    votes: tuple[Vote, ...] = ()
    measured_distance_m: float | None = Field(
        default=None, description="camera to the target's near surface at the end"
    )
    target_pose: Pose2D | None = Field(default=None, description="the target's place in map (yaw unused)")
    metres_driven_m: float = 0.0


class MissionStatus(Message):
    """The `mission.state` topic: what the robot is at, in one message."""

    stamp_s: StampS
    state: MissionState = MissionState.IDLE
    mission: Mission | None = None
    progress: str = Field(default="", max_length=500)
    scan_points: tuple[Pose2D, ...] = Field(
        default=(), max_length=2000, description="still to be looked at, next first"
    )
    scan_points_done: tuple[Pose2D, ...] = Field(default=(), max_length=2000)


class MissionTarget(Message):
    """The `mission.target` topic: what perception should look for, or nothing."""

    target: Target | None = None
    mission_id: str | None = None
    fast: bool = Field(default=False, description="look more often than at rest: the robot is centering or approaching")


class MissionEvent(Message):
    """One line of the timeline."""

    id: int = Field(ge=0, description="rises by one within a coordinator's life")
    mission_id: str
    stamp_s: StampS
    state: MissionState
    kind: str = Field(max_length=40, description="state, navigation, sighting, votes, depth, ...")
    text: str = Field(max_length=1000, description="what was done and why, for a person")
    data: dict[str, Any] = Field(default_factory=dict)


class CoveragePlan(Message):
    points: tuple[Pose2D, ...]
    regions: int = 0
    free_area_m2: float = 0.0
