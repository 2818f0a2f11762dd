"""An exploration led over real HTTP by a stand-in for an Ollama server: it leads, fails in each way, and comes back.

The rules are those of docs/exploration.md, ten times as quick. `test_watchdog` has each tier on a simulated clock.
"""

import asyncio
import io
import math
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import httpx
import pytest
from PIL import Image

from contracts.exploration import DecisionVerdict, ExplorationEnd, ExplorationMode, ExplorationStatus
from coordinator.adapters.camera_eye import hash_of
from coordinator.adapters.ollama_pilot import OllamaPilot
from coordinator.app import create_app
from coordinator.execution.exploration_runner import ExplorationRunner
from coordinator.exploration import commands as do
from coordinator.exploration.rules import AskingRules, ExplorationRules, WatchdogRules
from coordinator.settings import Settings
from mesh.clock import SystemClock
from mesh.errors import UnavailableError
from mesh.tasks import Tasks
from support.coordinator_world import PICTURE, FakeInference, FakeMemory, FakeRobot, World
from support.described import described_bus
from support.exploration_memory import KeptHomes
from support.language_servers import LanguageServer, OllamaHandler, Reply, running
from support.served import served
from support.waiting import until, until_true

M = ExplorationMode
QUICK = ExplorationRules(
    asking=AskingRules(due_s=1.0, again_s=0.2, answer_s=1.0),
    watchdog=WatchdogRules(stand_s=0.3, local_s=1.0, home_s=4.0),
)


def calls(name: str, **arguments: Any) -> Reply:
    return Reply({"tool_calls": [{"function": {"name": name, "arguments": arguments}}]})


AHEAD = calls("move_toward", bearing_rad=0.0, distance_m=1.0)


@pytest.fixture
def server() -> Iterator[LanguageServer]:
    with running(OllamaHandler) as one:
        one.says(AHEAD)
        yield one


@dataclass
class Led:
    world: World
    runner: ExplorationRunner
    modes: list[ExplorationMode] = field(default_factory=list[ExplorationMode])

    @property
    def home_m(self) -> float:
        return math.hypot(self.world.pose.x - 1.5, self.world.pose.y - 1.5)

    @property
    def understood(self) -> dict[DecisionVerdict, int]:
        return dict(self.runner.exploration.verdicts)


@asynccontextmanager
async def led(server: LanguageServer, rules: ExplorationRules = QUICK) -> AsyncIterator[Led]:
    clock = SystemClock()
    world = World(clock, described_bus(), mapped_m=2.5)  # type: ignore[arg-type]
    settings = Settings.model_validate({"exploration_model": "small", "exploration_model_url": server.url})
    pilot = OllamaPilot(settings, timeout_s=5.0)
    died: list[str] = []
    modes: list[ExplorationMode] = []

    def told(command: do.TellMode | do.Remember | do.Finish) -> None:
        if isinstance(command, do.TellMode):
            modes.append(command.mode)

    async with Tasks(on_death=lambda: died.append("a task")) as tasks:
        runner = ExplorationRunner(
            FakeRobot(world), pilot, rules=rules, clock=clock, tasks=tasks, journal=KeptHomes(), told=told
        )
        tasks.start("runner", runner.run())
        await until(lambda: runner.exploration.chart is not None)
        await runner.begin(world.pose)
        yield Led(world, runner, modes)
    await pilot.aclose()
    assert died == []


async def test_a_server_that_is_killed_half_way_ends_it_at_home(server: LanguageServer) -> None:
    async with led(server) as one:
        await until(lambda: one.home_m > 0.8)
        assert one.modes == [M.MODEL]
        server.mood = "dies_mid_answer"
        server.shutdown()
        server.server_close()
        await until(one.runner.ended.is_set)
        assert one.runner.exploration.end is ExplorationEnd.MODEL_SILENT
        assert one.home_m < 0.5
        assert [mode for mode in one.modes if mode is not M.REACTIVE] == [M.MODEL, M.FRONTIERS, M.RETURNING, M.IDLE]


@pytest.mark.parametrize("mood", ["slow", "floods", "overloaded", "dies_mid_answer"])
async def test_while_nobody_answers_the_frontiers_lead_and_an_answer_leads_again(
    server: LanguageServer, mood: str
) -> None:
    async with led(server) as one:
        await until(lambda: "drive" in one.world.moves)
        server.mood = mood
        await until(lambda: M.FRONTIERS in one.modes)
        server.mood = "valid"
        await until(lambda: one.modes[-1] is M.MODEL)
        assert one.runner.exploration.silent_since_s is None


