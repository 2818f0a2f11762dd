"""What an arm does behind the bridge's front door, whatever it is: a fake one, and the simulated one over ROS."""

import asyncio
import math
from typing import Any

import httpx

from contracts.arm import ArmEnd, ArmPart, ArmRefusal, ArmReply, ArmState, GripperReply
from contracts.causes import Refusal
from robot_bridge.arm.models import SO101
from support.bridge_behaviour import LONG_S, Rig
from support.waiting import until_true

REACHED = (0.6, -0.9, 0.9, -0.4, 0.3)
"""Up and ahead of the robot, free of it on the way from home and back."""
STILL = (0.0,) * 5
NEAR_RAD = 0.06


def trajectory(positions: tuple[float, ...], seconds: float, *, epoch: int = 0, **more: Any) -> dict[str, Any]:
    point = {"time_s": seconds, "positions_rad": positions, "velocities_rad_s": STILL}
    return {"joints": SO101.names, "points": [point], "epoch": epoch} | more


async def arm_state(http: httpx.AsyncClient) -> ArmState:
    return ArmState.model_validate_json((await http.get("/arm")).content)


async def positions(http: httpx.AsyncClient) -> tuple[float, ...]:
    told = [joint.position_rad for joint in (await arm_state(http)).joints]
    assert None not in told
    return tuple(each for each in told if each is not None)


def near(one: tuple[float, ...], other: tuple[float, ...]) -> bool:
    return all(math.isclose(a, b, abs_tol=NEAR_RAD) for a, b in zip(one, other, strict=True))


async def starts_moving(http: httpx.AsyncClient) -> None:
    async def moving() -> bool:
        state = await arm_state(http)
        return bool(state.moving) and state.under_way != ()

    await until_true(moving, timeout_s=LONG_S)


async def stands(http: httpx.AsyncClient) -> tuple[float, ...]:
    """Where it stands, once it does."""

    async def still() -> bool:
        return (await arm_state(http)).moving is False

    await until_true(still, timeout_s=LONG_S)
    return await positions(http)


async def post_settled(rig: Rig, path: str, body: dict[str, Any]) -> httpx.Response:
    """Asks again while a controller has not answered yet that its goals are cancelled, as a client does."""
    answers: list[httpx.Response] = []

    async def settled() -> bool:
        answers.append(await rig.post(path, body))
        return answers[-1].status_code != 503 or code(answers[-1]) != ArmRefusal.CANCEL_OWED

    await until_true(settled, timeout_s=LONG_S)
    return answers[-1]


async def move(rig: Rig, to: tuple[float, ...], seconds: float, *, epoch: int = 0) -> ArmReply:
    answer = await post_settled(rig, "/arm/trajectory", trajectory(to, seconds, epoch=epoch))
    return ArmReply.model_validate_json(answer.content)


def code(answer: httpx.Response) -> str:
    return str(answer.json()["code"])


