"""The only way to the wheels: arbiter, safety filter and emergency stop behind one lock, ticked at 20 Hz.

The robot's thread ticks; asyncio asks and stops. Publishing happens under the lock, so that nothing decided before a
stop can be sent after it.
"""

import asyncio
import threading
import time
from collections.abc import Callable
from typing import Any

from prometheus_client import Counter
from pydantic import Field

from contracts.causes import Refusal
from contracts.geometry import Twist2D
from contracts.motion import EndedMotion, MotionEnd, RotateReply
from contracts.robot import EmergencyStop, Priority
from mesh.clock import Clock
from mesh.errors import ConflictError
from mesh.latest_value import LatestValue
from mesh.metrics import Rounds
from robot_bridge.motion.arbiter import NO_COMMAND, STOPPED, ZERO, Arbiter, ArbiterLimits, ArbitratedCommand, Request
from robot_bridge.motion.motion_executor import ActiveMotion, MotionExecutor
from robot_bridge.motion.motions import Ending
from robot_bridge.motion.navigation_hold import NavigationHold, next_hold
from robot_bridge.motion.sessions import Sessions
from robot_bridge.motion.words import refusal_in_words
from robot_bridge.safety import emergency_stop
from robot_bridge.safety.collision_monitor import SafetyLimits, apply_safety
from robot_bridge.safety.safety_input import fresh_odometry, safety_input
from robot_bridge.sensing.sensor_readings import SensorReadings

NAVIGATION_SOURCE = "cmd_vel_nav"
NAVIGATION_LEASE_S = 0.35
"""Gaps of 187 ms were seen in a real Nav2's velocity on a busy computer. The price of 0.35 s instead of 0.25 s: a Nav2
that falls silent drives on for 0.1 s more, 2.6 cm at its 0.26 m/s."""
RECOVERY_SOURCE = "recovery"
OWN_SOURCES = frozenset({NAVIGATION_SOURCE, RECOVERY_SOURCE, "rotate", "drive", STOPPED.source, NO_COMMAND.source})
"""Names that nobody outside may ask under: he would replace the bridge's own lease."""
STOP_BURST = 10
REFUSED = Counter("robot_bridge_velocity_refused_total", "velocity requests that never became a lease", ["reason"])
CHANGED = Counter("robot_bridge_velocity_changed_total", "ticks whose velocity was not the one asked for", ["cause"])


class VelocityLimits(ArbiterLimits, SafetyLimits):
    navigation_may_reverse: bool = Field(default=True, description="Nav2's recoveries back up; the rear is watched too")


