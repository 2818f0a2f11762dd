"""Goals as data, the celebration, the mailbox, sessions."""

import asyncio
import math
import threading

import pytest

from contracts.geometry import Pose2D
from contracts.robot import CandidatePose, Goal, GoalStatus
from mesh.errors import ConflictError, NotFoundError, TooManyError
from mesh.latest_value import LatestValue
from robot_bridge.motion.sessions import SESSIONS_MAX, Sessions
from robot_bridge.navigation.goal_states import ALLOWED, error_name, is_over, with_status
from robot_bridge.navigation.goal_store import GOALS_KEPT, ActiveGoal, GoalStore
from robot_bridge.navigation.path_check import GoalRegion
from robot_bridge.routes.actions import SUCCESS

GOAL = Goal(id="g", pose=Pose2D(x=0.0, y=0.0, yaw=0.0), status=GoalStatus.PENDING, stamp_s=1.0)


def test_the_table_names_every_status_and_endings_stay_endings() -> None:
    assert set(ALLOWED) == set(GoalStatus)
    assert {status for status in GoalStatus if not is_over(status)} == {GoalStatus.PENDING, GoalStatus.EXECUTING}
    reached = with_status(with_status(GOAL, GoalStatus.EXECUTING, stamp_s=2.0), GoalStatus.SUCCEEDED, stamp_s=3.0)
    with pytest.raises(ValueError, match="SUCCEEDED cannot become EXECUTING"):
        with_status(reached, GoalStatus.EXECUTING, stamp_s=4.0)


def test_codes_without_a_name_are_told_by_whose_they_are() -> None:
    assert [error_name(code) for code in (9003, 250, 711, 9009, 5)] == [
        "NAVIGATOR_TIMEOUT", "PLANNER_250", "BEHAVIOR_711", "NAVIGATOR_9009", "NAV2_5",
    ]  # fmt: skip


def test_error_codes_have_names() -> None:
    assert error_name(104) == "PATIENCE_EXCEEDED"
    aborted = with_status(GOAL, GoalStatus.ABORTED, stamp_s=2.0, error_code=208)
    assert (aborted.error_code, aborted.error_msg) == (208, "NO_VALID_PATH")


def test_progress_is_told_twice_a_second_whatever_else_is_told_meanwhile() -> None:
    told: list[Goal] = []
    goals = GoalStore(told.append)
    goals.keep(with_status(GOAL, GoalStatus.EXECUTING, stamp_s=10.0))
    active = ActiveGoal("g", GoalRegion((CandidatePose(pose=GOAL.pose),), 0.0), 0, None, begun_s=10.0, deadline_s=100.0)
    for tenth in range(21):
        now_s = 10.0 + tenth / 10.0
        goals.keep(goals.get("g").model_copy(update={"stamp_s": now_s}))
        goals.progress(active, 5.0 - tenth / 10.0, now_s)
    left_m = [goal.distance_remaining_m for goal in told]
    assert [a for a, b in zip(left_m[1:], left_m, strict=False) if a != b] == [5.0, 4.5, 4.0, 3.5, 3.0]


def test_the_number_of_goals_kept_is_bounded() -> None:
    goals = GoalStore(lambda _: None)
    for number in range(GOALS_KEPT + 1):
        goals.keep(GOAL.model_copy(update={"id": str(number)}))
    assert goals.get("1").id == "1"
    with pytest.raises(NotFoundError, match="no goal 0"):
        goals.get("0")


def test_the_celebration_is_as_the_requirement_says() -> None:
    assert [note.frequency_hz for note in SUCCESS.notes] == [262, 330, 392, 523, 659, 784]
    assert all(0.3 <= note.duration_s <= 0.6 for note in SUCCESS.notes)
    assert math.isclose(sum(note.duration_s for note in SUCCESS.notes), 2.3)
    assert (SUCCESS.led_rgb, SUCCESS.led_animation_type, SUCCESS.led_duration_s) == ((0, 255, 0), 2, 3.0)


async def test_a_mailbox_wakes_who_waits_from_another_thread_and_keeps_only_the_newest() -> None:
    box: LatestValue[int] = LatestValue()
    waiting = asyncio.create_task(box.wait_for(lambda reading: reading.value >= 3, 5.0))
    await asyncio.sleep(0)

    def write() -> None:
        for value in (1, 2, 3):
            box.put(value, float(value))

    thread = threading.Thread(target=write)
    thread.start()
    reading = await waiting
    thread.join()
    assert reading is not None
    assert (reading.value, box.age_s(5.0)) == (3, 2.0)


async def test_nothing_wanted_in_time_is_none() -> None:
    box: LatestValue[int] = LatestValue()
    assert await box.wait_for(lambda _: True, 0.01) is None
    box.put(1, 1.0)
    assert await box.wait_for(lambda reading: reading.value > 1, 0.01) is None
    assert await box.wait_for(lambda reading: reading.value == 1, 0.0) is not None


def test_a_session_lives_while_it_beats_and_never_again_once_silent() -> None:
    sessions = Sessions(timeout_s=0.35)
    one = sessions.open(10.0)
    assert sessions.end_silent(10.9) == ()  # still starting
    assert sessions.beat(one, 10.9)
    assert sessions.end_silent(11.2) == ()
    assert sessions.end_silent(11.26) == (one,)
    assert not sessions.beat(one, 11.27)
    with pytest.raises(ConflictError, match="has ended"):
        sessions.check(one)
    sessions.check(None)


def test_the_number_of_sessions_is_bounded() -> None:
    sessions = Sessions(timeout_s=1.0)
    for _ in range(SESSIONS_MAX):
        sessions.open(0.0)
    with pytest.raises(TooManyError):
        sessions.open(0.0)
