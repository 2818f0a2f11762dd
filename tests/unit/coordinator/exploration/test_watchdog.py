"""Every tier of the model's watchdog, every fallback, and listening, on a simulated clock (C6, C7, C9)."""

import itertools
import math

import pytest

from contracts.exploration import ExplorationEnd, ExplorationMode, MoveToward, NavigateToGoal
from contracts.motion import MotionEnd
from coordinator.exploration import commands as do
from coordinator.exploration import events as ev
from coordinator.exploration.decision_check import WAY_HALF_RAD, CheckLimits
from coordinator.exploration.exploration import Advancing, Fallback, Standing
from coordinator.exploration.rules import AskingRules, ExplorationRules, SpendingLimits, WatchdogRules
from coordinator.exploration.surroundings import Surroundings
from coordinator.exploration.transitions import ALLOWED, SENTENCES, TRANSITIONS
from coordinator.exploration.wandering import step_from
from coordinator.exploration.watchdog import SilenceTier, tier_of
from support.exploration_played import FREE, HOME, Played, ahead, closed_chart, open_chart

M = ExplorationMode


def driving(rules: ExplorationRules | None = None) -> Played:
    """Led by the model, on its way, and a question is open that nobody answers."""
    played = Played(rules, obeys=False).begin(open_chart())
    played.answer(ahead(2.0))
    played.pass_time(0.4)
    assert isinstance(played.exploration.activity, Advancing)
    played.pose = HOME.model_copy(update={"x": 1.6})
    played.pass_time(0.2)
    assert played.exploration.question is not None
    return played


# tiers


@pytest.mark.parametrize(
    ("silent_s", "tier"),
    [
        (0.0, SilenceTier.GO_ON), (3.0, SilenceTier.GO_ON), (3.1, SilenceTier.STAND), (10.0, SilenceTier.STAND),
        (10.1, SilenceTier.LOCAL), (30.0, SilenceTier.LOCAL), (30.1, SilenceTier.HOME), (9e9, SilenceTier.HOME),
    ],
)  # fmt: skip
def test_the_tiers_are_those_of_the_requirement(silent_s: float, tier: SilenceTier) -> None:
    assert tier_of(silent_s, WatchdogRules()) is tier


def test_for_3_s_what_is_under_way_goes_on() -> None:
    played = driving().pass_time(2.8)
    assert played.told(do.HaltMotion) == []
    assert isinstance(played.exploration.activity, Advancing)


def test_from_3_to_10_s_the_robot_stands_and_waits() -> None:
    played = driving().pass_time(3.4)
    assert len(played.told(do.HaltMotion)) == 1
    moved = len(played.told(do.MOTION))
    played.pass_time(6.2)
    assert played.mode is M.MODEL
    assert len(played.told(do.MOTION)) == moved


def test_from_10_to_30_s_it_explores_by_the_frontiers() -> None:
    played = driving().pass_time(10.4)
    assert played.mode is M.FRONTIERS
    assert played.told(do.NavigateRobot) != []
    played.pass_time(19.0)
    assert played.mode is M.FRONTIERS


def test_without_a_map_it_wanders_by_the_laser() -> None:
    played = Played().begin()
    played.pass_time(10.6)
    assert played.mode is M.REACTIVE
    played.pass_time(3.0)
    assert played.told(do.DriveRobot) != []


def test_after_30_s_it_drives_home_and_ends_there() -> None:
    played = driving()
    played.obeys = True
    played.pass_time(31.0)
    assert M.RETURNING in played.modes()
    played.pass_time(1.0)
    assert played.mode is M.IDLE
    assert played.exploration.end is ExplorationEnd.MODEL_SILENT
    assert played.pose == HOME
    assert played.told(do.Finish) == [do.Finish(ExplorationEnd.MODEL_SILENT)]


def test_a_model_whose_server_is_killed_is_tried_again_and_again_and_ends_at_home() -> None:
    """Each call fails at once, as with a refused connection."""
    played = Played().begin(open_chart())
    played.answer(ahead())
    for _ in range(400):
        if played.exploration.question is not None:
            played.tell(ev.ModelFailed(played.last_asked.call, "connection refused"))
        played.pass_time(0.2)
    assert played.exploration.end is ExplorationEnd.MODEL_SILENT
    assert played.mode is M.IDLE
    assert played.pose == HOME
    asked_s = [at for at, one in played.commands if isinstance(one, do.AskModel)][1:]
    assert min(later - earlier for earlier, later in itertools.pairwise(asked_s)) >= AskingRules().again_s


