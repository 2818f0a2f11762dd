"""Thirty questions and commands by room, over simulated homes: real memory, which cuts the home's map and names its
rooms by what stands there, and the real coordinator. The home's own rooms and things are the truth.
"""

import asyncio
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, aclosing, asynccontextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import httpx
import pytest
from asgi_lifespan import LifespanManager

from bench.map_likeness import home_grid
from bench.speech.scoring import Rules
from contracts.asking import Answer
from contracts.coco import COCO_LABELS
from contracts.geometry import Point3D, Pose2D
from contracts.memory import Observation, ObservationBatch
from contracts.mission import CommandRefusal, Mission, MissionStatus
from contracts.rooms import RoomsReply
from coordinator.adapters.memory import MemoryClient
from coordinator.app import create_app
from coordinator.settings import Settings
from geometry.grids import OccupancyGrid, encode
from memory.app import create_app as create_memory
from memory.settings import Settings as MemorySettings
from sim.home import Home
from support.bus import MemoryBus
from support.coordinator_world import FakeInference, FakeRobot, World
from support.described import described_bus
from support.fake_clock import FakeClock
from support.fake_senses import FakeSenses
from support.memory_database import opened
from support.memory_log import MemoryLog

SEEDS = (7101, 7102, 7104, 7105)
NAMED_BY_A_PERSON = {(7101, "study"): "Anna's room", (7102, "study"): "library"}
"""The others are named by what stands there, or not at all."""
A_SECOND_BED = 7104
"""In its study."""
BESIDE_M = 0.35


@dataclass(frozen=True)
class Stands:
    label: str
    colour: str | None
    x: float
    y: float
    z: float
    room: str


@dataclass(frozen=True)
class TrueHome:
    home: Home
    grid: OccupancyGrid
    things: tuple[Stands, ...]

    def inside(self, rooms: tuple[str, ...], x: float, y: float) -> bool:
        return any(
            r.x_min_m - BESIDE_M <= x <= r.x_max_m + BESIDE_M and r.y_min_m - BESIDE_M <= y <= r.y_max_m + BESIDE_M
            for r in self.home.rooms
            if r.name in rooms
        )

    def of(self, rooms: tuple[str, ...], label: str | None = None) -> list[Stands]:
        return [one for one in self.things if one.room in rooms and label in {None, one.label}]

    def middle(self, name: str) -> tuple[float, float]:
        room = next(one for one in self.home.rooms if one.name == name)
        return (room.x_min_m + room.x_max_m) / 2, (room.y_min_m + room.y_max_m) / 2


@cache
def true_home(seed: int) -> TrueHome:
    home = Home.generate(seed)

    def stands(label: str, colour: str | None, x: float, y: float, z: float) -> Stands | None:
        room = next((r.name for r in home.rooms if r.contains(x, y)), None)
        return Stands(label, colour, x, y, z, room) if room is not None and label in COCO_LABELS else None

    found = [stands(f.kind, f.colour, f.x_m, f.y_m, 0.4) for f in home.furniture]
    found += [stands(t.kind, t.colour, t.x_m, t.y_m, t.z_m) for t in home.things]
    things = [one for one in found if one is not None]
    if seed == A_SECOND_BED:
        things.append(Stands("bed", None, *TrueHome(home, home_grid(seed), ()).middle("study"), 0.4, "study"))
    return TrueHome(home, home_grid(seed), tuple(things))


@dataclass
class Running:
    coordinator: httpx.AsyncClient
    memory: httpx.AsyncClient
    world: World
    clock: FakeClock
    true: TrueHome

    async def ask(self, question: str) -> Answer:
        answer = (await self.coordinator.post("/ask", json={"question": question})).raise_for_status()
        return Answer.model_validate_json(answer.content)

    async def planned(self, command: str) -> tuple[Mission, MissionStatus, Mission]:
        """The mission as it began, the status when it knew where to go first, and the mission once it was cancelled."""
        answer = await self.coordinator.post("/missions", json={"command": command})
        assert answer.status_code == 201, answer.text
        begun = Mission.model_validate_json(answer.content)
        for _ in range(100):
            status = MissionStatus.model_validate_json((await self.coordinator.get("/state")).content)
            if status.scan_points:
                break
            await self.clock.advance(0.1)
            await asyncio.sleep(0.02)  # the plan is made in a thread, in real time
        await self.coordinator.post(f"/missions/{begun.id}/cancel")
        over = Mission.model_validate_json((await self.coordinator.get(f"/missions/{begun.id}")).content)
        await self.clock.advance(0.5)
        return begun, status, over