class ArmBehaviour:
    """The suite. Each test begins with the arm at home."""

    async def test_it_tells_its_joints_what_they_may_do_and_where_they_are(self, rig: Rig) -> None:
        state = await arm_state(rig.client)
        assert (state.fitted, state.model, state.under_way) == (True, "so101", ())
        assert tuple(joint.name for joint in state.joints) == SO101.names
        assert near(await positions(rig.client), SO101.home_rad)
        assert state.age_s is not None
        assert state.age_s < 0.5

    async def test_it_follows_a_trajectory_and_folds_again(self, rig: Rig) -> None:
        assert await move(rig, REACHED, 3.0) == ArmReply(end=ArmEnd.COMPLETED)
        assert near(await stands(rig.client), REACHED)
        home = await rig.post("/arm/home", {"speed_share": 1.0, "epoch": 0})
        assert ArmReply.model_validate_json(home.content).end is ArmEnd.COMPLETED
        assert near(await stands(rig.client), SO101.home_rad)

    async def test_what_a_joint_may_not_do_is_refused_and_nothing_moves(self, rig: Rig) -> None:
        too_far = await rig.post("/arm/trajectory", trajectory((0.0, -1.9, 1.0, 0.0, 0.0), 5.0))
        assert (too_far.status_code, code(too_far)) == (422, ArmRefusal.OUT_OF_LIMITS)
        too_fast = await rig.post("/arm/trajectory", trajectory(REACHED, 0.5))
        assert (too_fast.status_code, code(too_fast)) == (422, ArmRefusal.JOINT_TOO_FAST)
        assert "rad/s" in too_fast.json()["detail"]
        assert near(await stands(rig.client), SO101.home_rad)

    async def test_the_emergency_stop_ends_it_and_nothing_resumes_after_the_reset(self, rig: Rig) -> None:
        moving = asyncio.create_task(rig.post("/arm/trajectory", trajectory(REACHED, 3.0)))
        await starts_moving(rig.client)
        assert (await rig.post("/emergency-stop")).json()["state"]["latched"]
        assert ArmReply.model_validate_json((await moving).content).end is ArmEnd.STOPPED
        stood = await stands(rig.client)
        assert not near(stood, REACHED)
        refused = await rig.post("/arm/trajectory", trajectory(REACHED, 3.0, epoch=1))
        assert (refused.status_code, code(refused)) == (409, Refusal.STOPPED)
        await rig.post("/emergency-stop/reset")
        late = await rig.post("/arm/trajectory", trajectory(REACHED, 3.0, epoch=0))
        assert (late.status_code, code(late)) == (409, Refusal.OLD_EPOCH)
        assert near(await stands(rig.client), stood)
        again = await post_settled(rig, "/arm/home", {"epoch": 1})
        assert ArmReply.model_validate_json(again.content).end is ArmEnd.COMPLETED

    async def test_a_halt_ends_it_without_latching(self, rig: Rig) -> None:
        moving = asyncio.create_task(rig.post("/arm/trajectory", trajectory(REACHED, 3.0)))
        await starts_moving(rig.client)
        await rig.post("/halt")
        assert ArmReply.model_validate_json((await moving).content).end is ArmEnd.CANCELED
        assert not near(await stands(rig.client), REACHED)

    async def test_its_own_stop_ends_it_and_leaves_the_epoch(self, rig: Rig) -> None:
        moving = asyncio.create_task(rig.post("/arm/trajectory", trajectory(REACHED, 3.0)))
        await starts_moving(rig.client)
        assert (await rig.post("/arm/stop")).json() == {"ended": [ArmPart.ARM]}
        assert ArmReply.model_validate_json((await moving).content).end is ArmEnd.CANCELED
        assert (await rig.client.get("/emergency-stop")).json()["epoch"] == 0
        assert (await rig.post("/arm/stop")).json() == {"ended": []}

    async def test_one_motion_at_a_time_and_the_jaw_has_its_own(self, rig: Rig) -> None:
        moving = asyncio.create_task(rig.post("/arm/trajectory", trajectory(REACHED, 3.0)))
        await starts_moving(rig.client)
        second = await rig.post("/arm/home", {"epoch": 0})
        assert (second.status_code, code(second)) == (409, ArmRefusal.ARM_MOTION_UNDER_WAY)
        opened = GripperReply.model_validate_json(
            (await rig.post("/arm/gripper", {"opening": 0.8, "epoch": 0})).content
        )
        assert opened.end is ArmEnd.COMPLETED
        assert ArmReply.model_validate_json((await moving).content).end is ArmEnd.COMPLETED

    async def test_the_jaw_opens_and_closes(self, rig: Rig) -> None:
        for opening in (0.9, 0.2):
            answer = await rig.post("/arm/gripper", {"opening": opening, "epoch": 0})
            reply = GripperReply.model_validate_json(answer.content)
            assert reply.end is ArmEnd.COMPLETED, reply
            assert reply.opening is not None
            assert math.isclose(reply.opening, opening, abs_tol=0.1)