def test_home_that_cannot_be_reached_is_said_after_three_tries() -> None:
    played = Played(obeys=False).begin(open_chart())
    played.pose = HOME.model_copy(update={"x": 3.0})
    played.pass_time(31.0)
    for _ in range(20):
        for goal in played.told(do.NavigateRobot)[-1:]:
            played.tell(ev.GoalOver(goal.call, ev.GoalOutcome.NOT_REACHED))
        played.pass_time(0.2)
    assert played.exploration.end is ExplorationEnd.HOME_NOT_REACHED
    assert played.mode is M.IDLE
    assert len([one for one in played.told(do.NavigateRobot) if one.pose == HOME]) == 3


def test_a_model_that_answers_again_leads_again() -> None:
    played = driving().pass_time(12.0)
    assert played.mode is M.FRONTIERS
    played.answer(ahead())
    assert played.mode is M.MODEL
    assert played.exploration.fallback is None
    played.pass_time(2.8)
    assert played.mode is M.MODEL


def test_an_answer_that_comes_too_late_is_not_carried_out() -> None:
    played = Played(obeys=False).begin(open_chart())
    first = played.last_asked.call
    played.pass_time(10.8)
    motions = len(played.told(do.MOTION))
    played.tell(ev.ModelAnswered(first, MoveToward(bearing_rad=2.0, distance_m=1.0)))
    assert len(played.told(do.MOTION)) == motions
    assert played.mode is M.FRONTIERS


# the network


def test_a_network_that_is_gone_counts_as_silence_from_that_moment_though_nothing_was_asked() -> None:
    played = Played(obeys=False).begin(open_chart())
    played.answer(ahead(2.0))
    played.pass_time(0.6)
    played.tell(ev.LinkChanged(up=False))
    asked = len(played.told(do.AskModel))
    played.pass_time(3.4)
    assert isinstance(played.exploration.activity, Standing)
    played.pass_time(7.0)
    assert played.mode is M.FRONTIERS
    assert len(played.told(do.AskModel)) == asked, "nobody is asked over a network that is not there"
    played.tell(ev.LinkChanged(up=True))
    assert len(played.told(do.AskModel)) == asked + 1
    played.answer(ahead())
    assert played.mode is M.MODEL


def test_a_network_that_is_gone_at_the_start_ends_at_home_too() -> None:
    played = Played()
    played.tell(ev.LinkChanged(up=False))
    played.begin(open_chart()).pass_time(32.0)
    assert played.exploration.end is ExplorationEnd.MODEL_SILENT
    assert played.told(do.AskModel) == []


def test_an_exploration_without_a_model_does_not_mind_the_network() -> None:
    played = Played(ExplorationRules(pilot=M.FRONTIERS), obeys=False).begin(open_chart())
    played.tell(ev.LinkChanged(up=False))
    played.pass_time(40.0)
    assert played.mode is M.FRONTIERS


# fallbacks


def test_three_refusals_in_a_row_make_one_stretch_without_the_model() -> None:
    played = Played().begin(open_chart())
    for _ in range(3):
        played.pass_time(5.0, until=lambda: played.exploration.question is not None)
        played.answer(NavigateToGoal(x_m=900.0, y_m=0.0))
    assert played.exploration.fallback is Fallback.REFUSED
    assert played.mode is M.FRONTIERS
    played.pass_time(3.0)
    assert played.modes()[-2:] == [M.FRONTIERS, M.MODEL]
    assert played.told(do.NavigateRobot) != []


def test_an_answer_between_refusals_that_is_accepted_forgives_them() -> None:
    played = Played().begin(open_chart())
    for decision in (None, None, ahead(), None, None, ahead()):
        played.pass_time(5.0, until=lambda: played.exploration.question is not None)
        played.answer(decision)
    assert played.modes() == [M.MODEL]


@pytest.mark.parametrize("limits", [SpendingLimits(calls_max=3), SpendingLimits(tokens_max=30)])
def test_what_is_spent_up_leaves_the_rest_to_the_frontiers(limits: SpendingLimits) -> None:
    played = Played(ExplorationRules(spending=limits)).begin(open_chart())
    for _ in range(6):
        played.pass_time(3.0, until=lambda: played.exploration.question is not None)
        if played.exploration.question is not None:
            played.answer(ahead(0.5))
    assert played.exploration.fallback is Fallback.SPENT
    assert played.mode is M.FRONTIERS
    assert len(played.told(do.AskModel)) == 3
    played.pass_time(60.0)
    assert len(played.told(do.AskModel)) == 3


