"""The arm's routes, with a fake arm, and without any."""

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path

import httpx
import pytest

from contracts.arm import ArmEnd, ArmPart, ArmRefusal, ArmReply, ArmState, GripperReply
from robot_bridge.arm.models import SO101
from robot_bridge.settings import Settings
from support.arm_behaviour import (
    REACHED,
    ArmBehaviour,
    arm_state,
    code,
    move,
    near,
    positions,
    stands,
    starts_moving,
    trajectory,
)
from support.bridge_behaviour import Rig, running
from support.fake_arm import FakeArm
from support.fake_robot import FakeRobot
from support.toy_robot import ToyRobot
from support.waiting import until, until_true

from .conftest import Served, serving
from .test_connections import beating, client, session


@pytest.fixture
async def arm() -> AsyncIterator[FakeArm]:
    async with FakeArm().alive() as arm:
        yield arm


@pytest.fixture
async def armed(tmp_path: Path, arm: FakeArm) -> AsyncIterator[Rig]:
    toy = ToyRobot()
    async with running(tmp_path, toy, FakeRobot(toy), arm_given=arm) as rig:
        yield rig


@pytest.fixture
async def served_with_arm(tmp_path: Path, arm: FakeArm) -> AsyncIterator[Served]:
    async with serving(Settings(state_dir=tmp_path), ToyRobot(), arm=arm) as served:
        yield served


class TestFakeArm(ArmBehaviour):
    @pytest.fixture
    def rig(self, armed: Rig) -> Rig:
        return armed


BODIES: dict[str, dict[str, object]] = {
    "/arm/trajectory": trajectory(REACHED, 3.0),
    "/arm/home": {"epoch": 0},
    "/arm/gripper": {"opening": 1.0, "epoch": 0},
}


async def test_a_robot_without_an_arm_says_so(rig: Rig) -> None:
    assert await arm_state(rig.client) == ArmState(fitted=False)
    assert (await rig.post("/arm/stop")).json() == {"ended": []}


@pytest.mark.parametrize("path", BODIES)
async def test_a_robot_without_an_arm_refuses_to_move_one(rig: Rig, path: str) -> None:
    answer = await rig.post(path, BODIES[path])
    assert (answer.status_code, code(answer)) == (409, ArmRefusal.NO_ARM)


async def test_an_arm_is_a_line_of_readiness_only_where_there_is_one(rig: Rig, armed: Rig, arm: FakeArm) -> None:
    async def line(of: Rig) -> list[str]:
        told = (await of.client.get("/ready")).json()["dependencies"]
        return [each["state"] for each in told if each["name"] == "arm"]

    assert await line(rig) == []
    assert await line(armed) == ["ready"]
    arm.there = False
    assert await line(armed) == ["warning"]
    assert (await armed.client.get("/ready")).status_code == 200


async def test_an_arm_that_is_away_is_a_dependency_that_is_away(armed: Rig, arm: FakeArm) -> None:
    arm.there = False
    answer = await armed.post("/arm/trajectory", trajectory(REACHED, 3.0))
    assert answer.status_code == 503
    assert (await arm_state(armed.client)).under_way == ()


async def test_a_part_whose_cancel_is_not_answered_is_not_moved_and_the_other_is(armed: Rig, arm: FakeArm) -> None:
    arm.owes.add(ArmPart.ARM)
    for path in ("/arm/trajectory", "/arm/home"):
        answer = await armed.post(path, BODIES[path])
        assert (answer.status_code, code(answer)) == (503, ArmRefusal.CANCEL_OWED)
    assert (await armed.post("/arm/gripper", BODIES["/arm/gripper"])).status_code == 200
    arm.owes = {ArmPart.GRIPPER}
    answer = await armed.post("/arm/gripper", BODIES["/arm/gripper"])
    assert (answer.status_code, code(answer)) == (503, ArmRefusal.CANCEL_OWED)
    assert (await armed.post("/arm/home", BODIES["/arm/home"])).status_code == 200


async def test_joints_that_nobody_tells_of_are_not_moved(armed: Rig, arm: FakeArm) -> None:
    arm.told = False

    async def old() -> bool:
        return (await arm_state(armed.client)).moving is None

    await until_true(old)
    assert (await arm_state(armed.client)).opening is None
    for path, body in BODIES.items():
        answer = await armed.post(path, body)
        assert (answer.status_code, code(answer)) == (503, ArmRefusal.NO_JOINT_STATES)


async def test_while_a_joint_moves_no_trajectory_begins(armed: Rig, arm: FakeArm) -> None:
    """It is checked from rest, and the controller would begin it with the joints' speed."""
    arm.move_by_somebody_else(REACHED, 6.0)

    async def moves() -> bool:
        return (await arm_state(armed.client)).moving is True

    await until_true(moves)
    for path in ("/arm/trajectory", "/arm/home"):
        answer = await armed.post(path, BODIES[path])
        assert (answer.status_code, code(answer)) == (409, ArmRefusal.JOINT_MOVES)
    assert (await armed.post("/arm/gripper", BODIES["/arm/gripper"])).status_code == 200


async def test_a_goal_that_the_controller_does_not_take_is_told(armed: Rig, arm: FakeArm) -> None:
    arm.rejects = True
    assert (await move(armed, REACHED, 3.0)).end is ArmEnd.REJECTED


