"""The only way to the wheels: arbiter, safety filter and emergency stop behind one lock, ticked at 20 Hz.

The robot's thread ticks; asyncio asks and stops. Publishing happens under the lock, so that nothing decided before a
stop can be sent after it.
"""

import asyncio
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contracts.geometry import Twist2D
from contracts.robot import EmergencyStop, MotionReply, Priority
from mesh.clock import Clock
from mesh.errors import ConflictError
from robot_bridge import emergency_stop
from robot_bridge.arbiter import ZERO, Arbiter, Choice, Limits, Refusal, Request
from robot_bridge.mailbox import Mailbox
from robot_bridge.motion import Motion
from robot_bridge.safety import SafetyLimits, Surroundings, restrain
from robot_bridge.senses import Odometry, Senses
from robot_bridge.sessions import Sessions

NAVIGATION_SOURCE = "cmd_vel_nav"
NAVIGATION_LEASE_S = 0.25
MOTION_LEASE_S = 0.25
STOP_BURST = 10
_NO_POINTS: NDArray[np.float64] = np.empty((0, 2))


@dataclass(frozen=True, slots=True)
class Running:
    """A closed-loop motion in progress, and where its reply goes."""

    motion: Motion
    name: str
    epoch: int
    session_id: str | None
    done: Callable[[MotionReply], None]