class VelocityMux:
    """`tick` is called by the robot's thread; every other method by any thread."""

    def __init__(
        self,
        *,
        senses: SensorReadings,
        sessions: Sessions,
        clock: Clock,
        stop: EmergencyStop,
        limits: VelocityLimits,
    ) -> None:
        self.commanded: LatestValue[ArbitratedCommand] = LatestValue()
        self.arbiter = Arbiter(limits)
        self.refused: dict[Refusal, int] = dict.fromkeys(Refusal, 0)
        self._senses = senses
        self._sessions = sessions
        self._clock = clock
        self._stop = stop
        self._limits = limits
        self._lock = threading.Lock()
        self._send: Callable[[Twist2D], None] = _nowhere
        self._on_session_ended: Callable[[str], None] = _ignore
        self._motions = MotionExecutor()
        self._goal: tuple[str, int, str | None] | None = None
        self._goal_held = False
        self._hold: NavigationHold | None = None
        self._base_is_busy = False
        self._rounds = Rounds("wheels")

    def connect(
        self,
        *,
        loop: asyncio.AbstractEventLoop,
        send: Callable[[Twist2D], None],
        on_session_ended: Callable[[str], None],
    ) -> None:
        """Before the first tick. `on_session_ended` is called in `loop`."""
        self._send = send

        def ended(session_id: str) -> None:
            loop.call_soon_threadsafe(on_session_ended, session_id)

        self._on_session_ended = ended

    @property
    def stop_state(self) -> EmergencyStop:
        return self._stop

    @property
    def base_is_busy(self) -> bool:
        return self._base_is_busy

    def tick(self) -> None:
        """Decides and sends one velocity. While the base docks by itself nothing is sent, unless stopped."""
        with self._lock:
            now_s = self._clock.now_s()
            for session_id in self._sessions.end_silent(now_s):
                self._drop_session(session_id)
                self._on_session_ended(session_id)
            self._step_motion(now_s)
            if self._stop.latched:
                choice = STOPPED
                self.arbiter.record_zero(now_s)
            else:
                around = safety_input(self._senses, now_s, hazard_hold_s=self._limits.hazard_hold_s)
                choice = self.arbiter.choose(
                    now_s, epoch=self._stop.epoch, restrain=lambda twist: apply_safety(twist, around, self._limits)
                )
            if self._stop.latched or not self._base_is_busy:
                self._send(choice.twist)
            self.commanded.put(choice, now_s)
            if choice.source == NAVIGATION_SOURCE:
                self._hold = next_hold(self._hold, choice, now_s)
        self._rounds.turn()
        for cause in choice.kinds:
            CHANGED.labels(cause.value).inc()

    def request(self, request: Request) -> Refusal | None:
        """Takes a lease on the wheels, or says why not. Raises `ConflictError` for a session that has ended."""
        with self._lock:
            self._sessions.check(request.session_id)
            if request.source in OWN_SOURCES:
                return self._refused(Refusal.RESERVED)
            return self._request(request, self._clock.now_s())

    def stop(self, *, reason: str, by: str) -> tuple[EmergencyStop, float]:
        """Zero before anything else; then latched, and ten more. Answers with how long the first took, in ms.

        The first does not wait for the lock: should a tick that was already under way send after it, the ten follow.
        """
        asked_s = time.perf_counter()
        self._send(ZERO)
        first_zero_ms = (time.perf_counter() - asked_s) * 1000.0
        with self._lock:
            self._stop = emergency_stop.stopped(self._stop, reason=reason, by=by, now_s=self._clock.now_s())
            for _ in range(STOP_BURST):
                self._send(ZERO)
            self._forget_everything(MotionEnd.STOPPED)
            return self._stop, first_zero_ms

    def halt(self) -> EmergencyStop:
        """Zeros, and the end of everything that was asked for; whoever asks anew, with the new epoch, may move."""
        self._send(ZERO)
        with self._lock:
            self._stop = emergency_stop.halted(self._stop)
            for _ in range(STOP_BURST):
                self._send(ZERO)
            self._forget_everything(MotionEnd.CANCELED)
            return self._stop

    def explain_stop(self, epoch: int, *, reason: str, by: str) -> EmergencyStop:
        """Adds who and why to the stop of this epoch, if it is still the last word."""
        with self._lock:
            if self._stop.latched and self._stop.epoch == epoch:
                self._stop = self._stop.model_copy(update={"reason": reason, "by": by})
            return self._stop

    def reset(self, *, reason: str, by: str) -> EmergencyStop:
        """Permits motion again; whatever was asked for before is gone."""
        with self._lock:
            self._stop = emergency_stop.reset(self._stop, reason=reason, by=by)
            self._forget_everything(MotionEnd.RESET)
            return self._stop

    def check(self, epoch: int, session_id: str | None) -> None:
        """Raises `ConflictError` while stopped, for another epoch, or for a session that has ended."""
        self._sessions.check(session_id)
        state = self._stop
        now = {
            Refusal.STOPPED: state.latched,
            Refusal.OLD_EPOCH: epoch != state.epoch,
            Refusal.BASE_BUSY: self._base_is_busy,
        }
        if (refusal := next((one for one, applies in now.items() if applies), None)) is not None:
            raise ConflictError(refusal_in_words(refusal, state), code=refusal)

    def drop(self, source: str) -> None:
        with self._lock:
            self.arbiter.drop(source)

    def end_session(self, session_id: str) -> None:
        """What the session had asked for ends now, and zero is sent where it was what moved the robot."""
        with self._lock:
            self._drop_session(session_id)

    def begin(self, running: ActiveMotion[Any]) -> None:
        """Starts a closed-loop motion. Raises `ConflictError` when one runs, or the robot navigates.

        A recovery is part of a goal: it runs while the goal is held, and ends with it.
        """
        with self._lock:
            self.check(running.epoch, running.session_id)
            if self._motions.running is not None:
                raise ConflictError(f"a {self._motions.running.name} is under way", code=Refusal.MOTION_UNDER_WAY)
            held = self._goal is not None and self._goal_held
            if running.name == RECOVERY_SOURCE and not held:
                raise ConflictError("there is no goal to recover for", code=Refusal.GOAL_OVER)
            if running.name != RECOVERY_SOURCE and self._goal is not None:
                raise ConflictError("a navigation goal is under way", code=Refusal.GOAL_UNDER_WAY)
            self._motions.begin(running)

    def end_motion(self, end: MotionEnd, *, only: ActiveMotion[Any] | None = None) -> EndedMotion:
        """Ends the closed-loop motion under way (`only` this one); tells how far it had come."""
        with self._lock:
            running = self._motions.running
            if running is None or (only is not None and running is not only):
                return EndedMotion()
            self._end_motion(Ending(end))
            reply = running.motion.ended(Ending(end))
        if isinstance(reply, RotateReply):
            return EndedMotion(turned_rad=reply.turned_rad)
        return EndedMotion(driven_m=reply.driven_m)

    def open_navigation(self, goal_id: str, epoch: int, session_id: str | None) -> None:
        """From here on Nav2's velocity may pass, for this goal only. Raises as `check` does."""
        with self._lock:
            self.check(epoch, session_id)
            self._end_motion(Ending(MotionEnd.PREEMPTED, text="a navigation goal took over"))
            self._goal, self._goal_held, self._hold = (goal_id, epoch, session_id), False, None

    def hold_navigation(self, goal_id: str) -> None:
        """Nothing of Nav2's passes until `release_navigation`: it has not taken the goal yet, or has given it up."""
        with self._lock:
            if self._goal is not None and self._goal[0] == goal_id:
                self._goal_held = True
                self.arbiter.drop(NAVIGATION_SOURCE)

    def release_navigation(self, goal_id: str) -> None:
        with self._lock:
            if self._goal is not None and self._goal[0] == goal_id:
                self._goal_held, self._hold = False, None

    def navigation_hold(self) -> NavigationHold | None:
        """What keeps the robot from going where Nav2 wants it to go; none without a goal."""
        with self._lock:
            return self._hold

    def close_navigation(self, goal_id: str) -> None:
        with self._lock:
            if self._goal is not None and self._goal[0] == goal_id:
                self._goal = self._hold = None
                self.arbiter.drop(NAVIGATION_SOURCE)
                self._end_recovery()

    def navigation_velocity(self, linear_x: float, angular_z: float) -> None:
        """What Nav2 wants now. Dropped unless a goal of this very process is active."""
        with self._lock:
            if self._goal is None or self._goal_held:
                return
            _, epoch, session_id = self._goal
            self._request(
                Request(
                    source=NAVIGATION_SOURCE,
                    priority=Priority.NAVIGATION,
                    linear_x=linear_x,
                    angular_z=angular_z,
                    duration_s=NAVIGATION_LEASE_S,
                    epoch=epoch,
                    allow_reverse=self._limits.navigation_may_reverse,
                    session_id=session_id,
                ),
                self._clock.now_s(),
            )

    def set_base_busy(self, busy: bool) -> None:
        """While the base docks by itself the bridge keeps quiet: its zeros would contradict the base."""
        with self._lock:
            self._base_is_busy = busy
            if busy:
                self._forget_everything(MotionEnd.BASE_BUSY)

    def shut_down(self) -> None:
        """The last word of a bridge that ends: zeros."""
        with self._lock:
            for _ in range(STOP_BURST):
                self._send(ZERO)
            self._end_motion(Ending(MotionEnd.SHUT_DOWN))
            self._send = _nowhere

    def _request(self, request: Request, now_s: float) -> Refusal | None:
        if self._stop.latched:
            return self._refused(Refusal.STOPPED)
        if self._base_is_busy:
            return self._refused(Refusal.BASE_BUSY)
        refusal = self.arbiter.request(request, now_s, epoch=self._stop.epoch)
        return self._refused(refusal) if refusal is not None else None

    def _refused(self, refusal: Refusal) -> Refusal:
        self.refused[refusal] += 1
        REFUSED.labels(refusal.value).inc()
        return refusal

    def _step_motion(self, now_s: float) -> None:
        odometry = fresh_odometry(self._senses, now_s, self._limits)
        step = self._motions.step(odometry, now_s, self.commanded.value)
        if isinstance(step, Request):
            self._request(step, now_s)
        elif step is not None:
            self.arbiter.drop(step)

    def _end_recovery(self) -> None:
        if (running := self._motions.running) is not None and running.name == RECOVERY_SOURCE:
            self._end_motion(Ending(MotionEnd.CANCELED))

    def _drop_session(self, session_id: str) -> None:
        last = self.commanded.value
        self.arbiter.drop_session(session_id)
        if self._motions.running is not None and self._motions.running.session_id == session_id:
            self._end_motion(Ending(MotionEnd.SESSION_ENDED))
        if self._goal is not None and self._goal[2] == session_id:
            self._goal = None
            self.arbiter.drop(NAVIGATION_SOURCE)
            self._end_recovery()
        now_s = self._clock.now_s()
        if last is not None and last.twist != ZERO and self.arbiter.winner(now_s) is None and not self._base_is_busy:
            self._send(ZERO)
            self.arbiter.record_zero(now_s)

    def _end_motion(self, ending: Ending) -> None:
        if (source := self._motions.end(ending)) is not None:
            self.arbiter.drop(source)

    def _forget_everything(self, end: MotionEnd) -> None:
        self._end_motion(Ending(end))
        self._goal = None
        self.arbiter.drop_all()
        self.arbiter.record_zero(self._clock.now_s())


def _nowhere(twist: Twist2D) -> None:
    """Before the robot is connected, and after the bridge has ended, nothing is sent."""


def _ignore(session_id: str) -> None:
    """Before the bridge is connected nobody waits for a session's end."""
