"""A halt ends all motion, whoever asked for it, and latches nothing."""

import asyncio

import pytest

from contracts.motion import MotionEnd
from contracts.robot import EmergencyStop, GoalStatus
from support.bridge_behaviour import Rig
from support.waiting import until


async def halt(rig: Rig) -> EmergencyStop:
    response = await rig.client.post("/halt")
    assert response.status_code == 200
    return EmergencyStop.model_validate_json(response.content)


async def test_it_ends_a_lease_and_refuses_what_was_asked_for_before(rig: Rig) -> None:
    await rig.velocity(duration_s=2.0)
    await until(lambda: rig.toy.has_driven, timeout_s=30.0)
    stop = await halt(rig)
    assert (rig.toy.at_rest, stop.latched, stop.epoch) == (True, False, 1)
    late = await rig.velocity(duration_s=2.0, epoch=0)
    assert (late.status_code, rig.toy.at_rest) == (409, True)
    assert (await rig.velocity(duration_s=0.3, epoch=1)).json()["accepted"]


async def test_it_ends_a_turn(rig: Rig) -> None:
    turning = asyncio.create_task(rig.client.post("/rotate", json={"angle_rad": 3.0, "epoch": 0}))
    await until(lambda: not rig.toy.at_rest, timeout_s=30.0)
    await halt(rig)
    assert (await turning).json()["end"] == MotionEnd.CANCELED
    assert rig.toy.at_rest


async def test_it_cancels_a_goal(rig: Rig) -> None:
    goal_id = (await rig.goal()).json()["id"]
    await halt(rig)
    assert await rig.goal_status(goal_id) is GoalStatus.CANCELED


@pytest.mark.parametrize("latched", [True, False])
async def test_the_latch_stays_as_it_was(rig: Rig, latched: bool) -> None:
    await rig.client.post("/emergency-stop" if latched else "/emergency-stop/reset")
    assert (await halt(rig)).latched is latched
