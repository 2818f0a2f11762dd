"""The localiser is told once where the dock is, and again only where it visibly took no pose."""

import pytest

from robot_bridge.navigation.initial_pose import AGAIN_S, TRIES_MAX, InitialPose


def told(pose: InitialPose, seconds: int, *, wanted: bool = True, listens: bool = True, laser_turns: bool) -> int:
    """How often, asked once a second."""
    return sum(
        pose.due(float(now_s), wanted=wanted, listens=listens, laser_turns=laser_turns) for now_s in range(seconds)
    )


def test_it_is_told_once_while_the_laser_is_off_on_the_dock() -> None:
    assert told(InitialPose(), 600, laser_turns=False) == 1


def test_it_is_told_a_few_times_where_the_laser_turns_and_no_pose_comes() -> None:
    assert told(InitialPose(), 600, laser_turns=True) == TRIES_MAX


@pytest.mark.parametrize(("wanted", "listens"), [(False, True), (True, False)])
def test_nothing_is_told_where_nobody_listens_or_there_is_nothing_to_tell(wanted: bool, listens: bool) -> None:
    assert told(InitialPose(), 600, wanted=wanted, listens=listens, laser_turns=True) == 0


def test_docked_and_lost_again_it_is_told_again() -> None:
    pose = InitialPose()
    assert pose.due(0.0, wanted=True, listens=True, laser_turns=False)
    assert not pose.due(1.0, wanted=False, listens=True, laser_turns=True)
    assert pose.due(1.0 + AGAIN_S, wanted=True, listens=True, laser_turns=False)
