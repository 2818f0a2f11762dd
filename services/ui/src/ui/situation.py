"""The newest facts the page shows, kept in one place: no I/O, no decisions about wording."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

from contracts.geometry import Pose2D
from contracts.mission import MissionEvent, MissionStatus
from contracts.problem import Dependency
from contracts.robot import EmergencyStop, EmergencyStopReply, RobotState

OLDER_EPOCH_HELD_S = 1.0


@dataclass(slots=True)
class Situation:
    """Facts with the time they came in (`*_at_s`, this process's clock), so that old ones can be told."""

    events_kept: int = 300
    trail_points_max: int = 2000
    trail_step_m: float = 0.05

    robot: RobotState | None = None
    robot_at_s: float = -math.inf
    stop: EmergencyStop | None = None
    stop_at_s: float = -math.inf
    first_zero_ms: float | None = None
    mission: MissionStatus | None = None
    mission_at_s: float = -math.inf
    events: tuple[MissionEvent, ...] = ()
    trail: list[Pose2D] = field(default_factory=list[Pose2D])
    trail_version: int = 0
    services: tuple[Dependency, ...] = ()
    bus_connected: bool = False

    @property
    def mission_id(self) -> str | None:
        return self.mission.mission.id if self.mission is not None and self.mission.mission is not None else None

    def take_robot(self, state: RobotState, now_s: float) -> None:
        self.robot = state
        self.robot_at_s = now_s
        self.take_stop(state.emergency_stop, now_s)
        if state.pose is not None:
            self._lengthen_trail(state.pose)

    def take_stop(self, stop: EmergencyStop, now_s: float) -> None:
        """An older epoch is a late message, unless it keeps coming: then the bridge has begun anew."""
        if self.stop is not None and stop.epoch < self.stop.epoch and now_s - self.stop_at_s < OLDER_EPOCH_HELD_S:
            return
        if not stop.latched or (self.stop is not None and stop.epoch != self.stop.epoch):
            self.first_zero_ms = None
        self.stop = stop
        self.stop_at_s = now_s

    def take_stop_reply(self, reply: EmergencyStopReply, now_s: float) -> None:
        self.take_stop(reply.state, now_s)
        self.first_zero_ms = reply.first_zero_ms if reply.state.latched else None

    def take_mission(self, status: MissionStatus, now_s: float) -> None:
        before = self.mission_id
        self.mission = status
        self.mission_at_s = now_s
        if self.mission_id != before:
            self.events = tuple(event for event in self.events if event.mission_id == self.mission_id)
            self.trail = self.trail[-1:]
            self.trail_version += 1

    def take_events(self, events: Iterable[MissionEvent]) -> None:
        """Adds what is new, oldest first; a burst, a repetition or a reordering changes nothing."""
        known = {(event.mission_id, event.id): event for event in self.events}
        known.update({(event.mission_id, event.id): event for event in events})
        ordered = sorted(known.values(), key=lambda event: (event.stamp_s, event.id))
        self.events = tuple(ordered[-self.events_kept :])

    def _lengthen_trail(self, pose: Pose2D) -> None:
        if self.trail and math.dist((pose.x, pose.y), (self.trail[-1].x, self.trail[-1].y)) < self.trail_step_m:
            return
        if len(self.trail) >= self.trail_points_max:
            self.trail = self.trail[::2]
        self.trail.append(pose)
        self.trail_version += 1