def test_what_is_spent_up_while_the_frontiers_stand_in_leaves_them_to_it() -> None:
    played = driving(ExplorationRules(spending=SpendingLimits(calls_max=2))).pass_time(14.0)
    assert played.mode is M.FRONTIERS
    assert played.modes() == [M.MODEL, M.FRONTIERS]
    assert played.exploration.fallback is Fallback.SPENT
    played.pass_time(40.0)
    assert M.RETURNING not in played.modes(), "no answer is owed any more"


def test_seconds_of_waiting_are_spent_too() -> None:
    played = Played(ExplorationRules(spending=SpendingLimits(seconds_max=4.0))).begin(open_chart())
    for _ in range(4):
        played.pass_time(3.0, until=lambda: played.exploration.question is not None)
        if played.exploration.question is not None:
            played.pass_time(2.1)
            played.answer(ahead(0.5))
    assert played.exploration.spent.seconds == pytest.approx(4.2, abs=0.3)
    assert played.exploration.fallback is Fallback.SPENT


def test_a_map_without_a_frontier_left_three_times_is_explored() -> None:
    played = Played(ExplorationRules(pilot=M.FRONTIERS)).begin(closed_chart())
    for _ in range(3):
        played.tell(ev.ChartSeen(closed_chart()))
    played.pass_time(2.0)
    assert played.exploration.end is ExplorationEnd.EXPLORED
    assert played.mode is M.IDLE


def test_a_frontier_that_stays_after_two_visits_is_given_up() -> None:
    played = Played(ExplorationRules(pilot=M.FRONTIERS)).begin(open_chart())
    played.pass_time(6.0)
    assert len(played.exploration.memory.given_up) == len(open_chart().frontiers)
    assert len(played.told(do.NavigateRobot)) == 2 * len(open_chart().frontiers)


def test_time_that_is_up_ends_at_home() -> None:
    played = Played(ExplorationRules(pilot=M.REACTIVE, duration_s=20.0)).begin(open_chart())
    played.pass_time(22.0)
    assert played.exploration.end is ExplorationEnd.TIME_UP
    assert played.pose == HOME


# what was not taken


def test_goals_that_were_not_taken_are_no_visits_and_are_tried_again_after_a_second() -> None:
    played = Played(ExplorationRules(pilot=M.FRONTIERS), obeys=False).begin(open_chart())
    for sent in range(1, 6):
        assert len(played.told(do.NavigateRobot)) == sent
        goal = played.told(do.NavigateRobot)[-1]
        played.tell(ev.GoalOver(goal.call, ev.GoalOutcome.FAILED))
        played.pass_time(0.8)
        assert len(played.told(do.NavigateRobot)) == sent, "nothing is begun again for a second"
        played.pass_time(0.4)
    assert (played.exploration.visits, played.exploration.memory.given_up) == ((), ())
    assert played.mode is M.FRONTIERS


def test_goals_home_that_were_not_taken_are_no_tries() -> None:
    played = Played(ExplorationRules(pilot=M.FRONTIERS, duration_s=1.0), obeys=False).begin(open_chart())
    played.pose = HOME.model_copy(update={"x": 3.0})
    played.pass_time(1.2)
    for _ in range(6):
        played.tell(ev.GoalOver(played.told(do.NavigateRobot)[-1].call, ev.GoalOutcome.FAILED))
        played.pass_time(1.2)
    assert (played.mode, played.exploration.home_tries) == (M.RETURNING, 0)


@pytest.mark.parametrize("end", [None, MotionEnd.SESSION_ENDED, MotionEnd.BASE_BUSY, MotionEnd.PREEMPTED])
def test_turns_and_drives_that_were_not_taken_are_tried_again_after_a_second(end: MotionEnd | None) -> None:
    played = Played(ExplorationRules(pilot=M.REACTIVE), obeys=False).begin()
    for _ in range(5):
        played.pass_time(0.2)
        motions = played.told(do.MOTION)  # pyright: ignore[reportArgumentType]
        played.tell(ev.MotionOver(motions[-1].call, end))
        played.pass_time(0.8)
        assert len(played.told(do.MOTION)) == len(motions)  # pyright: ignore[reportArgumentType]
        played.pass_time(0.2)


def test_what_the_model_answers_while_nothing_is_taken_moves_nothing() -> None:
    played = driving()
    played.tell(ev.MotionOver(played.told(do.DriveRobot)[-1].call, None))
    motions = len(played.told(do.MOTION))  # pyright: ignore[reportArgumentType]
    played.answer(NavigateToGoal(x_m=2.0, y_m=0.0))
    played.pass_time(0.8)
    assert len(played.told(do.MOTION)) == motions  # pyright: ignore[reportArgumentType]
    played.pass_time(1.0)
    assert len(played.told(do.MOTION)) > motions  # pyright: ignore[reportArgumentType]


