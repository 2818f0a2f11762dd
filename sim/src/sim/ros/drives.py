"""Runs the goals of the Nav2 stand-in in the World's thread: one at a time, a newer goal ends an older."""

import math
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Final

from contracts.geometry import Pose2D, Twist2D
from sim.nav.chain import ChainHabits, VelocityChain
from sim.nav.codes import Code, NavigationError
from sim.nav.follower import STILL
from sim.nav.navigator import Navigator, Outcome, Progress

NOTICED_S: Final = 1.0
"""A dead controller fails the goal at the next replanning, at worst so much later."""
DEACTIVATED_S: Final = 4.0
"""So long after its death the lifecycle manager takes everything down, for good."""


@dataclass(frozen=True)
class Habits:
    """What else the real one may do: `drives_on_s` after a goal's end without one; a controller that dies after so much
    driving (inf = never).
    """

    chain: ChainHabits = field(default_factory=ChainHabits)
    drives_on_s: float = 0.0
    dies_after_s: float = math.inf


class DriveEnding(StrEnum):
    SUCCEEDED = "succeeded"
    ABORTED = "aborted"
    CANCELED = "canceled"


class Drive:
    """One goal; `ended` is set when `ending` holds, `progress` is the newest."""

    def __init__(self, goal: Pose2D, cancel_requested: Callable[[], bool]) -> None:
        self.goal = goal
        self.cancel_requested = cancel_requested
        self.progress = Progress(Outcome.RUNNING)
        self.ending: DriveEnding | None = None
        self.ended = threading.Event()

    def end(self, how: DriveEnding, progress: Progress) -> None:
        self.progress = progress
        self.ending = how
        self.ended.set()


class Drives:
    """`submit` from any thread; `tick` and `abort` in the World's thread only."""

    def __init__(
        self,
        navigator: Navigator,
        publish_velocity: Callable[[Twist2D, int], None],
        habits: Habits | None = None,
    ) -> None:
        self._navigator = navigator
        self._publish_velocity = publish_velocity
        self._habits = habits or Habits()
        self._chain = VelocityChain(self._habits.chain)
        self._new: deque[Drive] = deque(maxlen=100)
        self._current: Drive | None = None
        self._wanted = STILL
        self._drives_on_until_s = -math.inf
        self._driven_s = 0.0
        self._ticked_s: float | None = None
        self._died_s: float | None = None

    @property
    def died_s(self) -> float | None:
        """When the controller died, on the clock of `tick`; none while it lives."""
        return self._died_s

    def submit(self, drive: Drive) -> None:
        self._new.append(drive)

    def tick(self, pose: Pose2D, now_s: float, stamp_ns: int) -> None:
        """One control period: `pose` is base_link in the map, `now_s` simulated time."""
        while self._new:
            self.abort(Code.NONE, now_s)
            self._begin(self._new.popleft(), pose, now_s)
        self._age_controller(now_s)
        if (drive := self._current) is not None:
            self._step(drive, pose, now_s)
        elif now_s <= self._drives_on_until_s and self._died_s is None:
            self._chain.put(self._wanted, now_s)
        if (twist := self._chain.out(now_s)) is not None:
            self._publish_velocity(twist, stamp_ns)

    def abort(self, code: Code, now_s: float) -> None:
        """Ends the goal under way, if any."""
        if self._current is not None:
            self._end(DriveEnding.ABORTED, Progress(Outcome.ABORTED, code=code), now_s)

    def _begin(self, drive: Drive, pose: Pose2D, now_s: float) -> None:
        try:
            self._navigator.start(drive.goal, pose, now_s)
        except NavigationError as error:
            failed = Progress(Outcome.ABORTED, code=error.code, detail=error.detail)
            drive.end(DriveEnding.ABORTED, failed)
            return
        self._current = drive

    def _age_controller(self, now_s: float) -> None:
        """It dies of driving, where it is to die at all."""
        if self._current is not None and self._ticked_s is not None:
            self._driven_s += now_s - self._ticked_s
        self._ticked_s = now_s
        if self._died_s is None and self._driven_s > self._habits.dies_after_s:
            self._died_s = now_s

    def _step(self, drive: Drive, pose: Pose2D, now_s: float) -> None:
        if drive.cancel_requested():
            self._end(DriveEnding.CANCELED, Progress(Outcome.ABORTED, detail="canceled"), now_s)
        elif self._died_s is not None:
            if now_s - self._died_s >= NOTICED_S:
                self._end(DriveEnding.ABORTED, Progress(Outcome.ABORTED, detail="the controller is dead"), now_s)
        else:
            self._follow(drive, pose, now_s)

    def _follow(self, drive: Drive, pose: Pose2D, now_s: float) -> None:
        progress = drive.progress = self._navigator.step(pose, now_s)
        if progress.outcome is Outcome.RUNNING:
            self._wanted = progress.twist
            self._chain.put(progress.twist, now_s)
        elif progress.outcome is Outcome.SUCCEEDED:
            self._end(DriveEnding.SUCCEEDED, progress, now_s)
        else:
            self._end(DriveEnding.ABORTED, progress, now_s)

    def _end(self, how: DriveEnding, progress: Progress, now_s: float) -> None:
        drive, self._current = self._current, None
        assert drive is not None
        self._navigator.cancel()
        if self._habits.drives_on_s:
            self._drives_on_until_s = now_s + self._habits.drives_on_s
        elif self._died_s is None:
            self._chain.put(STILL, now_s)
        drive.end(how, progress)
