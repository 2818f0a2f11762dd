"""The newest facts the page shows, kept in one place: no I/O, no decisions about wording."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

from contracts.belief import NoBelief, SearchBelief
from contracts.description import RobotDescription
from contracts.geometry import Pose2D
from contracts.laser import LaserScan
from contracts.memory import LabelCount, RememberedObject, View
from contracts.mission import MissionEvent, MissionStatus
from contracts.problem import Dependency
from contracts.robot import EmergencyStop, EmergencyStopReply, Goal, GoalStatus, RobotState
from contracts.rooms import NamedRoom, RoomGrid
from contracts.vision import Detections, Target

OLDER_EPOCH_HELD_S = 1.0
AT_REST_M_S = 0.01
AT_REST_RAD_S = 0.05
OPEN_GOALS = frozenset({GoalStatus.PENDING, GoalStatus.EXECUTING})


@dataclass(frozen=True, slots=True)
class Remembered:
    """What memory said when it was last asked."""

    labels: tuple[LabelCount, ...] = ()
    objects: tuple[RememberedObject, ...] = ()
    views: tuple[View, ...] = ()


@dataclass(frozen=True, slots=True)
class ShownRooms:
    """What memory said of the rooms when it was last asked: their names, and where they lie."""

    map_id: str = ""
    rooms: tuple[NamedRoom, ...] = ()
    grid: RoomGrid | None = None
    picture: str | None = None
    """Of the grid, as a data URL; none where there is no grid, or its cells make no sense."""

    @property
    def names(self) -> dict[int, str]:
        return {one.id: one.name for one in self.rooms}


@dataclass(slots=True)
class LatestFacts:
    """Facts with the time they came in (`*_at_s`, this process's clock), so that old ones can be told."""

    events_kept: int = 300
    trail_points_max: int = 2000
    trail_step_m: float = 0.05

    body: RobotDescription | None = None
    robot: RobotState | None = None
    robot_at_s: float = -math.inf
    stop: EmergencyStop | None = None
    stop_at_s: float = -math.inf
    first_zero_ms: float | None = None
    rest_after_s: float | None = None
    witnessed_epoch: int | None = None
    mission: MissionStatus | None = None
    mission_at_s: float = -math.inf
    events: tuple[MissionEvent, ...] = ()
    trail: list[Pose2D] = field(default_factory=list[Pose2D])
    """Where it drove in the map `map_id`."""
    map_id: str | None = None
    goal: Goal | None = None
    planned: tuple[Pose2D, ...] = ()
    paths_version: int = 0
    detections: Detections | None = None
    target: Target | None = None
    scan: LaserScan | None = None
    belief: SearchBelief | NoBelief | None = None
    """Of the mission that runs, or why it has none; none where nobody could say."""
    remembered: Remembered = Remembered()
    rooms: ShownRooms = field(default_factory=ShownRooms)
    services: tuple[Dependency, ...] = ()
    bus_connected: bool = False

    @property
    def mission_id(self) -> str | None:
        return self.mission.mission.id if self.mission is not None and self.mission.mission is not None else None

    def take_robot(self, state: RobotState, now_s: float) -> None:
        if state.map_id is not None and state.map_id != self.map_id:
            self.map_id = state.map_id
            self.trail = []
        self.robot = state
        self.robot_at_s = now_s
        self.take_stop(state.emergency_stop, now_s)
        self._measure_rest(state)
        if state.pose is not None:
            self._lengthen_trail(state.pose)

    def take_stop(self, stop: EmergencyStop, now_s: float) -> None:
        """An older epoch is a late message, unless it keeps coming: then the bridge has begun anew."""
        if self.stop is not None and stop.epoch < self.stop.epoch and now_s - self.stop_at_s < OLDER_EPOCH_HELD_S:
            return
        if not stop.latched or (self.stop is not None and stop.epoch != self.stop.epoch):
            self.first_zero_ms = None
        if self.stop is not None and stop.latched and (not self.stop.latched or stop.epoch != self.stop.epoch):
            self.witnessed_epoch = stop.epoch
            self.rest_after_s = None
        self.stop = stop
        self.stop_at_s = now_s

    def take_stop_reply(self, reply: EmergencyStopReply, now_s: float) -> None:
        self.take_stop(reply.state, now_s)
        self.first_zero_ms = reply.first_zero_ms if reply.state.latched else None

    def take_goal(self, goal: Goal) -> None:
        """An open goal is shown; one that is over is not."""
        self.goal = goal if goal.status in OPEN_GOALS else None
        if self.goal is None:
            self.planned = ()
        self.paths_version += 1

    def take_plan(self, poses: Iterable[Pose2D]) -> None:
        self.planned = tuple(poses)
        self.paths_version += 1

    def take_mission(self, status: MissionStatus, now_s: float) -> None:
        before = self.mission_id
        self.mission = status
        self.mission_at_s = now_s
        if self.mission_id != before:
            self.events = tuple(event for event in self.events if event.mission_id == self.mission_id)
            self.trail = self.trail[-1:]
            self.paths_version += 1

    def take_events(self, events: Iterable[MissionEvent]) -> None:
        """Adds what is new, oldest first; a burst, a repetition or a reordering changes nothing."""
        known = {(event.mission_id, event.id): event for event in self.events}
        known.update({(event.mission_id, event.id): event for event in events})
        ordered = sorted(known.values(), key=lambda event: (event.stamp_s, event.id))
        self.events = tuple(ordered[-self.events_kept :])

    def _measure_rest(self, state: RobotState) -> None:
        """From a stop seen to happen to the first word that the robot stands, both on the bridge's clock."""
        stop = state.emergency_stop
        if self.witnessed_epoch != stop.epoch or stop.since_s is None or state.stamp_s < stop.since_s:
            return
        if at_rest(state):
            self.rest_after_s = state.stamp_s - stop.since_s
            self.witnessed_epoch = None

    def _lengthen_trail(self, pose: Pose2D) -> None:
        if self.trail and math.dist((pose.x, pose.y), (self.trail[-1].x, self.trail[-1].y)) < self.trail_step_m:
            return
        if len(self.trail) >= self.trail_points_max:
            self.trail = self.trail[::2]
        self.trail.append(pose)
        self.paths_version += 1


def at_rest(state: RobotState) -> bool:
    return abs(state.twist.linear_x) < AT_REST_M_S and abs(state.twist.angular_z) < AT_REST_RAD_S
