"""The one closed-loop motion that may be under way, and the lease it asks for at every tick."""

from collections.abc import Callable
from dataclasses import dataclass

from contracts.robot import MotionReply, Priority
from robot_bridge.arbiter import ZERO, Choice, Request
from robot_bridge.motion import Motion
from robot_bridge.senses import Odometry

LEASE_S = 0.25


@dataclass(frozen=True, slots=True)
class Running:
    """A closed-loop motion, and where its reply goes."""

    motion: Motion
    name: str
    epoch: int
    session_id: str | None
    done: Callable[[MotionReply], None]


class ClosedLoop:
    """Not locked: `Wheels` calls it under its lock."""

    def __init__(self) -> None:
        self.running: Running | None = None

    def begin(self, running: Running) -> None:
        self.running = running

    def step(self, odometry: Odometry | None, now_s: float, last: Choice | None) -> Request | str | None:
        """The next lease to take; the name of the source whose motion has just ended; none where nothing runs."""
        if (running := self.running) is None:
            return None
        mine = last is not None and last.source == running.name
        why = "" if last is None else last.reason if mine else f"{last.source} has the wheels"
        wanted = running.motion.step(odometry, now_s, last.twist if last is not None and mine else ZERO, why)
        if isinstance(wanted, MotionReply):
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

    def end(self, reason: str) -> str | None:
        """Gives up the motion under way; the name of its source, none where nothing ran."""
        if (running := self.running) is None:
            return None
        self.running = None
        running.done(MotionReply(completed=False, moved=running.motion.moved, reason=reason))
        return running.name
