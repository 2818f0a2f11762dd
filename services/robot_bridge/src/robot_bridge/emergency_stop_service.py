"""The emergency stop around the wheels: the zeros first, then Nav2, the base, the disk and those who want to know."""

import asyncio
import contextlib
from collections.abc import Callable

import structlog

from contracts.causes import GoalCause
from contracts.motion import BaseEnd
from contracts.robot import BaseStopState, EmergencyStop, EmergencyStopAction, EmergencyStopEvent
from contracts.topics import ROBOT_EMERGENCY_STOP
from mesh.bus import Bus
from mesh.clock import Clock
from robot_bridge.motion.velocity_mux import VelocityMux
from robot_bridge.ports import Robot
from robot_bridge.safety.emergency_stop import LatchFile, StopHistory

log = structlog.get_logger()

REPEAT_S = 1.0
WATCH_S = 60.0


class EmergencyStopService:
    """Called in asyncio. Nothing here is waited for before the zeros are out and the latch is set."""

    def __init__(
        self,
        *,
        wheels: VelocityMux,
        robot: Robot,
        on_stop: Callable[[GoalCause, BaseEnd], None],
        latch: LatchFile,
        history: StopHistory,
        clock: Clock,
    ) -> None:
        """`on_stop` ends Nav2's goal and what the base does by itself, for the cause given."""
        self.history = history
        self.unstored = ""
        """Why the latch would not survive a restart as it is now; '' where it would."""
        self._wheels = wheels
        self._robot = robot
        self._on_stop = on_stop
        self._latch = latch
        self._clock = clock
        self._changed = asyncio.Event()
        self._unsaved = asyncio.Event()

    @property
    def state(self) -> EmergencyStop:
        return self._wheels.stop_state

    def stop(self, *, reason: str, by: str) -> tuple[EmergencyStop, float]:
        """Zeros; then the base's own stop, goals of Nav2, docking and the latch on disk, none of them waited for.

        The latch is stored whatever fails before it. The second value is how long the first zero took from the call,
        in ms.
        """
        state, first_zero_ms = self._wheels.stop(reason=reason, by=by)
        try:
            self._robot.engage_base_stop(True)
            self._robot.cancel_all_goals()
            self._on_stop(GoalCause.STOPPED, BaseEnd.STOPPED)
        finally:
            self._store(state)
        return state, first_zero_ms

    def halt(self) -> EmergencyStop:
        """Ends all motion, whoever asked for it, without latching: a person said 'stop', not 'emergency'."""
        state = self._wheels.halt()
        self._robot.cancel_all_goals()
        self._on_stop(GoalCause.CANCELED, BaseEnd.CANCELED)
        self._store(state)
        log.info("halted", epoch=state.epoch)
        return state

    def annotate(self, epoch: int, *, reason: str, by: str) -> EmergencyStop:
        """Who and why, told after the fact: the stop itself has not waited for it."""
        state = self._wheels.explain_stop(epoch, reason=reason, by=by)
        self._store(state)
        self._note(EmergencyStopAction.STOPPED, epoch, reason=reason, by=by)
        return state

    def reset(self, *, reason: str, by: str) -> EmergencyStop:
        """Permits motion. A crash before the file is replaced leaves the next process latched: the safe side."""
        state = self._wheels.reset(reason=reason, by=by)
        self._robot.engage_base_stop(False)
        self._store(state)
        self._note(EmergencyStopAction.RESET, state.epoch, reason=reason, by=by)
        return state

    def restore(self) -> None:
        """At the start. Stores what was loaded: an unreadable file becomes a readable one, and a disk that refuses is
        found out before the first stop."""
        self._store(self.state)
        if self.state.latched:
            self._robot.engage_base_stop(True, restored=True)
            reason = f"still latched: {self.state.reason}"[:500]
            self._note(EmergencyStopAction.RESTORED, self.state.epoch, reason=reason, by=self.state.by)

    async def watch_base(self) -> None:
        """A stop pressed at the robot itself latches here too: what was under way ends, and does not go on by itself
        when the base is let go there."""
        told = BaseStopState.UNKNOWN
        while True:
            last = told
            reading = await self._robot.senses.base_stop.wait_for(lambda each: each.value is not last, WATCH_S)  # noqa: B023
            told = reading.value if reading is not None else last
            pressed = last is BaseStopState.RELEASED and told is BaseStopState.HELD
            if pressed and not self.state.latched:
                state, _ = self.stop(reason="", by="the robot")
                self.annotate(
                    state.epoch, reason="pressed at the robot: its base has disabled the wheels", by="the robot"
                )

    async def publish(self, bus: Bus) -> None:
        """On every change, and every second: the key must be there when Redis comes back empty."""
        while True:
            self._changed.clear()
            await bus.publish(ROBOT_EMERGENCY_STOP, self.state)
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(self._changed.wait(), REPEAT_S)

    async def persist_forever(self) -> None:
        """Forces the latch to the disk and writes the history, after every change, at its own pace."""
        while True:
            await self._unsaved.wait()
            self._unsaved.clear()
            await asyncio.to_thread(self._save)

    async def save(self) -> None:
        """What is not on the disk yet, before the process ends."""
        if self._unsaved.is_set():
            await asyncio.to_thread(self._save)

    def _store(self, state: EmergencyStop) -> None:
        """At once for the process, soon (`keep`) for the disk; a full disk must not stop the stop."""
        try:
            self._latch.store(state)
            self.unstored = ""
        except OSError as error:  # a traceback would cost the stop request a second
            self.unstored = f"cannot be stored: {error.strerror or error}"
            log.error("the emergency stop could not be stored", error=str(error))  # noqa: TRY400
        self._changed.set()
        self._unsaved.set()

    def _note(self, action: EmergencyStopAction, epoch: int, *, reason: str, by: str) -> None:
        log.warning("emergency stop", action=action.value, reason=reason, by=by, epoch=epoch)
        event = EmergencyStopEvent(stamp_s=self._clock.now_s(), action=action, epoch=epoch, by=by, reason=reason)
        self.history.add(event)
        self._unsaved.set()

    def _save(self) -> None:
        try:
            self.history.store()
            self._latch.sync()
        except OSError as error:
            log.error("the emergency stop did not reach the disk", error=str(error))  # noqa: TRY400