@asynccontextmanager
async def running(seed: int, path: Path) -> AsyncIterator[Running]:
    true, clock = true_home(seed), FakeClock()
    async with AsyncExitStack() as stack:
        store = opened(path / "memory.db")
        remembering = create_memory(
            MemorySettings(), bus=MemoryBus(), store=store, senses=FakeSenses(ground=true.grid), clock=clock
        )
        served = await stack.enter_async_context(LifespanManager(remembering))
        to_memory = httpx.ASGITransport(app=served.app)
        memory = await stack.enter_async_context(httpx.AsyncClient(transport=to_memory, base_url="http://memory"))
        await remember(memory, true)
        await name_rooms(memory, seed)
        bus = described_bus()
        world = World(clock, bus)
        robot = FakeRobot(world)
        robot.as_map = encode(true.grid)
        client = await stack.enter_async_context(aclosing(MemoryClient(Settings(), transport=to_memory)))
        app = create_app(
            Settings(), bus=bus, robot=robot, inference=FakeInference(world), memory=client, clock=clock,
            log=MemoryLog(),
        )  # fmt: skip
        decides = await stack.enter_async_context(LifespanManager(app))
        publishing = asyncio.create_task(world.run())
        asks = await stack.enter_async_context(
            httpx.AsyncClient(transport=httpx.ASGITransport(app=decides.app), base_url="http://coordinator")
        )
        await clock.advance(0.3)
        yield Running(asks, memory, world, clock, true)
        publishing.cancel()
        await asyncio.gather(publishing, return_exceptions=True)


async def remember(memory: httpx.AsyncClient, true: TrueHome) -> None:
    """Each thing at its true place, seen from the middle of its room; twice, so that it is believed."""
    for stamp_s in (1.0, 2.0):
        seen = tuple(
            Observation(
                label=one.label, confidence=0.9, colour=one.colour, stamp_s=stamp_s + 0.001 * k,
                pose=Pose2D(x=true.middle(one.room)[0], y=true.middle(one.room)[1], yaw=0.0),
                position=Point3D(x=one.x, y=one.y, z=one.z),
            )
            for k, one in enumerate(true.things)
        )  # fmt: skip
        body = ObservationBatch(observations=seen).model_dump(mode="json")
        (await memory.post("/observations", json=body)).raise_for_status()


async def name_rooms(memory: httpx.AsyncClient, seed: int) -> None:
    true = true_home(seed)
    told = RoomsReply.model_validate_json((await memory.get("/rooms")).raise_for_status().content)
    for (home, truth), name in NAMED_BY_A_PERSON.items():
        if home == seed:
            room = next(one for one in told.rooms if true.inside((truth,), one.x, one.y))
            (await memory.put(f"/rooms/{room.id}/name", json={"name": name})).raise_for_status()


@pytest.fixture(autouse=True)
def _eyes_that_read(monkeypatch: pytest.MonkeyPatch) -> None:
    rules = Rules()

    async def parse_task(_: FakeInference, request):
        return await rules.parse_task(request)

    monkeypatch.setattr(FakeInference, "parse_task", parse_task)


# what is asked, and in which of the home's true rooms it is to be answered

