"""Databases as the release before left them (`tests/data/upgrade`) are opened, migrated and served by today's services.

Each file is SQLite's dump of what the services of that commit wrote through their own code: the coordinator a mission
that found its bottle and one that still ran, memory a bottle seen twice, a chair, and a cup of unknown place. Of the
history's recordings and pictures one each is left, for size. A new release adds a file and keeps the old ones.
"""

import json
import sqlite3
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, closing
from pathlib import Path

import httpx
import pytest
from asgi_lifespan import LifespanManager
from fastapi import FastAPI

from contracts.memory import RecallRequest, RememberedObject, View
from contracts.mission import Mission, MissionEvent, Outcome
from contracts.vision import Target
from coordinator import app as coordinator
from coordinator.settings import Settings as CoordinatorSettings
from memory import app as memory
from memory.settings import Settings as MemorySettings
from support.coordinator_world import FakeInference, FakeMemory, FakeRobot, World
from support.described import described_bus
from support.fake_clock import FakeClock
from support.source import ROOT

RELEASES = sorted(one.name for one in (ROOT / "tests/data/upgrade").iterdir())


def database_of(release: str, service: str, folder: Path) -> Path:
    path = folder / f"{service}.db"
    with closing(sqlite3.connect(path)) as connection:
        connection.executescript((ROOT / f"tests/data/upgrade/{release}/{service}.sql").read_text(encoding="utf-8"))
        connection.execute("PRAGMA journal_mode = WAL")
    return path


@asynccontextmanager
async def client_of(app: FastAPI) -> AsyncIterator[httpx.AsyncClient]:
    async with LifespanManager(app) as manager:
        transport = httpx.ASGITransport(manager.app)
        async with httpx.AsyncClient(transport=transport, base_url="http://service", timeout=30.0) as client:
            yield client


def memory_over(path: Path) -> FastAPI:
    return memory.create_app(MemorySettings(database_url=f"sqlite:///{path}", robot_bridge_url=""), bus=described_bus())


def coordinator_over(path: Path) -> FastAPI:
    clock, bus = FakeClock(), described_bus()
    world = World(clock, bus)
    return coordinator.create_app(
        CoordinatorSettings.model_validate({"database_url": f"sqlite:///{path}", "flush_s": 0.01}),
        bus=bus, robot=FakeRobot(world), inference=FakeInference(world), memory=FakeMemory(), clock=clock,
    )  # fmt: skip


@pytest.mark.parametrize("release", RELEASES)
async def test_memory_serves_what_the_release_before_remembered(release: str, tmp_path: Path) -> None:
    async with client_of(memory_over(database_of(release, "memory", tmp_path))) as client:
        things = [RememberedObject.model_validate(one) for one in (await client.get("/objects")).json()]
        assert {(one.label, one.colour, one.times_seen, one.position.x) for one in things} == {
            ("bottle", "red", 2, 2.0),
            ("chair", None, 1, 5.0),
        }
        views = [View.model_validate(one) for one in (await client.get("/views")).json()]
        assert {(one.label, one.confidence, one.count) for one in views} == {
            ("bottle", 0.9, 2),
            ("chair", 0.7, 1),
            ("cup", 0.6, 1),
        }
        request = RecallRequest(target=Target(label="bottle", description="red bottle"))
        recalled = (await client.post("/recall", json=request.model_dump(mode="json"))).json()
        assert [one["view"]["label"] for one in recalled["views"]] == ["bottle"]
        assert (await client.get("/statistics")).json()["views"] == 3
        again = (await client.get("/backup")).content
        assert (await client.post("/restore", content=again, params={"dry_run": True})).is_success


@pytest.mark.parametrize("release", RELEASES)
async def test_the_coordinator_serves_the_history_of_the_release_before(release: str, tmp_path: Path) -> None:
    async with client_of(coordinator_over(database_of(release, "coordinator", tmp_path))) as client:
        missions = [Mission.model_validate(one) for one in (await client.get("/missions")).json()]
        assert [(one.command, one.outcome) for one in missions] == [
            ("find the blue cup", Outcome.INTERRUPTED),
            ("find the red bottle", Outcome.FOUND),
        ]
        ran, found = missions
        assert found.votes
        assert found.report is not None
        events = [MissionEvent.model_validate(one) for one in (await client.get(f"/missions/{found.id}/events")).json()]
        assert Outcome.FOUND in {one.data.outcome for one in events}
        assert (await client.get(f"/missions/{found.id}/pictures/0")).content.startswith(b"\xff\xd8")
        lines = (await client.get(f"/missions/{ran.id}/recording")).raise_for_status().text.splitlines()
        assert len(lines) > 1
        assert all(isinstance(json.loads(line), dict) for line in lines)
        command, key = {"command": "find the red bottle"}, {"Idempotency-Key": "once"}
        answer = await client.post("/missions", json=command, headers=key)
        assert answer.json()["id"] == found.id  # the same request as then
        again = (await client.get("/backup")).content
        assert (await client.post("/restore", content=again, params={"dry_run": True})).is_success


@pytest.mark.parametrize("release", RELEASES)
@pytest.mark.parametrize("service", ["memory", "coordinator"])
async def test_a_back_up_of_the_release_before_can_be_restored(release: str, service: str, tmp_path: Path) -> None:
    (tmp_path / "old").mkdir()
    old = database_of(release, service, tmp_path / "old")
    with closing(sqlite3.connect(old)) as connection:
        connection.execute("PRAGMA journal_mode = DELETE")
    app = {"memory": memory_over, "coordinator": coordinator_over}[service](tmp_path / f"{service}.db")
    async with client_of(app) as client:
        answer = await client.post("/restore", content=old.read_bytes())
        assert answer.is_success, answer.text
        rows = answer.json()["rows"]
    assert (rows.get("things"), rows.get("missions")) == {"memory": (2, None), "coordinator": (None, 2)}[service]
