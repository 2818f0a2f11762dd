"""The ear and the coordinator's own app over real HTTP; the ear's fake coordinator is held to the same answers."""

import asyncio
import contextlib
from collections.abc import AsyncGenerator, AsyncIterator
from dataclasses import dataclass, field
from datetime import time
from pathlib import Path

import pytest
import pytest_asyncio

from contracts.geometry import Pose2D
from contracts.intent import WantedAction
from contracts.mission import EventKind, Mission, MissionEvent, MissionState, Outcome
from contracts.robot import EmergencyStopReply, EmergencyStopRequest
from coordinator.app import create_app
from coordinator.settings import Settings as CoordinatorSettings
from ear import words
from ear.adapters.services import CoordinatorClient
from ear.core import State
from ear.ports import CHUNK_BYTES, Line
from ear.robot_ear import RobotEar
from ear.settings import Settings
from mesh.clock import SystemClock
from mesh.errors import UpstreamError
from mesh.tasks import Tasks
from support.coordinator_world import FakeInference, FakeMemory, Thing, World
from support.coordinator_world import FakeRobot as WorldRobot
from support.described import described_bus
from support.ear_fakes import (
    FakeCoordinator,
    FakeLoudspeaker,
    FakeRobot,
    FakeSource,
    FakeSpeech,
    FakeWakeWord,
    served_coordinator,
    transcript,
)
from support.served import served
from support.waiting import until, until_true

