"""How docking is given up while Nav2 or the base is at it."""

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from contracts.geometry import Pose2D
from contracts.robot import GoalStatus, NavigationState
from contracts.topics import ROBOT_NAVIGATION, ROBOT_STATE
from robot_bridge.settings import Settings
from support.toy_robot import DOCK, ToyRobot
from support.waiting import until

from .conftest import Served, serving
from .test_connections import beating, client, lease, session


@pytest.fixture
async def away(tmp_path: Path) -> AsyncIterator[Served]:
    """It knows where its dock is, and stands elsewhere."""
    settings = Settings(state_dir=tmp_path, dock_pose=Pose2D(x=DOCK.x, y=DOCK.y, yaw=DOCK.yaw))
    async with serving(settings, ToyRobot(navigation="succeeds")) as served:
        await until(lambda: served.bus.of(ROBOT_STATE)[-1:] != [] and served.bus.of(ROBOT_STATE)[-1].pose is not None)
        yield served


async def test_the_emergency_stop_ends_what_the_base_does_by_itself(away: Served) -> None:
    away.toy.thinking.add("base")
    async with client(away) as http:
        docking = asyncio.create_task(http.post("/dock"))
        await until(lambda: away.toy.docking == 1)
        assert (await http.post("/velocity", json=lease())).status_code == 409
        assert (await http.post("/emergency-stop")).json()["state"]["latched"]
        reply = (await docking).json()
        assert (reply["completed"], reply["reason"], away.toy.docking) == (False, "emergency stop", 0)
        await http.post("/emergency-stop/reset")
        assert (await http.post("/velocity", json=lease() | {"epoch": 1})).json()["accepted"]


async def test_docking_ends_with_its_session(away: Served) -> None:
    away.toy.thinking.add("base")
    async with client(away) as http, session(away) as (socket, session_id), beating(socket):
        docking = asyncio.create_task(http.post(f"/dock?session_id={session_id}"))
        await until(lambda: away.toy.docking == 1)
        socket.transport.abort()
        assert (await docking).json()["reason"] == "the session ended"
        assert away.toy.docking == 0


async def test_docking_ends_at_its_time_limit(tmp_path: Path) -> None:
    toy = ToyRobot(thinking={"base"})
    toy.put_on_dock()
    async with serving(Settings(state_dir=tmp_path, dock_timeout_s=0.2), toy) as served, client(served) as http:
        assert (await http.post("/undock")).json()["reason"] == "timeout"
        assert served.toy.docking == 0


async def test_a_client_that_leaves_while_nav2_thinks_leaves_no_goal_under_way(away: Served) -> None:
    away.toy.thinking.add("nav2")
    async with client(away) as http:
        docking = asyncio.create_task(http.post("/dock"))
        await until(lambda: len(away.toy.goals) == 1)
        docking.cancel()
        await until(lambda: away.bus.of(ROBOT_NAVIGATION)[-1].status is GoalStatus.CANCELED)
        await until(lambda: away.bus.of(ROBOT_STATE)[-1].navigation is NavigationState.IDLE)
        turned = await http.post("/rotate", json={"angle_rad": 0.2, "epoch": 0})
        assert turned.json()["completed"]