async def test_a_jaw_that_meets_something_has_stalled_and_holds_it_through_a_stop(armed: Rig, arm: FakeArm) -> None:
    await armed.post("/arm/gripper", {"opening": 1.0, "epoch": 0})
    arm.jaw_stops_at = SO101.jaw.position(0.4)
    answer = await armed.post("/arm/gripper", {"opening": 0.0, "epoch": 0})
    assert GripperReply.model_validate_json(answer.content).end is ArmEnd.STALLED
    await armed.post("/emergency-stop")
    assert arm.jaw_wanted == SO101.jaw.closed


async def test_the_jaw_presses_no_harder_than_the_setting_lets_it(armed: Rig, arm: FakeArm) -> None:
    await armed.post("/arm/gripper", {"opening": 1.0, "effort_share": 1.0, "epoch": 0})
    assert arm.jaw_effort_max == pytest.approx(armed.settings.arm_effort_share_max * SO101.jaw.effort_max)


async def test_what_somebody_else_moves_during_a_stop_is_cancelled_again(armed: Rig, arm: FakeArm) -> None:
    await armed.post("/emergency-stop")
    cancelled = arm.cancels
    arm.move_by_somebody_else(REACHED, 3.0)
    await until(lambda: arm.cancels > cancelled)
    assert not near(await stands(armed.client), REACHED)


async def test_what_somebody_else_moves_during_a_stop_is_cancelled_though_nobody_tells_of_the_joints(
    armed: Rig, arm: FakeArm
) -> None:
    await armed.post("/emergency-stop")
    arm.told = False

    async def old() -> bool:
        return (await arm_state(armed.client)).moving is None

    await until_true(old)
    arm.move_by_somebody_else(REACHED, 3.0)
    cancelled = arm.cancels
    await until(lambda: arm.cancels > cancelled)
    arm.told = True
    assert not near(await stands(armed.client), REACHED)


async def test_what_moves_too_slowly_to_be_seen_during_a_stop_is_cancelled(armed: Rig, arm: FakeArm) -> None:
    await armed.post("/emergency-stop")
    cancelled = arm.cancels
    arm.move_by_somebody_else(REACHED, 60.0)
    await until(lambda: arm.cancels > cancelled + 2)
    assert near(await stands(armed.client), SO101.home_rad)


async def test_a_controller_that_never_ends_is_given_up(arm: FakeArm, tmp_path: Path) -> None:
    toy = ToyRobot()
    async with running(tmp_path, toy, FakeRobot(toy), arm_given=arm, arm_late_s_max=0.2) as rig:
        arm.hangs = True
        assert (await move(rig, REACHED, 2.0)).end is ArmEnd.TIMED_OUT
        assert (await arm_state(rig.client)).under_way == ()


async def test_a_goal_whose_acceptance_is_lost_does_not_go_on(armed: Rig, arm: FakeArm) -> None:
    arm.loses_acceptance = True
    assert (await armed.post("/arm/trajectory", trajectory(REACHED, 3.0))).status_code == 504
    assert (await arm_state(armed.client)).under_way == ()
    assert near(await stands(armed.client), SO101.home_rad)


async def test_a_motion_ends_with_its_session(served_with_arm: Served) -> None:
    served = served_with_arm
    async with client(served) as http, session(served) as (socket, session_id), beating(socket):
        body = trajectory(REACHED, 3.0, session_id=session_id)
        moving = asyncio.create_task(http.post("/arm/trajectory", json=body))
        await starts_moving(http)
        socket.transport.abort()
        assert ArmReply.model_validate_json((await moving).content).end is ArmEnd.SESSION_ENDED
        assert not near(await stands(http), REACHED)
        assert (await http.post("/arm/trajectory", json=body)).status_code == 409


async def test_a_motion_ends_when_its_client_goes_away(served_with_arm: Served) -> None:
    async with client(served_with_arm) as http:
        moving = asyncio.create_task(http.post("/arm/trajectory", json=trajectory(REACHED, 3.0)))
        await starts_moving(http)
        moving.cancel()
        with pytest.raises(asyncio.CancelledError):
            await moving

        async def over() -> bool:
            return (await arm_state(http)).under_way == ()

        await until_true(over)
        assert not near(await stands(http), REACHED)


@pytest.mark.parametrize(
    "wrong",
    [
        {"joints": []},
        {"points": []},
        {"epoch": -1},
        {"points": [{"time_s": 0.0, "positions_rad": REACHED}]},
        {"points": [{"time_s": 1.0, "positions_rad": ["NaN"] * 5}]},
        {"points": [{"time_s": 1e-310, "positions_rad": REACHED}]},
        {"points": [{"time_s": 10.0, "positions_rad": REACHED, "velocities_rad_s": [1e308] * 5}]},
        {"speed": 1.0},
    ],
)
async def test_what_is_no_trajectory_is_refused(armed: Rig, wrong: dict[str, object]) -> None:
    answer: httpx.Response = await armed.post("/arm/trajectory", trajectory(REACHED, 3.0) | wrong)
    assert answer.status_code == 422
    assert near(await positions(armed.client), SO101.home_rad)