class Wheels:
    """`tick` is called by the robot's thread; every other method by any thread."""

    def __init__(
        self,
        *,
        senses: Senses,
        sessions: Sessions,
        clock: Clock,
        stop: EmergencyStop,
        limits: Limits,
        safety: SafetyLimits,
        hazard_hold_s: float,
    ) -> None:
        self.commanded: Mailbox[Choice] = Mailbox()
        self.arbiter = Arbiter(limits)
        self._senses = senses
        self._sessions = sessions
        self._clock = clock
        self._stop = stop
        self._safety = safety
        self._hazard_hold_s = hazard_hold_s
        self._lock = threading.Lock()
        self._send: Callable[[Twist2D], None] = _nowhere
        self._on_session_ended: Callable[[str], None] = _ignore
        self._running: Running | None = None
        self._goal: tuple[str, int, str | None] | None = None
        self._base_is_busy = False

    def connect(
        self,
        *,
        loop: asyncio.AbstractEventLoop,
        send: Callable[[Twist2D], None],
        on_session_ended: Callable[[str], None],
    ) -> None:
        """Before the first tick. `on_session_ended` is called in `loop`."""
        self._send = send
        self.commanded.bind(loop)

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
                choice = Choice(ZERO, "emergency_stop", "the emergency stop is latched", ZERO)
                self.arbiter.note_zero_sent(now_s)
            else:
                around = self._surroundings(now_s)
                choice = self.arbiter.choose(
                    now_s, epoch=self._stop.epoch, restrain=lambda twist: restrain(twist, around, self._safety)
                )
            if self._stop.latched or not self._base_is_busy:
                self._send(choice.twist)
            self.commanded.put(choice, now_s)

    def request(self, request: Request) -> Refusal | None:
        """Takes a lease on the wheels, or says why not. Raises `ConflictError` for a session that has ended."""
        with self._lock:
            self._sessions.check(request.session_id)
            return self._request(request, self._clock.now_s())

    def stop(self, *, reason: str, by: str) -> tuple[EmergencyStop, float]:
        """Ten zeros at once, and nothing else from here on. Answers with how long the first took, in ms."""
        asked_s = time.perf_counter()
        with self._lock:
            self._stop = emergency_stop.stopped(self._stop, reason=reason, by=by, now_s=self._clock.now_s())
            self._send(ZERO)
            first_zero_ms = (time.perf_counter() - asked_s) * 1000.0
            for _ in range(STOP_BURST - 1):
                self._send(ZERO)
            self._forget_everything("emergency stop")
            return self._stop, first_zero_ms

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
            self._forget_everything("reset")
            return self._stop

    def check(self, epoch: int, session_id: str | None) -> None:
        """Raises `ConflictError` while stopped, for another epoch, or for a session that has ended."""
        self._sessions.check(session_id)
        state = self._stop
        if state.latched:
            raise ConflictError(f"the emergency stop is latched ({state.reason or 'no reason given'})")
        if epoch != state.epoch:
            raise ConflictError(f"epoch {epoch} is over; it is {state.epoch} now")
        if self._base_is_busy:
            raise ConflictError("the base is docking or undocking")

    def drop(self, source: str) -> None:
        with self._lock:
            self.arbiter.drop(source)

    def end_session(self, session_id: str) -> None:
        """What the session had asked for ends now, and zero is sent where it was what moved the robot."""
        with self._lock:
            self._drop_session(session_id)

    def begin(self, running: Running) -> None:
        """Starts a closed-loop motion. Raises `ConflictError` when one runs, or the robot navigates."""
        with self._lock:
            self.check(running.epoch, running.session_id)
            if self._running is not None:
                raise ConflictError(f"a {self._running.name} is under way")
            if self._goal is not None:
                raise ConflictError("a navigation goal is under way")
            self._running = running

    def end_motion(self, reason: str) -> bool:
        """Cancels the closed-loop motion; true when there was one."""
        with self._lock:
            return self._end_motion(reason)

    def open_navigation(self, goal_id: str, epoch: int, session_id: str | None) -> None:
        """From here on Nav2's velocity may pass, for this goal only. Raises as `check` does."""
        with self._lock:
            self.check(epoch, session_id)
            self._end_motion("a navigation goal took over")
            self._goal = (goal_id, epoch, session_id)

    def close_navigation(self, goal_id: str) -> None:
        with self._lock:
            if self._goal is not None and self._goal[0] == goal_id:
                self._goal = None
                self.arbiter.drop(NAVIGATION_SOURCE)

    def navigation_velocity(self, linear_x: float, angular_z: float) -> None:
        """What Nav2 wants now. Dropped unless a goal of this very process is active."""
        with self._lock:
            if self._goal is None:
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
                    allow_reverse=True,  # Nav2's own recoveries back up; the rear is watched like the front
                    session_id=session_id,
                ),
                self._clock.now_s(),
            )

    def set_base_busy(self, busy: bool) -> None:
        """While the base docks by itself the bridge keeps quiet: its zeros would contradict the base."""
        with self._lock:
            self._base_is_busy = busy
            if busy:
                self._forget_everything("the base drives itself")

    def silence(self) -> None:
        """The last word of a bridge that ends: zeros."""
        with self._lock:
            for _ in range(STOP_BURST):
                self._send(ZERO)
            self._send = _nowhere

    def _request(self, request: Request, now_s: float) -> Refusal | None:
        refusal: Refusal | None = None
        if self._stop.latched:
            refusal = Refusal.STOPPED
        elif self._base_is_busy:
            refusal = Refusal.BASE_IS_BUSY
        if refusal is not None:
            self.arbiter.refused[refusal] += 1
            return refusal
        return self.arbiter.request(request, now_s, epoch=self._stop.epoch)

    def _step_motion(self, now_s: float) -> None:
        if (running := self._running) is None:
            return
        last = self.commanded.value
        mine = last is not None and last.source == running.name
        why = (last.reason if mine else f"{last.source} has the wheels") if last is not None else ""
        sent = last.twist if last is not None and mine else ZERO
        wanted = running.motion.step(self._fresh_odometry(now_s), now_s, sent, why)
        if isinstance(wanted, MotionReply):
            self._running = None
            self.arbiter.drop(running.name)
            running.done(wanted)
            return
        self._request(
            Request(
                source=running.name,
                priority=Priority.EXPLORATION,
                linear_x=wanted.linear_x,
                angular_z=wanted.angular_z,
                duration_s=MOTION_LEASE_S,
                epoch=running.epoch,
                allow_reverse=running.motion.allow_reverse,
                session_id=running.session_id,
            ),
            now_s,
        )

    def _fresh_odometry(self, now_s: float) -> Odometry | None:
        age_s = self._senses.odometry.age_s(now_s)
        return self._senses.odometry.value if age_s is not None and age_s <= self._safety.odometry_age_s_max else None

    def _surroundings(self, now_s: float) -> Surroundings:
        scan, odometry = self._senses.scan.newest, self._senses.odometry.newest
        hazards = self._senses.hazards.newest
        fresh_hazards = hazards is not None and now_s - hazards.received_s <= self._hazard_hold_s
        return Surroundings(
            points_m=scan.value.points_m if scan is not None else _NO_POINTS,
            scan_age_s=self._senses.scan.age_s(now_s),
            odometry_age_s=self._senses.odometry.age_s(now_s),
            known_fraction=scan.value.known_fraction if scan is not None else 0.0,
            speed_m_s=odometry.value.twist.linear_x if odometry is not None else 0.0,
            hazards=hazards.value if hazards is not None and fresh_hazards else frozenset(),
        )

    def _drop_session(self, session_id: str) -> None:
        last = self.commanded.value
        self.arbiter.drop_session(session_id)
        bound = self._running is not None and self._running.session_id == session_id
        if bound:
            self._end_motion("the session ended")
        if self._goal is not None and self._goal[2] == session_id:
            self._goal = None
            self.arbiter.drop(NAVIGATION_SOURCE)
        now_s = self._clock.now_s()
        if last is not None and last.twist != ZERO and self.arbiter.winner(now_s) is None and not self._base_is_busy:
            self._send(ZERO)
            self.arbiter.note_zero_sent(now_s)

    def _end_motion(self, reason: str) -> bool:
        if (running := self._running) is None:
            return False
        self._running = None
        self.arbiter.drop(running.name)
        running.done(MotionReply(completed=False, moved=running.motion.moved, reason=reason))
        return True

    def _forget_everything(self, reason: str) -> None:
        self._end_motion(reason)
        self._goal = None
        self.arbiter.drop_all()
        self.arbiter.note_zero_sent(self._clock.now_s())


def _nowhere(twist: Twist2D) -> None:
    """Before the robot is connected, and after the bridge has ended, nothing is sent."""


def _ignore(session_id: str) -> None:
    """Before the bridge is connected nobody waits for a session's end."""
