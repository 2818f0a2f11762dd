"""The robot in Home Assistant over a real mosquitto, with the real coordinator and robot_bridge behind it."""

import asyncio
import contextlib
import json
import os
import sys
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import aiomqtt
import httpx
import pytest
from structlog.testing import capture_logs

from bench.world.wire import Served, Wire
from contracts.mission import Heard
from contracts.reading import Mood
from home_assistant.discovery import Entity, Topics
from home_assistant.robot_in_home import RobotInHome
from home_assistant.services import Coordinator, Robot
from home_assistant.settings import Settings
from mesh.clock import SystemClock
from support.consumer_providers import provider
from support.mosquitto_server import Broker, running_mosquitto
from support.waiting import until, until_true

pytestmark = pytest.mark.timeout(120)


@dataclass
class Home:
    """What Home Assistant would know: the newest payload of each topic."""

    broker: Broker
    settings: Settings
    client: aiomqtt.Client
    bridge: httpx.AsyncClient
    coordinator: httpx.AsyncClient
    robot: RobotInHome
    running: "asyncio.Task[None]"
    known: dict[str, bytes] = field(default_factory=dict[str, bytes])
    retained: set[str] = field(default_factory=set[str])

    @property
    def topics(self) -> Topics:
        return Topics.of(self.settings.identity)

    def says(self, entity: Entity) -> str:
        return self.known.get(self.topics.state(entity), b"").decode()

    def config(self, entity: Entity) -> Any:
        return json.loads(self.known[self.topics.config(entity)])

    @property
    def available(self) -> str:
        return self.known.get(self.topics.availability, b"").decode()

    async def press(self, entity: Entity, payload: str = "PRESS", *, retain: bool = False) -> None:
        await self.client.publish(self.topics.command(entity), payload, qos=1, retain=retain)

    async def latched(self) -> bool:
        return bool((await self.bridge.get("/emergency-stop")).json()["latched"])


Handler = Callable[[httpx.Request], Awaitable[httpx.Response]]


@contextlib.asynccontextmanager
async def at_home(
    folder: Path,
    broker: Broker,
    *,
    decides_as: Handler | None = None,
    on_the_way: Callable[[httpx.Request], Awaitable[None]] | None = None,
    **settings: Any,
) -> AsyncIterator[Home]:
    """`decides_as` answers in the coordinator's place; `on_the_way` holds what is sent to robot_bridge."""
    told = Settings.model_validate(
        {"mqtt_port": broker.port, "state_period_s": 0.1, "reconnect_s": 0.1, "camera_period_s": 0.2} | settings
    )
    async with contextlib.AsyncExitStack() as stack:
        bridge = await stack.enter_async_context(provider("robot_bridge", folder))
        decides = await stack.enter_async_context(provider("coordinator", folder))
        client = await stack.enter_async_context(aiomqtt.Client("127.0.0.1", broker.port))
        to_coordinator, to_bridge = Wire("home_assistant", decides), Wire("home_assistant", bridge)

        async def to_the_bridge(request: httpx.Request) -> httpx.Response:
            if on_the_way is not None:
                await on_the_way(request)
            return await to_bridge.handle_async_request(request)

        coordinator = Coordinator(told, transport=httpx.MockTransport(decides_as) if decides_as else to_coordinator)
        robot = Robot(told, transport=httpx.MockTransport(to_the_bridge))
        for one in (coordinator, robot):
            stack.push_async_callback(one.aclose)
        program = RobotInHome(told, coordinator=coordinator, robot=robot, clock=SystemClock())
        home = Home(broker, told, client, asking(bridge), asking(decides), program, asyncio.create_task(program.run()))
        await client.subscribe("#")
        listening = asyncio.create_task(hear(home))
        try:
            await until(lambda: home.available == "online" and home.says(Entity.STATE) != "")
            yield home
        finally:
            for task in (home.running, listening):
                task.cancel()
            await asyncio.gather(home.running, listening, return_exceptions=True)


def asking(service: Served) -> httpx.AsyncClient:
    return httpx.AsyncClient(transport=Wire("test", service), base_url=f"http://{service.name}")


async def hear(home: Home) -> None:
    async for message in home.client.messages:
        assert isinstance(message.payload, bytes)
        home.known[message.topic.value] = message.payload
        if message.retain:
            home.retained.add(message.topic.value)


@pytest.fixture
def broker(tmp_path: Path) -> Iterator[Broker]:
    with running_mosquitto(tmp_path) as running:
        yield running


async def test_home_assistant_discovers_the_robot_and_sees_how_it_does(tmp_path: Path, broker: Broker) -> None:
    async with at_home(tmp_path, broker) as home:
        configs = [home.config(entity) for entity in Entity if entity is not Entity.CAMERA]
        assert {one["device"]["name"] for one in configs} == {"ATOM"}
        assert home.known.get(home.topics.config(Entity.CAMERA), b"") == b""
        await until(lambda: home.says(Entity.LAST_FOUND) == "red bottle")
        assert json.loads(home.known[home.topics.attributes(Entity.LAST_FOUND)])["command"] == "find the red bottle"
        assert home.says(Entity.STATE) in home.config(Entity.STATE)["options"]
        assert home.says(Entity.BATTERY) == "None" or 0 <= int(home.says(Entity.BATTERY)) <= 100
        assert home.topics.state(Entity.CAMERA) not in home.known