pytestmark = [pytest.mark.asyncio, pytest.mark.timeout(120)]
FAR = Pose2D(x=8.5, y=6.8, yaw=0.7)
"""Half a minute away: the mission runs as long as the test does."""
SILENCE = bytes(CHUNK_BYTES)
WAKING = FakeWakeWord.WORD.ljust(CHUNK_BYTES, b"\0")
STOP = [*[SILENCE] * 4, *[b"\x00\x20" * (CHUNK_BYTES // 2)] * 5, *[SILENCE] * 4]


@dataclass
class StoppingRobot(FakeRobot):
    """What it is told reaches the robot that the coordinator drives."""

    world: World | None = None

    async def emergency_stop(self, request: EmergencyStopRequest) -> EmergencyStopReply:
        assert self.world is not None
        reply = await super().emergency_stop(request)
        await self.world.latch(request.reason)
        return reply


@dataclass
class Home:
    world: World
    client: CoordinatorClient
    robot: StoppingRobot
    source: FakeSource = field(default_factory=FakeSource)
    speech: FakeSpeech = field(default_factory=FakeSpeech)
    wake_word: FakeWakeWord = field(default_factory=FakeWakeWord)
    loudspeaker: FakeLoudspeaker = field(default_factory=FakeLoudspeaker)

    @contextlib.asynccontextmanager
    async def hearing(self) -> AsyncGenerator[RobotEar]:
        died: list[str] = []
        async with Tasks(on_death=lambda: died.append("a task died")) as tasks:
            ear = RobotEar(
                settings=Settings(),
                clock=SystemClock(),
                time_of_day=lambda: time(12, 0),
                tasks=tasks,
                source=self.source,
                loudspeaker=self.loudspeaker,
                wake_word=self.wake_word,
                speech=self.speech,
                coordinator=self.client,
                robot=self.robot,
                memory=None,
            )
            tasks.start("ear", ear.run(), forever=False)
            yield ear
        assert died == []

    async def is_told(self, said: str) -> None:
        """The wake word, and this behind it."""
        lines = len(self.speech.lines)
        self.hears(WAKING)
        await until(lambda: len(self.speech.lines) > lines)
        self.speech.lines[-1].tell(transcript(said))

    def hears(self, *chunks: bytes) -> None:
        for chunk in chunks:
            self.source.given.put_nowait(chunk)

    async def running(self) -> Mission | None:
        mission = (await self.client.status()).mission
        return mission if mission is not None and mission.outcome is None else None

    async def runs(self) -> bool:
        return await self.running() is not None

    async def stands(self) -> bool:
        mission = await self.running()
        return mission is not None and mission.paused

    async def goes(self) -> bool:
        mission = await self.running()
        return mission is not None and not mission.paused


@contextlib.asynccontextmanager
async def opened_home(tmp_path: Path) -> AsyncGenerator[Home]:
    clock, bus = SystemClock(), described_bus()
    world = World(clock, bus, things=[Thing("bottle", "red", 9.0, 7.0)])  # pyright: ignore[reportArgumentType]
    deaths: list[str] = []
    app = create_app(
        CoordinatorSettings(database_url=f"sqlite:///{tmp_path / 'coordinator.db'}"),
        bus=bus,
        robot=WorldRobot(world),
        inference=FakeInference(world),
        memory=FakeMemory((FAR,)),
        clock=clock,
        on_death=lambda: deaths.append("a task died"),
    )
    moving = asyncio.create_task(world.run())
    async with served(app) as url:
        client = CoordinatorClient(Settings(coordinator_url=url), clock)
        yield Home(world, client, StoppingRobot(world=world))
        await client.aclose()
    moving.cancel()
    await asyncio.gather(moving, return_exceptions=True)
    assert deaths == []


@pytest_asyncio.fixture
async def home(tmp_path: Path) -> AsyncIterator[Home]:
    async with opened_home(tmp_path) as home:
        yield home


@dataclass
class Twin:
    client: CoordinatorClient
    fake: FakeCoordinator | None

    async def begin(self) -> Mission:
        begun = await self.client.start("find the red bottle")
        assert isinstance(begun, Mission)
        if self.fake is not None:
            self.fake.running = begun
            self.fake.happens(EventKind.START, SystemClock().now_s(), MissionState.MEMORY_NAV)
        return begun


@pytest_asyncio.fixture(params=["fake", "real"])
async def twin(request: pytest.FixtureRequest, tmp_path: Path) -> AsyncIterator[Twin]:
    if request.param == "real":
        async with opened_home(tmp_path) as home:
            yield Twin(home.client, None)
        return
    fake = FakeCoordinator()
    async with served(served_coordinator(fake, FakeRobot())) as url:
        client = CoordinatorClient(Settings(coordinator_url=url), SystemClock())
        yield Twin(client, fake)
        await client.aclose()


async def test_what_is_said_is_understood_as_a_wish(twin: Twin) -> None:
    told = (await twin.client.understand(("find the red bottle",))).intent
    assert told is not None
    assert (told.action, told.command) == (WantedAction.FIND, "find the red bottle")


async def test_a_mission_is_begun_is_told_of_and_is_the_one_that_runs(twin: Twin) -> None:
    happened = twin.client.events()
    assert await anext(happened) is Line.OPEN
    begun = await twin.begin()

    async def runs() -> bool:
        mission = (await twin.client.status()).mission
        return mission is not None and mission.id == begun.id and mission.outcome is None

    await until_true(runs)
    event = await anext(happened)
    while isinstance(event, MissionEvent) and event.kind is EventKind.QUEUED:
        event = await anext(happened)
    assert isinstance(event, MissionEvent)
    assert (event.kind, event.mission_id) == (EventKind.START, begun.id)
    assert (await twin.client.mission(begun.id)).command == "find the red bottle"
    await happened.aclose()  # pyright: ignore[reportAttributeAccessIssue]


async def test_a_mission_is_held_held_again_and_let_go(twin: Twin) -> None:
    begun = await twin.begin()

    async def held() -> bool:
        try:
            return (await twin.client.hold(begun.id, for_s=20.0)).paused
        except UpstreamError:  # it is about to begin
            return False

    await until_true(held)
    assert (await twin.client.hold(begun.id, for_s=20.0)).paused
    assert not (await twin.client.hold(begun.id, for_s=0.0)).paused


async def test_a_question_has_an_answer(twin: Twin) -> None:
    assert (await twin.client.ask("what are you doing?")).answer


async def test_what_is_said_to_it_begins_a_mission_that_a_stop_without_the_wake_word_ends(home: Home) -> None:
    home.speech.short = transcript("stop", stop=True)
    async with home.hearing() as ear:
        await until(lambda: not ear._following.may_move)
        await home.is_told("find the red bottle")
        await until_true(home.runs)
        await until(lambda: ear.ear.state is State.ASLEEP)
        await until_true(home.goes)
        home.hears(*STOP)
        await until(lambda: home.world.stop.latched)
        await until(lambda: home.speech.spoken == [words.STOPPED])
        await until(lambda: not ear._following.may_move)
        ended = (await home.client.status()).mission
        assert ended is not None
        assert ended.outcome is Outcome.ABORTED
        assert (await home.client.status()).state is MissionState.EMERGENCY_STOP
        await until(lambda: ear.ear.state is State.ASLEEP)
        assert home.speech.spoken == [words.STOPPED], "who stopped it knows how it ended"


async def test_while_somebody_speaks_the_mission_stands_and_then_it_goes_on(home: Home) -> None:
    await home.client.start("find the red bottle")
    await until_true(home.goes)
    async with home.hearing():
        home.hears(WAKING)
        await until_true(home.stands)
        home.speech.lines[-1].tell(transcript("what are you doing?"))
        await until(lambda: home.speech.spoken != [])
        assert "paused" not in home.speech.spoken[0]
        await until_true(home.goes)


async def test_a_pause_of_a_person_outlasts_a_talk(home: Home) -> None:
    mission = await home.client.start("find the red bottle")
    assert isinstance(mission, Mission)
    await until_true(home.goes)
    await home.client.call("POST", f"/missions/{mission.id}/pause")
    async with home.hearing() as ear:
        await home.is_told("")
        await until(lambda: ear.ear.state is State.ASLEEP)
        await ear._standing.settled()
        assert await home.stands()


async def test_a_person_pauses_it_by_voice(home: Home) -> None:
    await home.client.start("find the red bottle")
    await until_true(home.goes)
    async with home.hearing() as ear:
        await home.is_told("wait")
        await until(lambda: home.speech.spoken != [])
        await until(lambda: ear.ear.state is State.ASLEEP)
        await ear._standing.settled()
        assert await home.stands()


async def test_a_refusal_is_said_as_the_coordinator_says_it(home: Home) -> None:
    await home.world.latch("a person")

    async def stopped() -> bool:
        return (await home.client.status()).state is MissionState.EMERGENCY_STOP

    await until_true(stopped)
    async with home.hearing():
        await home.is_told("find the red bottle")
        await until(lambda: home.speech.spoken != [])
        assert "emergency stop" in home.speech.spoken[0]
        assert not await home.runs()
