"""Runs the goals of the Nav2 stand-in in the World's thread: one at a time, a newer goal ends an older."""

import threading
from collections import deque
from collections.abc import Callable
from enum import StrEnum

from contracts.geometry import Pose2D, Twist2D
from sim.nav.codes import Code, NavigationError
from sim.nav.follower import STILL
from sim.nav.navigator import Navigator, Outcome, Progress


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

    def __init__(self, navigator: Navigator, publish_velocity: Callable[[Twist2D, int], None]) -> None:
        self._navigator = navigator
        self._publish_velocity = publish_velocity
        self._new: deque[Drive] = deque(maxlen=100)
        self._current: Drive | None = None

    def submit(self, drive: Drive) -> None:
        self._new.append(drive)

    def tick(self, pose: Pose2D, now_s: float, stamp_ns: int) -> None:
        """One control period: `pose` is base_link in the map, `now_s` simulated time."""
        while self._new:
            self.abort(Code.UNKNOWN, "a newer goal took its place", stamp_ns)
            self._begin(self._new.popleft(), pose, now_s)
        drive = self._current
        if drive is None:
            return
        if drive.cancel_requested():
            self._end(drive, DriveEnding.CANCELED, Progress(Outcome.ABORTED, detail="canceled"), stamp_ns)
            return
        progress = self._navigator.step(pose, now_s)
        drive.progress = progress
        if progress.outcome is Outcome.RUNNING:
            self._publish_velocity(progress.twist, stamp_ns)
        elif progress.outcome is Outcome.SUCCEEDED:
            self._end(drive, DriveEnding.SUCCEEDED, progress, stamp_ns)
        else:
            self._end(drive, DriveEnding.ABORTED, progress, stamp_ns)

    def abort(self, code: Code, detail: str, stamp_ns: int) -> None:
        """Ends the goal under way, if any."""
        if self._current is not None:
            progress = Progress(Outcome.ABORTED, code=code, detail=detail)
            self._end(self._current, DriveEnding.ABORTED, progress, stamp_ns)

    def _begin(self, drive: Drive, pose: Pose2D, now_s: float) -> None:
        try:
            self._navigator.start(drive.goal, pose, now_s)
        except NavigationError as error:
            failed = Progress(Outcome.ABORTED, code=error.code, detail=error.detail)
            drive.end(DriveEnding.ABORTED, failed)
            return
        self._current = drive

    def _end(self, drive: Drive, how: DriveEnding, progress: Progress, stamp_ns: int) -> None:
        self._navigator.cancel()
        self._current = None
        self._publish_velocity(STILL, stamp_ns)
        drive.end(how, progress)