def test_where_nothing_is_taken_for_long_it_ends_and_says_so() -> None:
    rules = ExplorationRules(pilot=M.FRONTIERS, failures_max=4)
    played = Played(rules, obeys=False).begin(open_chart())
    for outcome in ("FAILED", "FAILED", "FAILED", "NOT_REACHED", "FAILED", "FAILED", "FAILED"):
        played.tell(ev.GoalOver(played.told(do.NavigateRobot)[-1].call, ev.GoalOutcome[outcome]))
        played.pass_time(1.2)
    assert played.mode is M.FRONTIERS
    played.tell(ev.GoalOver(played.told(do.NavigateRobot)[-1].call, ev.GoalOutcome.FAILED))
    assert (played.mode, played.exploration.end) == (M.IDLE, ExplorationEnd.MOTION_FAILED)


def test_short_pauses_on_the_way_home_are_no_tries() -> None:
    played = Played(ExplorationRules(pilot=M.FRONTIERS, duration_s=1.0), obeys=False).begin(open_chart())
    played.pose = HOME.model_copy(update={"x": 3.0})
    played.pass_time(1.2)
    for _ in range(5):
        assert played.mode is M.RETURNING
        played.tell(ev.ListenStarted(for_s=2.0))
        played.pass_time(2.4)
    assert (played.mode, played.exploration.home_tries) == (M.RETURNING, 0)
    played.pass_time(3 * 121.0)
    assert played.exploration.end is ExplorationEnd.HOME_NOT_REACHED, "those that are overdue are"


# listening


@pytest.mark.parametrize("pilot", [M.MODEL, M.FRONTIERS, M.REACTIVE])
def test_listening_stands_and_then_goes_on_in_the_mode_before(pilot: ExplorationMode) -> None:
    played = Played(ExplorationRules(pilot=pilot), obeys=False).begin(open_chart())
    played.pass_time(0.4)
    played.tell(ev.ListenStarted(for_s=5.0))
    assert played.mode is M.LISTENING
    assert isinstance(played.exploration.activity, Standing)
    motions = len(played.told(do.MOTION))
    played.pass_time(4.6)
    assert (played.mode, len(played.told(do.MOTION))) == (M.LISTENING, motions)
    played.pass_time(0.6)
    assert played.mode is pilot


def test_listening_in_the_local_tier_or_on_the_way_home_goes_on_there() -> None:
    for silent_s, mode in ((12.0, M.FRONTIERS), (31.0, M.RETURNING)):
        played = Played(obeys=False).begin(open_chart())
        played.pose = HOME.model_copy(update={"x": 2.0})
        played.pass_time(silent_s)
        played.tell(ev.ListenStarted(for_s=60.0))
        played.tell(ev.ListenEnded())
        assert played.mode is mode


def test_the_time_it_listens_does_not_count_against_the_model() -> None:
    played = driving()
    played.pass_time(2.0)
    played.tell(ev.ListenStarted(for_s=40.0))
    played.pass_time(40.4)
    assert played.mode is M.MODEL
    played.pass_time(0.6)
    assert played.mode is M.MODEL


def test_an_answer_while_it_listens_moves_nothing() -> None:
    played = Played(obeys=False).begin(open_chart())
    call = played.last_asked.call
    played.tell(ev.ListenStarted(for_s=5.0))
    played.tell(ev.ModelAnswered(call, ahead()))
    assert played.told(do.MOTION) == []
    assert played.mode is M.LISTENING


# a question that is dropped


@pytest.mark.parametrize("drop", ["listened", "overdue", "home", "cancelled"])
def test_a_question_that_is_dropped_is_counted_and_its_late_answer_once(drop: str) -> None:
    duration_s = 3.0 if drop == "home" else 1200.0
    rules = ExplorationRules(duration_s=duration_s, watchdog=WatchdogRules(local_s=40.0, home_s=60.0))
    played = Played(rules, obeys=False).begin(open_chart())
    played.pose = HOME.model_copy(update={"x": 2.0})
    call = played.last_asked.call
    played.pass_time(10.4 if drop == "overdue" else 3.2)
    if drop == "listened":
        played.tell(ev.ListenStarted(for_s=5.0))
    elif drop == "cancelled":
        played.tell(ev.ExplorationCanceled())
    waited_s = {"overdue": 10.0, "home": 3.0}.get(drop, 3.2)
    assert played.exploration.spent.seconds == pytest.approx(waited_s, abs=0.25)
    for _ in range(3):
        played.tell(ev.ModelAnswered(call, ahead(), tokens=500))
    assert played.exploration.spent.tokens == 500
    assert played.told(do.DriveRobot) == []


