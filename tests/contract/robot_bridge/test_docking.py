"""How docking is given up while Nav2 or the base is at it."""

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path

import httpx
import pytest

from contracts.motion import BaseEnd, MotionEnd
from contracts.robot import GoalStatus, NavigationState
from contracts.topics import ROBOT_NAVIGATION, ROBOT_STATE
from robot_bridge.settings import Settings
from support.toy_robot import DOCK, ToyRobot
from support.waiting import until

from .conftest import Served, serving
from .test_connections import beating, client, lease, session


@pytest.fixture
async def in_front(tmp_path: Path) -> AsyncIterator[Served]:
    """It stands in front of its dock."""
    settings = Settings(state_dir=tmp_path, dock_pose=DOCK, session_timeout_s=10.0)
    async with serving(settings, ToyRobot(navigation="succeeds", dock_visible=True)) as served:
        await until(lambda: served.bus.of(ROBOT_STATE)[-1:] != [] and served.bus.of(ROBOT_STATE)[-1].pose is not None)
        yield served


async def keep_asking_to_dock(http: httpx.AsyncClient) -> None:
    """A machine that stalled for some seconds has heard nothing of Nav2 lately, and refuses once."""
    while True:
        await http.post("/dock")


async def test_the_emergency_stop_ends_what_the_base_does_by_itself(in_front: Served) -> None:
    in_front.toy.thinking.add("base")
    async with client(in_front) as http:
        docking = asyncio.create_task(http.post("/dock"))
        await until(lambda: in_front.toy.docking == 1)
        assert (await http.post("/velocity", json=lease())).status_code == 409
        assert (await http.post("/emergency-stop")).json()["state"]["latched"]
        reply = (await docking).json()
        assert (reply["end"], in_front.toy.docking) == (BaseEnd.STOPPED, 0)
        await http.post("/emergency-stop/reset")
        assert (await http.post("/velocity", json=lease() | {"epoch": 1})).json()["accepted"]


async def test_docking_ends_with_its_session(in_front: Served) -> None:
    in_front.toy.thinking.add("base")
    async with client(in_front) as http, session(in_front) as (socket, session_id), beating(socket):
        docking = asyncio.create_task(http.post(f"/dock?session_id={session_id}"))
        await until(lambda: in_front.toy.docking == 1)
        socket.transport.abort()
        assert (await docking).json()["end"] == BaseEnd.SESSION_ENDED
        assert in_front.toy.docking == 0


async def test_docking_ends_at_its_time_limit(tmp_path: Path) -> None:
    toy = ToyRobot(thinking={"base"})
    toy.put_on_dock()
    async with serving(Settings(state_dir=tmp_path, dock_timeout_s=0.2), toy) as served, client(served) as http:
        assert (await http.post("/undock")).json()["end"] == BaseEnd.TIMED_OUT
        assert served.toy.docking == 0


async def test_a_client_that_leaves_while_nav2_thinks_leaves_no_goal_under_way(in_front: Served) -> None:
    in_front.toy.thinking.add("nav2")
    in_front.toy.dock_visible = False  # so it is Nav2 that has to bring it there
    await until(lambda: in_front.bus.of(ROBOT_STATE)[-1].dock_visible is False)
    async with client(in_front) as http:
        docking = asyncio.create_task(keep_asking_to_dock(http))
        await until(lambda: len(in_front.toy.goals) == 1)
        docking.cancel()
        await until(lambda: in_front.bus.of(ROBOT_NAVIGATION)[-1].status is GoalStatus.CANCELED)
        await until(lambda: in_front.bus.of(ROBOT_STATE)[-1].navigation is NavigationState.IDLE)
        turned = await http.post("/rotate", json={"angle_rad": 0.2, "epoch": 0})
        assert turned.json()["end"] == MotionEnd.COMPLETED
