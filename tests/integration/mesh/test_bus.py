"""One behaviour suite over both buses: the in-memory one the tests use, and the real one over redis-server."""

import asyncio
import contextlib
from collections.abc import AsyncIterator

import pytest
import redis.asyncio as redis

from contracts.geometry import Pose2D
from contracts.mission import MissionTarget
from contracts.robot import Goal, GoalStatus
from contracts.topics import MISSION_TARGET, ROBOT_NAVIGATION
from contracts.vision import Target
from mesh.bus import Bus, RedisBus, open_bus
from mesh.tracing import following, traceparent
from support.bus import MemoryBus
from support.redis_server import free_port, start_redis
from support.waiting import until

BOTTLE = MissionTarget(target=Target(label="bottle", description="red bottle"), mission_id="m1")


def goal(number: int) -> Goal:
    return Goal(id=str(number), pose=Pose2D(x=0, y=0, yaw=0), status=GoalStatus.EXECUTING, stamp_s=1.0)


@pytest.fixture(params=["memory", "redis"])
async def bus(request: pytest.FixtureRequest, redis_url: str) -> AsyncIterator[Bus]:
    if request.param == "memory":
        yield MemoryBus()
        return
    client = redis.Redis.from_url(redis_url)
    await client.flushall()
    await client.aclose()
    async with open_bus(redis_url) as opened:
        yield opened


@contextlib.asynccontextmanager
async def listening(bus: Bus, topic: object, into: list[object]) -> AsyncIterator[None]:
    async def keep(message: object) -> None:
        into.append(message)

    task = asyncio.create_task(bus.listen(topic, keep))  # type: ignore[arg-type]
    try:
        yield
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)


async def publish_until_heard(bus: Bus, into: list[object]) -> None:
    async with asyncio.timeout(45):
        while not into:
            await bus.publish(ROBOT_NAVIGATION, goal(0))
            await asyncio.sleep(0.01)


async def test_messages_arrive_in_order(bus: Bus) -> None:
    heard: list[object] = []
    async with listening(bus, ROBOT_NAVIGATION, heard):
        await publish_until_heard(bus, heard)
        for number in range(1, 6):
            assert await bus.publish(ROBOT_NAVIGATION, goal(number))
        await until(lambda: goal(5) in heard)
    assert [m for m in heard if m != goal(0)] == [goal(n) for n in range(1, 6)]


async def test_a_late_listener_is_told_the_kept_value(bus: Bus) -> None:
    await bus.publish(MISSION_TARGET, BOTTLE)
    assert await bus.last(MISSION_TARGET) == BOTTLE
    heard: list[object] = []
    async with listening(bus, MISSION_TARGET, heard):
        await until(lambda: heard == [BOTTLE])


async def test_nothing_is_kept_of_a_topic_that_is_not(bus: Bus) -> None:
    await bus.publish(ROBOT_NAVIGATION, goal(1))
    assert await bus.last(ROBOT_NAVIGATION) is None


async def test_malformed_and_oversized_messages_are_dropped_and_later_ones_heard(redis_url: str) -> None:
    heard: list[object] = []
    client = redis.Redis.from_url(redis_url)
    async with open_bus(redis_url) as bus, listening(bus, ROBOT_NAVIGATION, heard):
        await publish_until_heard(bus, heard)
        for hostile in (b"", b"{", b"[]", b'{"id": 1}', b"\xff\xfe", b'"' + b"x" * 4_100_000 + b'"'):
            await client.publish(ROBOT_NAVIGATION.name, hostile)
        await bus.publish(ROBOT_NAVIGATION, goal(7))
        await until(lambda: goal(7) in heard)
    await client.aclose()
    assert {type(message) for message in heard} == {Goal}


async def test_payloads_are_plain_json_that_anything_can_read(redis_url: str) -> None:
    client = redis.Redis.from_url(redis_url)
    async with open_bus(redis_url) as bus:
        await bus.publish(MISSION_TARGET, BOTTLE)
    assert await client.get(MISSION_TARGET.kept_key) == BOTTLE.model_dump_json().encode()
    await client.aclose()


async def test_a_listener_heals_when_redis_comes_back() -> None:
    port = free_port()
    heard: list[object] = []
    async with open_bus(f"redis://127.0.0.1:{port}/0") as bus:
        assert not await bus.publish(ROBOT_NAVIGATION, goal(1))
        async with listening(bus, ROBOT_NAVIGATION, heard):
            for _ in range(2):
                server = start_redis(port)
                heard.clear()
                await publish_until_heard(bus, heard)
                assert bus.connected
                server.kill()
                server.wait(timeout=45)
                await until(lambda: not bus.connected)


def test_the_real_bus_is_a_bus() -> None:
    assert {name for name in vars(Bus) if not name.startswith("_")} <= set(dir(RedisBus))


async def test_a_listener_is_inside_the_trace_a_message_was_said_in(bus: Bus) -> None:
    parent, heard = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01", list[str]()

    async def hear(_: MissionTarget) -> None:
        heard.append(traceparent())

    with following(parent):
        await bus.publish(MISSION_TARGET, BOTTLE)  # kept: a listener who comes later is told with its trace too
    task = asyncio.create_task(bus.listen(MISSION_TARGET, hear))
    await until(lambda: len(heard) == 1)
    await bus.publish(MISSION_TARGET, BOTTLE)
    await until(lambda: len(heard) == 2)
    task.cancel()
    assert heard == [parent, ""]
