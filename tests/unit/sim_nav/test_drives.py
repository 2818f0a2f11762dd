"""Goals of the Nav2 stand-in: one at a time, ended once each, and silence on the velocity topic between them."""

import numpy as np

from contracts.geometry import Pose2D, Twist2D
from sim.nav.codes import Code
from sim.nav.costmap import Costmap
from sim.nav.navigator import Navigator
from sim.ros.drives import Drive, DriveEnding, Drives
from sim.world.types import OccupancyGrid

HERE = Pose2D(x=1.0, y=1.0, yaw=0.0)
THERE = Pose2D(x=3.0, y=1.0, yaw=0.0)


class Room:
    """An empty room, its drives, and every velocity they asked for."""

    def __init__(self) -> None:
        self.asked: list[Twist2D] = []
        grid = OccupancyGrid(np.zeros((80, 80), np.int8), 0.05, 0.0, 0.0)
        self.drives = Drives(Navigator(Costmap.from_map(grid)), lambda twist, _: self.asked.append(twist))

    def tick(self, pose: Pose2D = HERE, now_s: float = 0.0) -> None:
        self.drives.tick(pose, now_s, 0)


def test_without_a_goal_nothing_is_asked_for() -> None:
    room = Room()
    room.tick()
    assert room.asked == []


def test_a_goal_reached_ends_with_a_stop_and_then_silence() -> None:
    room, drive = Room(), Drive(THERE, lambda: False)
    room.drives.submit(drive)
    room.tick()
    assert room.asked[-1].linear_x > 0.0
    room.tick(THERE, 1.0)
    assert drive.ending is DriveEnding.SUCCEEDED
    assert room.asked[-1] == Twist2D()
    room.tick(THERE, 2.0)
    assert len(room.asked) == 2


def test_a_newer_goal_ends_the_older() -> None:
    room, older, newer = Room(), Drive(THERE, lambda: False), Drive(HERE, lambda: False)
    room.drives.submit(older)
    room.tick()
    room.drives.submit(newer)
    room.tick()
    assert older.ending is DriveEnding.ABORTED
    assert newer.ending is DriveEnding.SUCCEEDED


def test_a_goal_that_cannot_be_planned_aborts_with_its_code_and_moves_nothing() -> None:
    room, drive = Room(), Drive(Pose2D(x=50.0, y=0.0, yaw=0.0), lambda: False)
    room.drives.submit(drive)
    room.tick()
    assert (drive.ending, drive.progress.code) == (DriveEnding.ABORTED, Code.GOAL_OUTSIDE_MAP)
    assert room.asked == []


def test_a_cancelled_goal_ends_canceled_with_a_stop() -> None:
    room, cancelled = Room(), []
    drive = Drive(THERE, lambda: bool(cancelled))
    room.drives.submit(drive)
    room.tick()
    cancelled.append(True)
    room.tick()
    assert drive.ending is DriveEnding.CANCELED
    assert room.asked[-1] == Twist2D()