async def test_the_stop_button_arrives_as_an_emergency_stop(tmp_path: Path, broker: Broker) -> None:
    async with at_home(tmp_path, broker) as home:
        assert not await home.latched()
        await home.press(Entity.STOP)
        await until_true(home.latched)
        told = (await home.bridge.get("/emergency-stop")).json()
        assert told["reason"] == "STOP pressed in Home Assistant"
        await until(lambda: home.says(Entity.STATE) == "emergency_stop")
        await until(lambda: home.says(Entity.ANSWER) == "stopped")


async def test_what_the_broker_kept_moves_nothing_and_neither_does_another_word(tmp_path: Path, broker: Broker) -> None:
    async with aiomqtt.Client("127.0.0.1", broker.port) as before:
        topics = Topics.of(Settings().identity)
        await before.publish(topics.command(Entity.STOP), "PRESS", qos=1, retain=True)
        await before.publish(topics.command(Entity.FIND), "red bottle", qos=1, retain=True)
    async with at_home(tmp_path, broker) as home:
        missions = (await home.coordinator.get("/missions")).json()
        await home.press(Entity.STOP, "press")
        await home.press(Entity.DOCK, "OFF")
        await home.press(Entity.FIND, "\x07")
        await until(lambda: home.says(Entity.ANSWER).startswith("say what to find"))
        assert not await home.latched()
        assert [one["id"] for one in (await home.coordinator.get("/missions")).json()] == [
            one["id"] for one in missions
        ]


async def test_a_typed_text_is_a_command_and_a_refusal_is_told(tmp_path: Path, broker: Broker) -> None:
    async with at_home(tmp_path, broker) as home:
        await home.press(Entity.FIND, "stop")  # what runs before
        await until(lambda: home.says(Entity.ANSWER) != "")
        await home.press(Entity.FIND, "find the red bottle")
        await until(lambda: home.says(Entity.ANSWER).endswith("red bottle"))
        assert home.says(Entity.FIND) == "find the red bottle"
        await home.press(Entity.FIND, "find the red bottle in the attic")
        await until(lambda: "attic" in home.says(Entity.ANSWER))


async def test_the_dock_button_sends_it_to_its_dock(tmp_path: Path, broker: Broker) -> None:
    async with at_home(tmp_path, broker) as home:
        await home.press(Entity.DOCK)
        await until(lambda: "dock" in home.says(Entity.ANSWER))
        status = (await home.coordinator.get("/state")).json()
        kinds = [one["kind"] for one in (status["mission"], *status["queue"]) if one is not None]
        assert "dock" in kinds


async def test_a_program_that_ends_says_that_it_is_away(tmp_path: Path, broker: Broker) -> None:
    async with at_home(tmp_path, broker) as home:
        home.running.cancel()
        await until(lambda: home.available == "offline")


async def test_a_program_that_is_killed_is_said_to_be_away_by_its_will(tmp_path: Path, broker: Broker) -> None:
    environment = os.environ | {
        "HOME_ASSISTANT_MQTT_PORT": str(broker.port),
        "HOME_ASSISTANT_COORDINATOR_URL": "http://127.0.0.1:9",
        "HOME_ASSISTANT_ROBOT_BRIDGE_URL": "http://127.0.0.1:9",
    }
    program = await asyncio.create_subprocess_exec(sys.executable, "-m", "home_assistant", env=environment)
    told: list[bytes] = []

    async def hear_of_it(client: aiomqtt.Client) -> None:
        async for message in client.messages:
            told.append(bytes(message.payload))  # type: ignore[arg-type]

    async with aiomqtt.Client("127.0.0.1", broker.port) as client:
        await client.subscribe(Topics.of(Settings().identity).availability)
        listening = asyncio.create_task(hear_of_it(client))
        try:
            await until(lambda: told[-1:] == [b"online"])
            program.kill()
            await until(lambda: told[-1:] == [b"offline"])
        finally:
            with contextlib.suppress(ProcessLookupError):
                program.kill()
            await program.wait()
            listening.cancel()
            await asyncio.gather(listening, return_exceptions=True)


async def test_where_home_assistant_begins_anew_it_is_told_everything_again(tmp_path: Path, broker: Broker) -> None:
    async with at_home(tmp_path, broker) as home:
        home.known.clear()
        await home.client.publish(home.topics.birth, "online")
        await until(lambda: home.available == "online" and home.says(Entity.STATE) != "")
        assert home.config(Entity.STOP)["payload_press"] == "PRESS"


