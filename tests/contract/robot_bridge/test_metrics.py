"""What the bridge tells Prometheus of the robot."""

from support.bridge_behaviour import Rig
from support.scraped import sample, scraped, untold
from support.waiting import until


async def test_the_robot_is_told_as_it_is_at_the_scrape(rig: Rig) -> None:
    told = await scraped(rig.client)
    assert sample(told, "robot_bridge_emergency_stop_latched") == 0
    assert 0.0 <= sample(told, "robot_bridge_sensor_age_seconds", sensor="scan") < 1.0
    assert 0.0 <= sample(told, "robot_bridge_battery_ratio") <= 1.0
    assert untold(told, "robot_bridge") == set()


async def test_a_stop_is_told_with_the_time_to_its_first_zero(rig: Rig) -> None:
    before = sample(await scraped(rig.client), "robot_bridge_first_zero_seconds_count")
    await rig.client.post("/emergency-stop")
    after = await scraped(rig.client)
    assert sample(after, "robot_bridge_emergency_stop_latched") == 1
    assert sample(after, "robot_bridge_first_zero_seconds_count") == before + 1


async def test_the_wheels_loop_tells_its_beat(rig: Rig) -> None:
    before = sample(await scraped(rig.client), "loop_period_seconds_count", loop="wheels")
    ticked = len(rig.toy.velocities)
    await until(lambda: len(rig.toy.velocities) > ticked + 3)
    assert sample(await scraped(rig.client), "loop_period_seconds_count", loop="wheels") > before + 2


async def test_a_goal_leaves_its_time_and_its_end(rig: Rig) -> None:
    async def canceled() -> float:
        goal = (await rig.goal()).json()["id"]
        await rig.client.delete(f"/navigation/goals/{goal}")
        return sample(await scraped(rig.client), "robot_bridge_goal_seconds_count", status="CANCELED")

    before = await canceled()
    assert await canceled() == before + 1