COMMANDS: tuple[tuple[int, str, tuple[str, ...]], ...] = (
    (7101, "find a bottle in the kitchen", ("kitchen",)),
    (7101, "look for the book in the bedroom", ("bedroom",)),
    (7101, "find the suitcase in Anna's room", ("study",)),
    (7101, "search the bathroom for my cell phone", ("bathroom",)),
    (7102, "find the red bottle in the living room", ("living room",)),
    (7102, "bring me the cup from the kitchen", ("kitchen",)),
    (7102, "look in the library for the laptop", ("study",)),
    (7102, "go to the bedroom and find the teddy bear", ("bedroom",)),
    (7102, "in the lounge, find the remote", ("living room",)),
    (7104, "find the cup in the bedroom", ("bedroom", "study")),
    (7104, "find a book in any of the bedrooms", ("bedroom", "study")),
    (7104, "check the kitchen for a banana", ("kitchen",)),
    (7104, "find the scissors in my living room", ("living room",)),
    (7105, "find the red cup in the kitchen", ("kitchen",)),
    (7105, "look for the keyboard inside the bathroom", ("bathroom",)),
)
REFUSED: tuple[tuple[int, str], ...] = (
    (7101, "find the cup in the garage"),
    (7105, "find the cup in the hallway"),
    (7105, "find the cup in Anna's room"),
)
CONTENTS: tuple[tuple[int, str, tuple[str, ...]], ...] = (
    (7101, "what is in the kitchen?", ("kitchen",)),
    (7101, "what is in Anna's room", ("study",)),
    (7102, "what is in the library", ("study",)),
    (7102, "what did you see in the bathroom", ("bathroom",)),
    (7104, "what is in the bedroom?", ("bedroom", "study")),
    (7105, "list the things in the living room", ("living room",)),
)
COUNTS: tuple[tuple[int, str, str, tuple[str, ...]], ...] = (
    (7101, "how many beds are in the bedroom", "bed", ("bedroom",)),
    (7102, "how many refrigerators are in the kitchen", "refrigerator", ("kitchen",)),
    (7104, "how many beds are in the bedroom?", "bed", ("bedroom", "study")),
    (7105, "how many ovens are in the living room", "oven", ("living room",)),
)
WHERE: tuple[tuple[int, str, str, str], ...] = (
    (7101, "where is the refrigerator", "refrigerator", "in the kitchen"),
    (7105, "where is the toilet?", "toilet", "in the bathroom"),
)


@pytest.mark.parametrize("seed", SEEDS)
async def test_what_is_asked_by_room_is_answered_by_the_homes_true_rooms(seed: int, tmp_path: Path) -> None:
    async with running(seed, tmp_path) as mesh:
        for words, rooms in ((words, rooms) for home, words, rooms in COMMANDS if home == seed):
            await is_looked_for_there(mesh, words, rooms)
        for words in (words for home, words in REFUSED if home == seed):
            answer = await mesh.coordinator.post("/missions", json={"command": words})
            assert (answer.status_code, answer.json()["code"]) == (422, CommandRefusal.UNKNOWN_ROOM.value), words
            assert "kitchen" in answer.json()["detail"], words
        for words, rooms in ((words, rooms) for home, words, rooms in CONTENTS if home == seed):
            told, there = await mesh.ask(words), {one.label for one in mesh.true.of(rooms)}
            labels = {one.label for one in told.records}
            assert labels, words
            assert labels <= there, (words, labels - there)
        for words, label, rooms in ((words, label, rooms) for home, words, label, rooms in COUNTS if home == seed):
            assert len((await mesh.ask(words)).records) == len(mesh.true.of(rooms, label)), words
        for words, label, where in ((words, label, where) for home, words, label, where in WHERE if home == seed):
            told = await mesh.ask(words)
            assert [one.label for one in told.records][:1] == [label], words
            assert where in told.answer, words


async def is_looked_for_there(mesh: Running, words: str, rooms: tuple[str, ...]) -> None:
    """From a room that is not meant: every place it would go to lies in the rooms that are, and what memory knows of
    elsewhere stands in none of them."""
    outside = next(one.name for one in mesh.true.home.rooms if one.name not in rooms)
    x, y = mesh.true.middle(outside)
    mesh.world.pose = Pose2D(x=x, y=y, yaw=0.0)
    await mesh.clock.advance(0.3)
    begun, status, over = await mesh.planned(words)
    assert len(begun.rooms) == len(rooms), (words, begun.rooms)
    assert status.scan_points, words
    assert all(mesh.true.inside(rooms, p.x, p.y) for p in status.scan_points), (words, status.scan_points)
    assert over.report is not None
    assert over.report.rooms == begun.rooms
    assert over.target is not None
    known = {
        (round(one.x, 1), round(one.y, 1))
        for one in mesh.true.things
        if one.room not in rooms and over.target.may_be(one.label, one.colour)
    }
    told = {(round(one.place.x, 1), round(one.place.y, 1)) for one in over.report.elsewhere}
    assert told <= known, (words, told - known)
    assert bool(told) == bool(known), words


def test_thirty_are_asked() -> None:
    assert sum(map(len, (COMMANDS, REFUSED, CONTENTS, COUNTS, WHERE))) == 30
