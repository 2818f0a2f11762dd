"""What is kept of what comes in."""

import pytest

from contracts.geometry import Pose2D, Twist2D
from contracts.robot import EmergencyStop, EmergencyStopReply, Goal, GoalStatus
from support.ui_world import STARTED_S, event, mission, robot_state, status
from ui.latest_facts import LatestFacts


def test_the_trail_grows_by_steps_not_by_messages() -> None:
    facts = LatestFacts(trail_step_m=0.05)
    for x in (0.0, 0.01, 0.02, 0.06, 0.13):
        facts.take_robot(robot_state(Pose2D(x=x, y=0.0, yaw=0.0)), now_s=1.0)
    assert [pose.x for pose in facts.trail] == [0.0, 0.06, 0.13]


def test_where_it_drove_in_one_map_is_not_drawn_on_another() -> None:
    facts = LatestFacts()
    for x, map_id in ((0.0, None), (1.0, "home"), (2.0, None), (3.0, "home"), (9.0, "office"), (9.5, "office")):
        state = robot_state(Pose2D(x=x, y=0.0, yaw=0.0))
        facts.take_robot(state.model_copy(update={"map_id": map_id}), now_s=1.0)
    assert [pose.x for pose in facts.trail] == [9.0, 9.5]


def test_a_long_trail_is_thinned_and_keeps_its_ends() -> None:
    facts = LatestFacts(trail_points_max=100)
    for step in range(1000):
        facts.take_robot(robot_state(Pose2D(x=step * 0.1, y=0.0, yaw=0.0)), now_s=1.0)
    assert len(facts.trail) <= 100
    assert facts.trail[0].x == 0.0
    assert facts.trail[-1].x == 99.9


def test_a_new_mission_begins_a_new_trail_and_timeline() -> None:
    facts = LatestFacts()
    facts.take_mission(status(mission()), now_s=1.0)
    facts.take_events([event(1, "one")])
    for x in (0.0, 1.0):
        facts.take_robot(robot_state(Pose2D(x=x, y=0.0, yaw=0.0)), now_s=1.0)
    facts.take_mission(status(mission(id="m-2")), now_s=2.0)
    assert [pose.x for pose in facts.trail] == [1.0]
    assert facts.events == ()


def test_events_are_kept_once_in_order_and_bounded() -> None:
    facts = LatestFacts(events_kept=3)
    facts.take_events([event(2, "two"), event(1, "one")])
    facts.take_events([event(2, "two"), event(3, "three"), event(4, "four")])
    assert [one.id for one in facts.events] == [2, 3, 4]


def test_a_late_message_does_not_take_a_stop_away() -> None:
    facts = LatestFacts()
    reply = EmergencyStopReply(state=EmergencyStop(latched=True, epoch=5), first_zero_ms=3.0)
    facts.take_stop_reply(reply, now_s=10.0)
    facts.take_robot(robot_state(stop=EmergencyStop(latched=False, epoch=4)), now_s=10.1)
    assert facts.stop is not None
    assert facts.stop.latched
    assert facts.first_zero_ms == 3.0


def test_a_bridge_that_began_anew_is_believed_after_a_while() -> None:
    facts = LatestFacts()
    facts.take_stop(EmergencyStop(latched=True, epoch=5), now_s=10.0)
    facts.take_stop(EmergencyStop(latched=False, epoch=0), now_s=12.0)
    assert facts.stop is not None
    assert not facts.stop.latched


def test_the_measured_time_belongs_to_its_own_stop() -> None:
    facts = LatestFacts()
    first = EmergencyStopReply(state=EmergencyStop(latched=True, epoch=1), first_zero_ms=3.0)
    facts.take_stop_reply(first, now_s=1.0)
    facts.take_stop(EmergencyStop(latched=True, epoch=2), now_s=2.0)
    assert facts.first_zero_ms is None


def test_the_time_to_rest_is_measured_from_a_stop_that_was_seen_to_happen() -> None:
    facts = LatestFacts()
    facts.take_robot(robot_state(), now_s=1.0)
    stop = EmergencyStop(latched=True, epoch=1, since_s=STARTED_S + 1.0)
    for after_s, speed in ((1.1, 0.2), (1.2, 0.1), (1.3, 0.0), (5.0, 0.0)):
        still = robot_state(stop=stop).model_copy(
            update={"stamp_s": STARTED_S + after_s, "twist": Twist2D(linear_x=speed)}
        )
        facts.take_robot(still, now_s=after_s)
    assert facts.rest_after_s == pytest.approx(0.3)


def test_a_stop_that_was_found_latched_has_no_time_to_rest() -> None:
    facts = LatestFacts()
    stop = EmergencyStop(latched=True, epoch=1, since_s=STARTED_S - 100.0)
    facts.take_robot(robot_state(stop=stop).model_copy(update={"twist": Twist2D()}), now_s=1.0)
    assert facts.rest_after_s is None


def test_a_goal_is_kept_while_it_is_open() -> None:
    facts = LatestFacts()
    goal = Goal(id="g", pose=Pose2D(x=1.0, y=0.0, yaw=0.0), status=GoalStatus.EXECUTING, stamp_s=1.0)
    facts.take_goal(goal)
    facts.take_plan((goal.pose,))
    facts.take_goal(goal.model_copy(update={"status": GoalStatus.SUCCEEDED}))
    assert (facts.goal, facts.planned) == (None, ())
