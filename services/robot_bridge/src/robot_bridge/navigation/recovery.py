"""What a goal does for itself once Nav2 has given it up: says what held it, and gets the robot room to try again.

The safety filter keeps more distance than Nav2's costmaps do. Where it holds the robot, Nav2 sees free space, plans the
same way again and stands there until its patience ends; its planner in turn finds no way out for a robot that stands
too near something. Nav2's own BackUp does the same, but comes late, and not every behaviour tree has one.
"""

import asyncio

import structlog

from contracts.causes import GoalCause, SafetyCause
from contracts.motion import Hazard
from contracts.robot import GoalStatus
from mesh.clock import Clock
from mesh.errors import ConflictError
from robot_bridge.motion.motions import DriveOnHeading, Spin, Tuning
from robot_bridge.motion.navigation_hold import NavigationHold
from robot_bridge.motion.run_motion import run_motion
from robot_bridge.motion.velocity_mux import RECOVERY_SOURCE, VelocityLimits, VelocityMux
from robot_bridge.navigation.goal_phases import Recovering
from robot_bridge.navigation.goal_states import cause_of
from robot_bridge.navigation.goal_store import ActiveGoal
from robot_bridge.ports import GoalEnd
from robot_bridge.safety.collision_monitor import NO_REVERSE, SafetyInput, unseen
from robot_bridge.safety.room import AHEAD, LEAST_M, is_crowded, recovery_motion, room_m
from robot_bridge.safety.safety_input import safety_input
from robot_bridge.sensing.sensor_readings import SensorReadings

HELD_S = 2.0
"""Held for less, it was not that which made Nav2 give up."""
STUCK_S = 3.0
"""Held for so long where the robot stands, it stands there until Nav2's patience ends (10 s)."""
IN_THE_WAY = frozenset({SafetyCause.OBSTACLE, SafetyCause.BLIND, SafetyCause.HAZARD})
"""What another place to start from may cure."""
SPEED_M_S, SPEED_RAD_S = 0.1, 0.8
MOTION_S_MAX = 8.0
PAUSE_S = 0.4
"""Between two motions, so that the second is decided on a scan of the robot at rest."""
PLANNER = 2
"""Nav2's codes of 200 to 299: there was no path, whatever held the robot."""
log = structlog.get_logger()


def explained(end: GoalEnd, hold: NavigationHold | None) -> tuple[GoalEnd, GoalCause]:
    """The end with what the safety filter had to do with it."""
    held = hold is not None and hold.last_s - hold.since_s >= HELD_S
    if hold is None or not held or end.status is not GoalStatus.ABORTED or end.error_code // 100 == PLANNER:
        return end, cause_of(end)
    return GoalEnd(end.status, end.error_code, hold.in_words), GoalCause.HELD


def is_stuck(hold: NavigationHold | None) -> bool:
    """Nav2 does not see what the safety filter sees: it would not give up for long, and then plan the same way."""
    return hold is not None and hold.restraint.cause in IN_THE_WAY and hold.last_s - hold.since_s > STUCK_S


class Recovery:
    """Moves through the arbiter and the safety filter as all else does, and only while its goal is held."""

    def __init__(
        self, *, senses: SensorReadings, wheels: VelocityMux, clock: Clock, tuning: Tuning, limits: VelocityLimits
    ) -> None:
        self._senses = senses
        self._wheels = wheels
        self._clock = clock
        self._tuning = tuning
        self._limits = limits

    async def make_room(self, active: ActiveGoal, hold: NavigationHold | None) -> None:
        """Away from what stands too near, where the laser shows a way; no motion where nothing does."""
        limits = self._limits
        around = self._around()
        forward = hold is None or hold.restraint.forward
        hazard = hold is not None and hold.restraint.cause is SafetyCause.HAZARD
        bumped = Hazard.BUMP in around.hazards or (hazard and forward)
        if not (bumped or is_crowded(around.points_m, limits)):
            return
        may_reverse = (
            limits.navigation_may_reverse and not (around.hazards & NO_REVERSE) and not (hazard and not forward)
        )
        unseen_m = unseen(around, limits)
        way = recovery_motion(around.points_m, unseen_m, limits, may_reverse=may_reverse, bumped=bumped)
        if way is None:
            log.warning("no way to more room", goal=active.goal_id)
            return
        log.info("making room", goal=active.goal_id, turn_rad=round(way.turn_rad, 2), drive_m=round(way.distance_m, 2))
        distance_m = way.distance_m
        if way.turn_rad != 0.0:
            turn = Spin(way.turn_rad, speed_rad_s=SPEED_RAD_S, timeout_s=MOTION_S_MAX, tuning=self._tuning)
            if not await self._done(active, turn):
                return  # where it looks now nobody has judged
            await self._clock.sleep(PAUSE_S)
            distance_m = room_m(self._around().points_m, AHEAD, limits)
            if distance_m < LEAST_M:
                return
        drive = DriveOnHeading(
            distance_m,
            speed_m_s=SPEED_M_S,
            timeout_s=MOTION_S_MAX,
            allow_reverse=distance_m < 0.0,
            tuning=self._tuning,
        )
        await self._done(active, drive)

    def _around(self) -> SafetyInput:
        return safety_input(self._senses, self._clock.now_s(), hazard_hold_s=self._limits.hazard_hold_s)

    async def _done(self, active: ActiveGoal, motion: Spin | DriveOnHeading) -> bool:
        """False where it was not done whole: the goal is over, the robot may not move, or somebody ended it."""
        if not isinstance(active.state, Recovering):
            return False
        moving = run_motion(
            self._wheels, motion, name=RECOVERY_SOURCE, epoch=active.epoch, session_id=active.session_id
        )
        try:
            reply = await asyncio.wait_for(moving, 2 * MOTION_S_MAX)
        except (ConflictError, TimeoutError) as error:
            log.info("made no room", goal=active.goal_id, why=str(error) or type(error).__name__)
            return False
        return reply.end.completed
