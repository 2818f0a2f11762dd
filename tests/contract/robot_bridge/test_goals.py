"""Goals with the habits of a real Nav2: it keeps publishing, gives no reasons, and has other clients."""

from contracts.causes import GoalCause
from contracts.robot import GoalStatus
from contracts.topics import ROBOT_NAVIGATION
from support.bridge_behaviour import NEAR, Rig
from support.waiting import until


async def test_a_nav2_that_keeps_publishing_after_its_goal_has_ended_moves_nothing(rig: Rig) -> None:
    rig.toy.give_ups = 9
    goal = (await rig.goal(clear_costmaps=False)).json()["id"]
    await rig.ended(goal, GoalStatus.ABORTED)
    before = len(rig.toy.velocities)
    await until(lambda: len(rig.toy.velocities) > before + 10)
    assert not any(linear_x for linear_x, _ in rig.toy.velocities[before + 1 :])


async def test_between_two_tries_nothing_that_nav2_publishes_reaches_the_wheels(rig: Rig) -> None:
    """Its controller may drive on without a goal for a second and more."""
    rig.toy.give_ups, rig.toy.give_up_code, rig.toy.thinking = 1, 0, {"costmaps"}
    await rig.goal(pose=NEAR, clear_costmaps=False)
    await until(lambda: any(goal.attempt == 2 for goal in rig.bus.of(ROBOT_NAVIGATION)))
    before = len(rig.toy.velocities)
    await until(lambda: len(rig.toy.velocities) > before + 6)
    assert not any(linear_x for linear_x, _ in rig.toy.velocities[before + 1 : before + 7])
    await until(lambda: rig.toy.has_driven)


async def test_a_goal_that_another_client_of_nav2_ended_is_not_tried_again(rig: Rig) -> None:
    rig.toy.give_ups, rig.toy.give_up_code, rig.toy.preempted = 1, 0, True
    goal = (await rig.goal(pose=NEAR, clear_costmaps=False)).json()["id"]
    ended = await rig.ended(goal, GoalStatus.ABORTED)
    assert (ended.attempt, ended.cause) == (1, GoalCause.FOREIGN_GOAL)
    assert len(rig.toy.goals) == 1
    await until(lambda: rig.toy.at_rest)


async def test_no_distance_is_told_before_nav2_has_a_path(rig: Rig) -> None:
    rig.toy.distance_left_m = 0.0
    await rig.goal(clear_costmaps=False)
    await until(lambda: rig.toy.has_driven)
    assert all(goal.distance_remaining_m is None for goal in rig.bus.of(ROBOT_NAVIGATION))
    rig.toy.distance_left_m = 1.5
    await until(lambda: any(goal.distance_remaining_m == 1.5 for goal in rig.bus.of(ROBOT_NAVIGATION)))
