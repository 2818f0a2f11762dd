"""What ends with a connection: sessions, teleoperation, closed-loop motions, streams."""

import asyncio
import contextlib
import json
from collections.abc import AsyncIterator
from pathlib import Path

import httpx
import websockets
from websockets.asyncio.client import ClientConnection

from contracts.causes import GoalCause, Refusal
from contracts.motion import MotionEnd
from contracts.robot import GoalStatus
from contracts.topics import ROBOT_NAVIGATION, ROBOT_STATE
from robot_bridge.settings import Settings
from support.bridge_behaviour import INSIDE
from support.toy_robot import ToyRobot
from support.waiting import until

from .conftest import Served, serving


@contextlib.asynccontextmanager
async def session(served: Served) -> AsyncIterator[tuple[ClientConnection, str]]:
    async with websockets.connect(f"ws://{served.address}/session?source=test") as socket:
        yield socket, json.loads(await socket.recv())["session_id"]


@contextlib.asynccontextmanager
async def beating(socket: ClientConnection) -> AsyncIterator[None]:
    async def beat() -> None:
        while True:
            await socket.send("beat")
            await asyncio.sleep(0.05)

    task = asyncio.create_task(beat())
    try:
        yield
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)


def client(served: Served) -> httpx.AsyncClient:
    return httpx.AsyncClient(base_url=f"http://{served.address}", timeout=45, trust_env=False)


def lease(session_id: str | None = None) -> dict[str, object]:
    return {
        "twist": {"linear_x": 0.2},
        "source": "test",
        "epoch": 0,
        "duration_s": 2.0,
        "session_id": session_id,
    }


async def rests_before_its_lease_is_over(served: Served) -> None:
    """In ticks of the wheels, not by the clock: a lease of 2 s is 40 of them."""
    before = len(served.toy.velocities)
    await until(lambda: served.toy.at_rest)
    assert sum(velocity != (0.0, 0.0) for velocity in served.toy.velocities[before:]) < 35


async def test_what_a_session_asked_for_ends_with_its_connection(served: Served) -> None:
    async with client(served) as http, session(served) as (socket, session_id), beating(socket):
        assert (await http.post("/velocity", json=lease(session_id))).json()["accepted"]
        await until(lambda: served.toy.has_driven)
        socket.transport.abort()  # as a killed process leaves it
        await rests_before_its_lease_is_over(served)
        assert (await http.post("/velocity", json=lease(session_id))).status_code == 409


async def test_a_goal_ends_with_its_session_and_nav2_moves_nothing_any_more(served: Served) -> None:
    async with client(served) as http, session(served) as (socket, session_id), beating(socket):
        body = {"candidates": [{"pose": INSIDE}], "epoch": 0, "session_id": session_id, "clear_costmaps": False}
        assert (await http.post("/navigation/goals", json=body)).json()["status"] == "EXECUTING"
        await until(lambda: served.toy.has_driven)
        socket.transport.abort()
        await rests_before_its_lease_is_over(served)
        await until(lambda: served.bus.of(ROBOT_NAVIGATION)[-1].status is GoalStatus.CANCELED)
        assert served.bus.of(ROBOT_NAVIGATION)[-1].cause is GoalCause.SESSION_ENDED


async def test_a_session_that_falls_silent_ends_though_its_connection_stands(served: Served) -> None:
    async with client(served) as http, session(served) as (socket, session_id):
        async with beating(socket):
            assert (await http.post("/velocity", json=lease(session_id))).json()["accepted"]
            await until(lambda: served.toy.has_driven)
        await rests_before_its_lease_is_over(served)
        assert (await http.post("/velocity", json=lease(session_id))).status_code == 409
        await asyncio.wait_for(socket.wait_closed(), 45.0)


async def test_a_turn_ends_with_its_session(served: Served) -> None:
    async with client(served) as http, session(served) as (socket, session_id), beating(socket):
        body = {"angle_rad": 12.0, "epoch": 0, "session_id": session_id, "timeout_s": 30}
        turning = asyncio.create_task(http.post("/rotate", json=body))
        await until(lambda: served.toy.angular_z > 0.5)
        await socket.close()
        assert (await turning).json()["end"] == MotionEnd.SESSION_ENDED
        await until(lambda: served.toy.at_rest)


async def test_a_turn_ends_when_its_client_goes_away(served: Served) -> None:
    async with client(served) as http:
        turning = asyncio.create_task(http.post("/rotate", json={"angle_rad": 12.0, "epoch": 0}))
        await until(lambda: served.toy.angular_z > 0.5)
        turning.cancel()
        await until(lambda: served.toy.at_rest)


async def test_ending_a_motion_tells_how_far_it_had_come_and_ends_no_goal(served: Served) -> None:
    async with client(served) as http:
        turning = asyncio.create_task(http.post("/rotate", json={"angle_rad": 12.0, "epoch": 0, "timeout_s": 60}))
        await until(lambda: served.toy.yaw > 0.1)
        ended = (await http.delete("/motion")).json()
        told = (await turning).json()
        assert (ended["turned_rad"], ended["driven_m"]) == (told["turned_rad"], None)
        assert told["turned_rad"] > 0.0
        goal = {"candidates": [{"pose": INSIDE}], "epoch": 0, "clear_costmaps": False}
        goal_id = (await http.post("/navigation/goals", json=goal)).json()["id"]
        ended = (await http.delete("/motion")).json()
        assert ended == {"turned_rad": None, "driven_m": None}
        assert (await http.get(f"/navigation/goals/{goal_id}")).json()["status"] == GoalStatus.EXECUTING


