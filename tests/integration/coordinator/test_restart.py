"""The coordinator with its own database: what a restart leaves of missions, requests and the timeline."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path

import httpx
import httpx2
import pytest
from mcp import Client
from mcp.client.streamable_http import streamable_http_client
from uvicorn.lifespan.on import LifespanOn
from websockets.asyncio.client import connect

from contracts.mission import EndCause, Mission, MissionEvent, Outcome
from contracts.vision import ParsedTarget, ParsedTask
from coordinator.adapters.exploration_journal import ExplorationJournal
from coordinator.app import create_app
from coordinator.core import recording
from coordinator.settings import Settings
from mesh.clock import SystemClock
from support.coordinator_world import FakeInference, FakeMemory, FakeRobot, World
from support.described import described_bus
from support.served import served
from support.waiting import until_true

TWO = ParsedTask(
    targets=(
        ParsedTarget(said="find the bottle", yolo_class="bottle", description="bottle", parser="rules"),
        ParsedTarget(said="the cup", yolo_class="cup", description="cup", parser="rules"),
    ),
)
COMMAND = {"command": "find the bottle, then the cup"}
KEY = {"Idempotency-Key": "once"}


@dataclass
class Life:
    client: httpx.AsyncClient
    url: str
    world: World


@asynccontextmanager
async def one_life(path: Path) -> AsyncIterator[Life]:
    clock, bus = SystemClock(), described_bus()
    world = World(clock, bus)  # type: ignore[arg-type]
    inference = FakeInference(world)
    inference.parse = TWO
    settings = Settings.model_validate({"database_url": f"sqlite:///{path}"})
    app = create_app(settings, bus=bus, robot=FakeRobot(world), inference=inference, memory=FakeMemory())
    async with served(app) as url, httpx.AsyncClient(base_url=url, trust_env=False) as client:
        running = asyncio.create_task(world.run())
        try:
            await until_true(lambda: ready(client))
            yield Life(client, url, world)
        finally:
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)


async def ready(client: httpx.AsyncClient) -> bool:
    return (await client.get("/ready")).is_success


async def listed(life: Life) -> list[Mission]:
    return [Mission.model_validate(one) for one in (await life.client.get("/missions")).json()]


async def test_after_a_restart_nothing_resumes_and_everything_is_still_told(tmp_path: Path) -> None:
    path = tmp_path / "coordinator.db"
    async with one_life(path) as life:
        answer = await life.client.post("/missions", json=COMMAND, headers=KEY)
        assert answer.status_code == 201
        first = Mission.model_validate_json(answer.content)
        async with connect(f"{life.url.replace('http', 'ws')}/events?after=-1", proxy=None) as ws:
            seen = MissionEvent.model_validate_json(await asyncio.wait_for(ws.recv(), 30.0))
    async with one_life(path) as life:
        assert (await life.client.get("/state")).json()["state"] == "IDLE"
        missions = await listed(life)
        assert [one.outcome for one in missions] == [Outcome.INTERRUPTED, Outcome.INTERRUPTED]
        assert {one.request_id for one in missions} == {first.request_id}
        again = Mission.model_validate_json(
            (await life.client.post("/missions", json=COMMAND, headers=KEY)).content
        )  # fmt: skip
        assert (again.id, again.outcome) == (first.id, Outcome.INTERRUPTED)
        assert (await life.client.get("/state")).json()["state"] == "IDLE"
        missed: list[MissionEvent] = []
        async with connect(f"{life.url.replace('http', 'ws')}/events?after={seen.id}", proxy=None) as ws:
            while sum(event.data.outcome is Outcome.INTERRUPTED for event in missed) < 2:
                missed.append(MissionEvent.model_validate_json(await asyncio.wait_for(ws.recv(), 30.0)))
        assert [event.id for event in missed] == list(range(seen.id + 1, seen.id + 1 + len(missed)))
        written = (await life.client.get(f"/missions/{first.id}/recording")).text.splitlines()
        assert all(one.same for one in recording.replay(recording.read(written)))


async def test_an_exploration_that_a_restart_ends_is_told_and_moves_nothing_any_more(tmp_path: Path) -> None:
    path = tmp_path / "coordinator.db"
    async with one_life(path) as life:
        life.world.map_id, life.world.mapped_m = "flat", 1.5
        assert (await life.client.post("/actions", json={"action": "explore"})).status_code == 201
        await until_true(lambda: something_was_done(life))
    async with one_life(path) as life:
        assert [one.outcome for one in await listed(life)] == [Outcome.INTERRUPTED]
        state = (await life.client.get("/state")).json()
        assert (state["state"], state["exploration"], life.world.moves) == ("IDLE", None, [])
    journal = ExplorationJournal(tmp_path / "exploration.db", busy_timeout_s=1.0)
    assert (await journal.read("flat")).actions_done >= 1
    await journal.aclose()


@pytest.mark.parametrize("mode", ["legacy", "auto"])
async def test_a_mission_of_an_mcp_call_that_a_restart_cuts_off_is_interrupted_and_cancelled_by_nobody(
    tmp_path: Path, mode: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """uvicorn cuts its requests off, and only then tells the service that it ends."""
    shutdown = LifespanOn.shutdown

    async def later(lifespan: LifespanOn) -> None:
        for _ in range(100):  # the loop goes round: what was cut off has ended
            await asyncio.sleep(0)
        await shutdown(lifespan)

    monkeypatch.setattr(LifespanOn, "shutdown", later)
    path = tmp_path / "coordinator.db"
    async with httpx2.AsyncClient(timeout=60.0, trust_env=False) as http:
        async with one_life(path) as life:
            client = Client(streamable_http_client(f"{life.url}/mcp", http_client=http), mode=mode, cache=None)
            calling = asyncio.create_task(drive(client))
            await until_true(lambda: is_under_way(life))
        await asyncio.wait({calling}, timeout=20.0)
        calling.cancel()
        await asyncio.gather(calling, return_exceptions=True)
    async with one_life(path) as life:
        (mission,) = await listed(life)
        assert mission.report is not None
        assert (mission.outcome, mission.report.ended_by) == (Outcome.INTERRUPTED, EndCause.RESTART), mission.reason


async def drive(client: Client) -> None:
    async with client:
        await client.list_tools()
        await client.call_tool("drive", {"distance_m": 2.0})


async def is_under_way(life: Life) -> bool:
    return [one.outcome for one in await listed(life)] == [None]


async def something_was_done(life: Life) -> bool:
    exploration = (await life.client.get("/state")).json()["exploration"]
    return exploration is not None and exploration["actions"] >= 1
