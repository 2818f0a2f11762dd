"""The real port `Robot` against the real robot_bridge app (over its fake base): session, motion, cancelling."""

import asyncio
import contextlib
from collections.abc import AsyncIterator
from dataclasses import dataclass
from pathlib import Path

import httpx
import pytest

from contracts.causes import GoalCause
from contracts.geometry import Pose2D, Twist2D
from contracts.robot import CandidatePose, GoalRequest, GoalStatus
from coordinator.adapters.robot_bridge import RobotBridgeClient
from coordinator.settings import Settings as CoordinatorSettings
from geometry.grids import decode
from mesh.errors import UnavailableError, UpstreamError
from robot_bridge.app import create_app
from robot_bridge.settings import Settings
from support.bus import MemoryBus
from support.fake_robot import FakeRobot
from support.served import served
from support.toy_robot import ToyRobot
from support.waiting import until, until_true

INSIDE = Pose2D(x=4.0, y=3.0, yaw=0.5)


@dataclass
class Rig:
    robot: RobotBridgeClient
    toy: ToyRobot
    session: "asyncio.Task[None]"


@pytest.fixture
async def rig(tmp_path: Path) -> AsyncIterator[Rig]:
    toy = ToyRobot()
    settings = Settings(state_dir=tmp_path, session_timeout_s=10.0)  # a pause of the whole test run is no silence
    app = create_app(settings, bus=MemoryBus(), robot=FakeRobot(toy))
    async with served(app) as url, httpx.AsyncClient(base_url=url) as client:

        async def ready() -> bool:
            return (await client.get("/ready")).status_code == 200

        await until_true(ready, timeout_s=60.0)
        robot = RobotBridgeClient(
            CoordinatorSettings(robot_bridge_url=url, call_timeout_s=30.0, heartbeat_s=0.05, reconnect_s=0.1)
        )
        session = asyncio.create_task(robot.hold_session())
        await until(lambda: robot.session_held)
        yield Rig(robot, toy, session)
        session.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await session
        await robot.aclose()


def to(pose: Pose2D) -> GoalRequest:
    return GoalRequest(candidates=(CandidatePose(pose=pose),), epoch=0)


async def test_it_turns_and_drives(rig: Rig) -> None:
    turned = await rig.robot.rotate(0.3, speed_rad_s=1.0, timeout_s=30.0, epoch=0)
    assert turned.end.completed
    driven = await rig.robot.drive(0.1, speed_m_s=0.2, timeout_s=30.0, epoch=0)
    assert driven.driven_m == pytest.approx(0.1, abs=0.03)


async def test_cancelling_the_call_ends_the_motion(rig: Rig) -> None:
    turning = asyncio.create_task(rig.robot.rotate(6.0, speed_rad_s=0.5, timeout_s=20.0, epoch=0))
    await until(lambda: not rig.toy.at_rest)
    turning.cancel()
    await until(lambda: rig.toy.at_rest)


async def test_when_the_session_is_gone_what_moved_stops(rig: Rig) -> None:
    goal = await rig.robot.navigate(to(INSIDE))
    assert goal.status is GoalStatus.EXECUTING
    await until(lambda: not rig.toy.at_rest)
    rig.session.cancel()
    await until(lambda: rig.toy.at_rest)
    assert (await rig.robot.goal(goal.id)).status is GoalStatus.CANCELED


async def test_without_a_session_nothing_is_asked_for(rig: Rig) -> None:
    rig.session.cancel()
    await until(lambda: not rig.robot.session_held)
    with pytest.raises(UnavailableError):
        await rig.robot.rotate(0.3, speed_rad_s=1.0, timeout_s=30.0, epoch=0)


async def test_a_goal_is_cancelled(rig: Rig) -> None:
    goal = await rig.robot.navigate(to(INSIDE))
    assert (await rig.robot.cancel_goal(goal.id)).status is GoalStatus.CANCELED


async def test_another_epoch_is_refused(rig: Rig) -> None:
    with pytest.raises(UpstreamError) as refused:
        await rig.robot.velocity(Twist2D(angular_z=0.2), duration_s=0.3, epoch=7)
    assert refused.value.upstream_status == 409


async def test_a_lease_moves_it(rig: Rig) -> None:
    reply = await rig.robot.velocity(Twist2D(angular_z=0.3), duration_s=0.5, epoch=0)
    assert reply.accepted


async def test_the_map_is_a_grid_and_a_pose_outside_it_is_unreachable(rig: Rig) -> None:
    grid = decode(await rig.robot.map())
    assert grid.free.any()
    outside = await rig.robot.navigate(to(Pose2D(x=900.0, y=0.0, yaw=0.0)))
    assert (outside.status, outside.cause) == (GoalStatus.ABORTED, GoalCause.UNREACHABLE)


async def test_celebrating_twice_is_no_failure(rig: Rig) -> None:
    await rig.robot.celebrate()
    await rig.robot.celebrate()


async def test_ending_a_motion_that_is_not_there_is_no_failure(rig: Rig) -> None:
    await rig.robot.end_motion()
    assert (await rig.robot.dependency()).ok