async def test_teleoperation_answers_every_request_and_its_lease_ends_with_the_connection(served: Served) -> None:
    async with websockets.connect(f"ws://{served.address}/velocity") as socket:
        await socket.send("nonsense")
        assert json.loads(await socket.recv())["refusal"] == Refusal.MALFORMED
        await socket.send(json.dumps(lease()))
        assert json.loads(await socket.recv())["accepted"]
        await until(lambda: served.toy.has_driven)
        socket.transport.abort()
        await rests_before_its_lease_is_over(served)


async def test_teleoperation_faster_than_the_wheels_tick_drives_by_its_newest_request(served: Served) -> None:
    async with websockets.connect(f"ws://{served.address}/velocity") as socket:
        for _ in range(60):
            await socket.send(json.dumps(lease()))
        await socket.send(json.dumps(lease() | {"twist": {"linear_x": 0.0}}))
        replies = [json.loads(await asyncio.wait_for(socket.recv(), 30.0)) for _ in range(61)]
        assert all(reply["accepted"] for reply in replies)
        assert replies[-1]["sent"]["linear_x"] == 0.0
        assert len(served.toy.velocities) < 40  # the replies did not take a tick each


async def test_gains_can_be_changed_while_it_turns(served: Served) -> None:
    async with client(served) as http:
        turning = asyncio.create_task(http.post("/rotate", json={"angle_rad": 12.0, "epoch": 0, "timeout_s": 60}))
        await until(lambda: served.toy.angular_z > 0.9)
        before = (await http.get("/motion/gains")).json()
        slow = before | {"heading_kp": 0.0, "heading_kd": 0.0, "turn_rad_s_min": 0.3}
        assert (await http.put("/motion/gains", json=slow)).json() == slow
        await until(lambda: 0.0 < served.toy.angular_z < 0.31)
        assert (await http.put("/motion/gains", json=slow | {"heading_kp": -1.0})).status_code == 422
        assert (await http.get("/motion/gains")).json() == slow
        await http.delete("/motion")
        assert (await turning).json()["end"] == MotionEnd.CANCELED


async def test_nobody_drives_under_a_name_of_the_bridges_own(served: Served) -> None:
    async with client(served) as http:
        reply = (await http.post("/velocity", json=lease() | {"source": "cmd_vel_nav"})).json()
        assert (reply["accepted"], reply["refusal"]) == (False, Refusal.RESERVED)
        metrics = (await http.get("/metrics")).text
        assert 'robot_bridge_velocity_refused_total{reason="reserved"}' in metrics


async def test_a_stop_reaches_teleoperation_as_a_refusal(served: Served) -> None:
    async with client(served) as http, websockets.connect(f"ws://{served.address}/velocity") as socket:
        await http.post("/emergency-stop")
        await socket.send(json.dumps(lease() | {"epoch": 1}))
        reply = json.loads(await socket.recv())
        assert (reply["accepted"], reply["refusal"]) == (False, Refusal.STOPPED)


async def test_the_stream_shows_newer_and_newer_frames(served: Served) -> None:
    stamps: list[float] = []
    async with client(served) as http, http.stream("GET", "/camera/stream") as response:
        assert response.headers["content-type"].startswith("multipart/x-mixed-replace")
        assert response.headers["x-accel-buffering"] == "no"
        async for line in response.aiter_lines():
            if line.startswith("X-Stamp-S: "):
                stamps.append(float(line.removeprefix("X-Stamp-S: ")))
            if len(stamps) == 3:
                break
    assert stamps == sorted(set(stamps))


async def test_a_latched_stop_is_still_latched_in_the_next_life(tmp_path: Path) -> None:
    settings = Settings(state_dir=tmp_path)
    async with serving(settings, ToyRobot()) as first, client(first) as http:
        await http.post("/emergency-stop", json={"reason": "smoke", "by": "a person"})
    async with serving(settings, ToyRobot()) as second, client(second) as http:
        state = (await http.get("/emergency-stop")).json()
        assert (state["latched"], state["epoch"], state["reason"]) == (True, 1, "smoke")
        assert (await http.post("/velocity", json=lease() | {"epoch": 1})).status_code == 409
        await until(lambda: second.toy.base_stop is True)
        await http.post("/emergency-stop/reset")
        assert (await http.post("/velocity", json=lease() | {"epoch": 1})).json()["accepted"]


async def test_with_the_bus_away_the_robot_still_obeys_and_stops(served: Served) -> None:
    served.bus.connected = False
    async with client(served) as http:
        assert (await http.post("/velocity", json=lease())).json()["accepted"]
        await until(lambda: served.toy.has_driven)
        assert (await http.post("/emergency-stop")).json()["state"]["latched"]
        await until(lambda: served.toy.at_rest)
        ready = await http.get("/ready")
        assert ready.status_code == 503
        assert [d["name"] for d in ready.json()["dependencies"] if d["state"] != "ready"] == ["redis"]
    assert served.bus.of(ROBOT_STATE) is not None
