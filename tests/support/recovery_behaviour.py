"""What a goal does for itself when Nav2 gives it up before a wall: for the fake port and for real ROS 2.

Their wall is ahead wherever the robot is; that of a simulated room would be left behind.
"""

from contracts.robot import GoalStatus
from contracts.topics import ROBOT_NAVIGATION, ROBOT_STATE
from support.bridge_behaviour import LONG_S, NEAR, Rig
from support.waiting import until


class RecoveryBehaviour:
    """A module that runs it defines the fixture `rig`."""

    async def test_before_another_try_a_robot_that_stands_too_near_a_wall_backs_off(self, rig: Rig) -> None:
        await rig.stands_before_a_wall()
        rig.toy.navigation, rig.toy.give_ups, rig.toy.give_up_code = "succeeds", 1, 105
        goal = (await rig.goal(pose=NEAR, clear_costmaps=False)).json()["id"]
        ended = await rig.ended(goal, GoalStatus.SUCCEEDED)
        assert ended.attempt == 2
        assert -0.35 < rig.toy.x < -0.15
        assert len(rig.toy.goals) == 2

    async def test_nav2_is_not_waited_for_where_the_safety_filter_holds_the_robot(self, rig: Rig) -> None:
        """It drives against the wall for ever; the robot backs off, twice, and the last try is Nav2's own."""
        await rig.stands_before_a_wall()
        goal = (await rig.goal(pose=NEAR, clear_costmaps=False)).json()["id"]
        await until(lambda: len(rig.toy.goals) == 3, timeout_s=LONG_S)
        told = [one for one in rig.bus.of(ROBOT_NAVIGATION) if one.id == goal and one.attempt > 1]
        assert any("obstacle ahead" in one.error_msg for one in told)
        assert not rig.toy.has_driven
        assert rig.toy.x < -0.3
        await rig.client.delete(f"/navigation/goals/{goal}")
        assert (await rig.ended(goal, GoalStatus.CANCELED)).attempt == 3
        await until(lambda: rig.toy.at_rest)

    async def test_nothing_is_driven_after_a_turn_for_room_that_somebody_ended(self, rig: Rig) -> None:
        """Not allowed to reverse, it turns round before it drives; where it looks half way nobody has judged."""
        await rig.stands_before_a_wall()
        rig.toy.hazards |= {"BACKUP_LIMIT"}
        await until(lambda: "BACKUP_LIMIT" in {each.upper() for each in rig.bus.of(ROBOT_STATE)[-1].hazards})
        rig.toy.give_ups, rig.toy.give_up_code = 1, 105
        goal = (await rig.goal(pose=NEAR, clear_costmaps=False)).json()["id"]
        await until(lambda: any(angular_z != 0.0 for _, angular_z in rig.toy.velocities), timeout_s=LONG_S)
        ended = (await rig.client.delete("/motion")).json()
        assert ended["turned_rad"] is not None
        await until(lambda: len(rig.toy.goals) == 2, timeout_s=LONG_S)
        assert not rig.toy.has_driven
        await rig.client.delete(f"/navigation/goals/{goal}")
        await rig.ended(goal, GoalStatus.CANCELED)

    async def test_a_goal_cancelled_while_the_robot_backs_off_ends_that_too(self, rig: Rig) -> None:
        await rig.stands_before_a_wall()
        rig.toy.give_ups, rig.toy.give_up_code = 1, 105
        goal = (await rig.goal(pose=NEAR, clear_costmaps=False)).json()["id"]
        await until(lambda: any(linear_x < 0.0 for linear_x, _ in rig.toy.velocities), timeout_s=LONG_S)
        await rig.client.delete(f"/navigation/goals/{goal}")
        assert (await rig.ended(goal, GoalStatus.CANCELED)).attempt == 2
        await until(lambda: rig.toy.at_rest)
        assert rig.toy.x > -0.2
        assert len(rig.toy.goals) == 1
