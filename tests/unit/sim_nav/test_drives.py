"""Goals of the Nav2 stand-in: one at a time, ended once each, and what comes out on the velocity topic between them."""

from collections.abc import Callable
from typing import Any

import numpy as np

from contracts.geometry import Pose2D, Twist2D
from sim.nav.chain import ChainHabits
from sim.nav.codes import Code
from sim.nav.costmap import Costmap
from sim.nav.navigator import Navigator
from sim.ros.drives import Drive, DriveEnding, Drives, Habits
from sim.world.types import OccupancyGrid

HERE = Pose2D(x=1.0, y=1.0, yaw=0.0)
THERE = Pose2D(x=3.0, y=1.0, yaw=0.0)


class Room:
    """An empty room, its drives, and every velocity that came out of the chain."""

    def __init__(self, **habits: Any) -> None:
        self.asked: list[Twist2D] = []
        self.now_s = 0.0
        self.pose = HERE
        grid = OccupancyGrid(np.zeros((80, 80), np.int8), 0.05, 0.0, 0.0)
        self.drives = Drives(
            Navigator(Costmap.from_map(grid)), lambda twist, _: self.asked.append(twist), Habits(**habits)
        )

    def submit(self, goal: Pose2D, cancel_requested: Callable[[], bool] = lambda: False) -> Drive:
        drive = Drive(goal, cancel_requested)
        self.drives.submit(drive)
        return drive

    def run(self, seconds: float) -> list[Twist2D]:
        """What came out meanwhile, at 20 Hz."""
        before = len(self.asked)
        for _ in range(round(seconds * 20)):
            self.drives.tick(self.pose, self.now_s, 0)
            self.now_s += 0.05
        return self.asked[before:]


def test_without_a_goal_nothing_is_asked_for() -> None:
    assert Room().run(1.0) == []


def test_a_goal_reached_ends_with_zeros_for_two_seconds_and_then_silence() -> None:
    room = Room()
    drive = room.submit(THERE)
    assert room.run(1.0)[-1].linear_x > 0.0
    room.pose = THERE
    room.run(0.2)
    assert drive.ending is DriveEnding.SUCCEEDED
    assert set(room.run(1.7)) == {Twist2D()}
    room.run(0.3)
    assert room.run(1.0) == []


def test_a_newer_goal_ends_the_older_without_a_code() -> None:
    room = Room()
    older = room.submit(THERE)
    room.run(0.1)
    newer = room.submit(HERE)
    room.run(0.1)
    assert (older.ending, older.progress.code) == (DriveEnding.ABORTED, Code.NONE)
    assert newer.ending is DriveEnding.SUCCEEDED


def test_a_goal_that_cannot_be_planned_aborts_with_its_code_and_moves_nothing() -> None:
    room = Room()
    drive = room.submit(Pose2D(x=50.0, y=0.0, yaw=0.0))
    assert room.run(1.0) == []
    assert (drive.ending, drive.progress.code) == (DriveEnding.ABORTED, Code.GOAL_OUTSIDE_MAP)


def test_a_cancelled_goal_ends_canceled_with_a_stop() -> None:
    room, cancelled = Room(), []
    drive = room.submit(THERE, lambda: bool(cancelled))
    room.run(0.5)
    cancelled.append(True)
    room.run(0.2)
    assert drive.ending is DriveEnding.CANCELED
    assert room.asked[-1] == Twist2D()


def test_velocities_come_out_a_tenth_of_a_second_late() -> None:
    room = Room(chain=ChainHabits(delay_s=0.1))
    room.submit(THERE)
    assert room.run(0.1) == []
    assert room.run(0.05)[0].linear_x > 0.0


def test_now_and_then_the_chain_is_silent_for_a_while() -> None:
    room = Room(chain=ChainHabits(delay_s=0.0, gap_s=0.2, gap_every_s=1.0))
    room.submit(THERE)
    assert len(room.run(2.0)) == 40 - 2 * 4


def test_nav2_may_drive_on_after_its_goal_has_ended() -> None:
    room, cancelled = Room(drives_on_s=1.2), []
    drive = room.submit(THERE, lambda: bool(cancelled))
    room.run(0.5)
    cancelled.append(True)
    room.run(0.1)
    assert drive.ending is DriveEnding.CANCELED
    assert min(twist.linear_x for twist in room.run(1.1)) > 0.0
    assert room.run(3.0)[-1] == Twist2D()


def test_a_controller_that_dies_leaves_its_last_word_for_a_second_and_fails_the_goal_late() -> None:
    room = Room(dies_after_s=0.5)
    drive = room.submit(THERE)
    room.run(0.6)
    assert min(twist.linear_x for twist in room.run(0.8)) > 0.0
    assert drive.ending is None
    room.run(0.4)
    assert (drive.ending, drive.progress.code) == (DriveEnding.ABORTED, Code.NONE)
    assert room.asked[-1] == Twist2D()
    assert room.drives.died_s is not None
    again = room.submit(THERE)
    assert not any(twist.linear_x for twist in room.run(1.0))
    assert again.ending is DriveEnding.ABORTED