async def test_a_camera_that_is_wanted_sends_pictures_that_the_broker_does_not_keep(
    tmp_path: Path, broker: Broker
) -> None:
    async with at_home(tmp_path, broker, camera=True) as home:
        await until(lambda: home.known.get(home.topics.state(Entity.CAMERA), b"")[:2] == b"\xff\xd8")
        assert home.config(Entity.CAMERA)["topic"] == home.topics.state(Entity.CAMERA)
        assert home.topics.state(Entity.CAMERA) not in home.retained


async def test_a_broker_that_comes_back_is_told_everything_again(tmp_path: Path) -> None:
    with running_mosquitto(tmp_path) as first:
        async with at_home(tmp_path, first) as home:
            first.process.terminate()
            await asyncio.to_thread(first.process.wait)
            with running_mosquitto(tmp_path, port=first.port):

                async def told() -> bool:
                    try:
                        async with aiomqtt.Client("127.0.0.1", first.port) as again:
                            await again.subscribe(home.topics.availability)
                            async with asyncio.timeout(1.0):
                                async for message in again.messages:
                                    return message.payload == b"online"
                    except (aiomqtt.MqttError, TimeoutError):
                        pass
                    return False

                await until_true(told)


async def away(request: httpx.Request) -> httpx.Response:
    raise httpx.ConnectError("refused", request=request)


async def silent(request: httpx.Request) -> httpx.Response:
    if request.method == "GET":
        return await away(request)
    await asyncio.Event().wait()
    raise AssertionError


def hearing(*, still: bool) -> Handler:
    async def answer(request: httpx.Request) -> httpx.Response:
        if request.method == "GET":
            return await away(request)
        heard = Heard(mood=Mood.STOP, text="stopped: nothing moves me any more" if still else "stopping", still=still)
        return httpx.Response(200, content=heard.model_dump_json())

    return answer


@pytest.mark.parametrize("decides_as", [away, silent, hearing(still=False)], ids=["away", "silent", "may still move"])
@pytest.mark.parametrize("typed", ["stop", "  STOP!\x07", "stop and find the cup"])
async def test_a_typed_stop_that_the_coordinator_does_not_confirm_becomes_the_emergency_stop(
    tmp_path: Path, broker: Broker, decides_as: Handler, typed: str
) -> None:
    async with at_home(tmp_path, broker, decides_as=decides_as) as home:
        await home.press(Entity.FIND, typed)
        await until_true(home.latched)
        assert "stop" in (await home.bridge.get("/emergency-stop")).json()["reason"].lower()
        await until(lambda: home.says(Entity.ANSWER) == "stopped")
        await until(lambda: home.says(Entity.FIND) == typed.strip())


async def test_a_typed_stop_that_the_coordinator_confirms_is_no_emergency(tmp_path: Path, broker: Broker) -> None:
    async with at_home(tmp_path, broker, decides_as=hearing(still=True)) as home:
        await home.press(Entity.FIND, "stop")
        await until(lambda: home.says(Entity.ANSWER) == "stopped: nothing moves me any more")
        assert not await home.latched()


async def test_a_typed_emergency_asks_nobody_first(tmp_path: Path, broker: Broker) -> None:
    started: list[httpx.Request] = []

    async def noting(request: httpx.Request) -> httpx.Response:
        if request.method == "POST":
            started.append(request)
        return await away(request)

    async with at_home(tmp_path, broker, decides_as=noting) as home:
        await home.press(Entity.FIND, "emergency stop")
        await until_true(home.latched)
        assert not started


async def test_a_stop_is_obeyed_however_much_else_is_asked_for(tmp_path: Path, broker: Broker) -> None:
    async with at_home(tmp_path, broker, decides_as=silent) as home:
        for thing in ("cup", "book", "shoe", "vase", "bottle"):
            await home.press(Entity.FIND, thing)
        await home.press(Entity.FIND, "stop")
        await until_true(home.latched)


async def test_a_stop_under_way_arrives_although_the_broker_goes_away(tmp_path: Path) -> None:
    on_its_way, let_go = asyncio.Event(), asyncio.Event()

    async def slow(request: httpx.Request) -> None:
        if request.url.path == "/emergency-stop" and request.method == "POST":
            on_its_way.set()
            await let_go.wait()

    with running_mosquitto(tmp_path) as broker:
        async with at_home(tmp_path, broker, on_the_way=slow) as home:
            await home.press(Entity.STOP)
            await on_its_way.wait()
            with capture_logs() as logs:
                broker.process.kill()
                await until(lambda: any(one["event"] == "no broker" for one in logs))
            let_go.set()
            await until_true(home.latched)


async def test_a_program_that_is_told_to_end_sends_its_stop_first(tmp_path: Path, broker: Broker) -> None:
    on_its_way, let_go = asyncio.Event(), asyncio.Event()

    async def slow(request: httpx.Request) -> None:
        if request.url.path == "/emergency-stop" and request.method == "POST":
            on_its_way.set()
            await let_go.wait()

    async with at_home(tmp_path, broker, on_the_way=slow) as home:
        await home.press(Entity.STOP)
        await on_its_way.wait()
        home.running.cancel()
        await until(lambda: home.available == "offline")
        let_go.set()
        await asyncio.gather(home.running, return_exceptions=True)
        assert await home.latched()