async def test_in_the_second_tier_the_robot_stands(server: LanguageServer) -> None:
    patient = ExplorationRules(
        asking=AskingRules(due_s=0.5, answer_s=20.0), watchdog=WatchdogRules(stand_s=0.5, local_s=20.0, home_s=30.0)
    )
    async with led(server, patient) as one:
        await until(lambda: "drive" in one.world.moves)
        server.mood = "slow"
        await until(lambda: one.runner.exploration.question is not None)
        await until(lambda: not one.runner.exploration.moving)
        asked = one.runner.exploration.question
        assert asked is not None
        stood, moves = one.world.pose, len(one.world.moves)
        await until(lambda: SystemClock().now_s() - asked.asked_s > 3 * patient.watchdog.stand_s)
        assert one.runner.exploration.question is asked
        assert (one.world.pose, len(one.world.moves), one.modes) == (stood, moves, [M.MODEL])


@pytest.mark.parametrize(
    "wrong",
    [
        calls("cmd_vel", linear_x=2.0),
        calls("rotate", angle_rad=float("nan")),
    ],
)
async def test_three_that_are_not_understood_make_one_stretch_without_the_model(
    server: LanguageServer, wrong: Reply
) -> None:
    server.says(wrong)
    async with led(server) as one:
        await until(lambda: M.FRONTIERS in one.modes)
        assert one.understood == {DecisionVerdict.NOT_UNDERSTOOD: 3}
        server.says(AHEAD)
        await until(lambda: one.modes[-1] is M.MODEL and len(one.modes) > 1)


# in the coordinator


@asynccontextmanager
async def coordinator(server: LanguageServer, folder: Path, **settings: object) -> AsyncIterator[httpx.AsyncClient]:
    bus = described_bus()
    world = World(SystemClock(), bus, mapped_m=2.5, map_id="flat")  # type: ignore[arg-type]
    told = {
        "database_url": f"sqlite:///{folder / 'coordinator.db'}", "exploration_model": "small",
        "exploration_model_url": server.url,
    }  # fmt: skip
    app = create_app(
        Settings.model_validate(told | settings),
        bus=bus,
        robot=FakeRobot(world),
        inference=FakeInference(world),
        memory=FakeMemory(),
        camera=Camera(),
    )
    async with served(app) as url, httpx.AsyncClient(base_url=url, trust_env=False) as client:
        life = asyncio.create_task(world.run())
        try:
            await until_true(lambda: ready(client))
            assert (await client.post("/actions", json={"action": "explore"})).status_code == 201
            yield client
        finally:
            life.cancel()
            await asyncio.gather(life, return_exceptions=True)


class Camera:
    """The port `Camera`: the same picture twice, then none."""

    def __init__(self) -> None:
        self.left = 2

    async def frame(self) -> bytes:
        self.left -= 1
        if self.left < 0:
            raise UnavailableError("robot_bridge", "no picture")
        return PICTURE


async def ready(client: httpx.AsyncClient) -> bool:
    return (await client.get("/ready")).is_success


async def at(client: httpx.AsyncClient) -> ExplorationStatus | None:
    told = (await client.get("/state")).json()["exploration"]
    return ExplorationStatus.model_validate(told) if told is not None else None


async def test_the_model_that_is_set_leads_and_is_told_of(server: LanguageServer, tmp_path: Path) -> None:
    server.says(calls("report_discovery", label="kitchen", note="a fridge"), AHEAD)
    async with coordinator(server, tmp_path, exploration_pictures=True) as client:

        async def has_led() -> bool:
            one = await at(client)
            return one is not None and one.calls >= 3 and one.actions >= 2

        await until_true(has_led)
        one = await at(client)
        assert one is not None
        assert (one.model, one.mode, one.calls_max, one.tokens_max) == ("small", M.MODEL, 300, 300_000)
        assert one.tokens >= 20 * (one.calls - 1)
        assert [found.label for found in one.discoveries] == ["kitchen"]
        mission = (await client.get("/missions")).json()[0]
        lines = [each["text"] for each in (await client.get(f"/missions/{mission['id']}/events")).json()]
        assert "exploring, model: begun" in lines
        assert [line for line in lines if line.startswith("discovered")] == ["discovered: kitchen (a fridge)"]
    assert sum("images" in each["messages"][1] for each in server.asked) >= 1


async def test_what_may_be_spent_is_bounded_by_settings(server: LanguageServer, tmp_path: Path) -> None:
    async with coordinator(server, tmp_path, exploration_calls_max=2) as client:

        async def has_spent_it() -> bool:
            one = await at(client)
            return one is not None and one.mode is M.FRONTIERS

        await until_true(has_spent_it)
        one = await at(client)
        assert one is not None
        assert (one.calls, one.why) == (2, "nothing is left to spend on the model")
    assert len(server.asked) == 2


def jpeg(width_px: int, height_px: int) -> bytes:
    out = io.BytesIO()
    Image.new("RGB", (width_px, height_px)).save(out, "JPEG")
    return out.getvalue()


@pytest.mark.parametrize(
    "picture", [b"no picture", b"", PICTURE[:200], PICTURE[: len(PICTURE) // 2], jpeg(2, 2), jpeg(5000, 9)]
)
def test_what_is_no_picture_of_a_camera_has_no_view(picture: bytes) -> None:
    assert hash_of(PICTURE) is not None
    assert hash_of(picture) is None
