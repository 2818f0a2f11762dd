"""The one closed-loop motion that may be under way, and the lease it asks for at every tick."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from contracts.geometry import Twist2D
from contracts.motion import MotionEnd
from contracts.robot import Priority
from robot_bridge.motion.arbiter import NO_COMMAND, STOPPED, ZERO, ArbitratedCommand, Request
from robot_bridge.motion.motions import Ending, Motion
from robot_bridge.motion.words import causes_in_words, restraint_in_words
from robot_bridge.sensing.sensor_readings import Odometry

LEASE_S = 0.25

R = TypeVar("R")


@dataclass(frozen=True, slots=True)
class ActiveMotion(Generic[R]):
    """A closed-loop motion, and where its reply goes."""

    motion: Motion[R]
    name: str
    epoch: int
    session_id: str | None
    done: Callable[[R], None]


class MotionExecutor:
    """Not locked: `VelocityMux` calls it under its lock."""

    def __init__(self) -> None:
        self.running: ActiveMotion[Any] | None = None

    def begin(self, running: ActiveMotion[Any]) -> None:
        self.running = running

    def step(self, odometry: Odometry | None, now_s: float, last: ArbitratedCommand | None) -> Request | str | None:
        """The next lease to take; the name of the source whose motion has just ended; none where nothing runs."""
        if (running := self.running) is None:
            return None
        mine = last is not None and last.source == running.name
        sent = last.twist if last is not None and mine else ZERO
        wanted = running.motion.step(odometry, now_s, sent, held_by(last, running.name))
        if not isinstance(wanted, Twist2D):
            self.running = None
            running.done(wanted)
            return running.name
        return Request(
            source=running.name,
            priority=Priority.EXPLORATION,
            linear_x=wanted.linear_x,
            angular_z=wanted.angular_z,
            duration_s=LEASE_S,
            epoch=running.epoch,
            allow_reverse=running.motion.allow_reverse,
            session_id=running.session_id,
        )

    def end(self, ending: Ending) -> str | None:
        """Gives up the motion under way; the name of its source, none where nothing ran."""
        if (running := self.running) is None:
            return None
        self.running = None
        running.done(running.motion.ended(ending))
        return running.name


def held_by(last: ArbitratedCommand | None, source: str) -> Ending:
    """How a motion of `source` ends that stands still because of what was sent last."""
    if last is None or last.source == NO_COMMAND.source:
        return Ending(MotionEnd.HELD_BACK)
    if last.source == STOPPED.source:
        return Ending(MotionEnd.STOPPED)
    if last.source != source:
        return Ending(MotionEnd.PREEMPTED, text=f"{last.source} has the wheels")
    stopping = last.stopping
    if stopping is None or stopping.cause.ends_as is None:
        return Ending(MotionEnd.HELD_BACK, text=causes_in_words(last.causes))
    return Ending(stopping.cause.ends_as, stopping.hazards, restraint_in_words(stopping))