# the stop


@pytest.mark.parametrize("pilot", [M.MODEL, M.FRONTIERS, M.REACTIVE])
def test_the_emergency_stop_ends_it_and_nothing_goes_on_by_itself(pilot: ExplorationMode) -> None:
    played = Played(ExplorationRules(pilot=pilot)).begin(open_chart())
    played.pass_time(1.0)
    played.stopped = True
    played.pass_time(0.2)
    before = len(played.commands)
    if pilot is M.MODEL:
        played.tell(ev.ModelAnswered(played.last_asked.call, ahead()))
    played.tell(ev.Begun(HOME))
    played.pass_time(5.0)
    played.stopped = False
    played.pass_time(60.0)
    assert played.mode is M.IDLE
    assert played.exploration.end is ExplorationEnd.STOPPED
    assert len(played.commands) == before


@pytest.mark.parametrize(("epochs", "ends"), [((4, 5), True), ((4, None, 5), True), ((4, 4), False), ((4, 3), False)])
def test_a_stop_that_came_and_went_unseen_is_told_by_its_epoch(epochs: tuple[int | None, ...], ends: bool) -> None:
    played = Played(obeys=False).begin(open_chart())
    for epoch in epochs:
        played.tell(ev.RobotSeen(HOME, played.exploration.surroundings, epoch=epoch))
    assert (played.exploration.end is ExplorationEnd.STOPPED) == ends
    assert (played.mode is M.IDLE) == ends


def test_a_cancel_ends_it_where_it_stands() -> None:
    played = driving()
    played.tell(ev.ExplorationCanceled())
    assert played.exploration.end is ExplorationEnd.CANCELED
    assert isinstance(played.told(do.HaltMotion)[-1], do.HaltMotion)


# motion


def test_after_a_turn_the_way_is_checked_by_a_scan_taken_after_it() -> None:
    played = Played(obeys=False).begin(open_chart())
    played.answer(MoveToward(bearing_rad=1.0, distance_m=1.0))
    (turn,) = played.told(do.TurnRobot)
    played.scan_age_s = 0.4
    played.pass_time(0.2)
    played.tell(ev.MotionOver(turn.call, MotionEnd.COMPLETED))
    played.pass_time(0.2)
    assert played.told(do.DriveRobot) == [], "the scan is from before the turn was over"
    played.pass_time(0.4)
    assert len(played.told(do.DriveRobot)) == 1


def test_a_wander_takes_no_way_that_the_check_of_the_drive_would_find_blind() -> None:
    limits = CheckLimits()
    scan = Surroundings(1000.0, FREE, ((-0.25, 0.25),))
    motion = step_from(HOME, scan, (), (), 1000.0, limits)
    assert motion is not None
    assert not scan.says_nothing_about(motion.bearing_rad, WAY_HALF_RAD)
    everywhere = Surroundings(1000.0, FREE, ((-math.pi, 0.0), (0.0, math.pi)))
    assert step_from(HOME, everywhere, (), (), 1000.0, limits) is None


def test_a_way_that_is_blind_once_it_was_turned_to_counts_as_blocked() -> None:
    played = Played(obeys=False).begin(open_chart())
    played.answer(MoveToward(bearing_rad=1.0, distance_m=1.0))
    (turn,) = played.told(do.TurnRobot)
    played.pose = HOME.model_copy(update={"yaw": 1.0})
    played.silent_rad = ((-0.25, 0.25),)
    played.pass_time(0.2)
    played.tell(ev.MotionOver(turn.call, MotionEnd.COMPLETED))
    played.pass_time(0.4)
    assert [one.heading_rad for one in played.exploration.tries] == [1.0]


def test_a_motion_whose_answer_never_comes_is_ended() -> None:
    played = Played(ExplorationRules(pilot=M.FRONTIERS), obeys=False).begin(open_chart())
    played.pass_time(0.2)
    first = played.told(do.NavigateRobot)[0]
    played.pass_time(121.0)
    assert played.told(do.HaltMotion) != []
    assert played.told(do.NavigateRobot)[1].call > first.call


# the table


def test_the_table_names_every_mode_and_says_why() -> None:
    assert set(TRANSITIONS) == set(SENTENCES) == set(ExplorationMode)
    assert all(why for to in TRANSITIONS.values() for why in to.values())
    assert all(M.IDLE in to for mode, to in ALLOWED.items() if mode is not M.IDLE)
