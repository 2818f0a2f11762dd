"""The service with real models, a real Redis and a real HTTP camera."""

import asyncio
import socket
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest
from asgi_lifespan import LifespanManager

from contracts.mission import MissionTarget
from contracts.topics import MISSION_TARGET, VISION_DETECTIONS
from contracts.vision import Detections, Target, Validation
from inference.app import create_app
from inference.settings import Backend, Settings
from mesh.bus import open_bus
from support.redis_server import free_port, start_redis
from support.waiting import until, until_true

from .bridge import running_bridge


@pytest.fixture
def bridge_url() -> Iterator[str]:
    with running_bridge() as url:
        yield url


async def test_frames_become_detections_on_redis_and_votes_are_cast(
    redis_url: str, bridge_url: str, untrained_detector: Path, untrained_clip: Path
) -> None:
    settings = Settings(
        redis_url=redis_url,
        robot_bridge_url=bridge_url,
        detector_path=untrained_detector,
        clip_path=untrained_clip,
        detector_backend=Backend.TORCH,
        rest_rate_hz=20.0,
    )
    heard: list[Detections] = []

    async def hear(message: Detections) -> None:
        heard.append(message)

    deaths: list[str] = []
    app = create_app(settings, on_death=lambda: deaths.append("a task died"))
    async with (
        open_bus(redis_url) as bus,
        LifespanManager(app, startup_timeout=60.0) as managed,
        httpx.AsyncClient(transport=httpx.ASGITransport(managed.app), base_url="http://inference") as client,
    ):
        listener = asyncio.create_task(bus.listen(VISION_DETECTIONS, hear))
        target = Target(label="bottle", description="red bottle")
        await bus.publish(MISSION_TARGET, MissionTarget(target=target))
        await until(lambda: len(heard) >= 3, timeout_s=60.0)
        ready = await client.get("/ready")
        after_s = heard[-1].stamp_s
        answer = await client.post("/validate", json={"target": target.model_dump(), "after_stamp_s": after_s})
        told = Validation.model_validate_json(answer.content)
        listener.cancel()
        await asyncio.gather(listener, return_exceptions=True)
        await bus.publish(MISSION_TARGET, MissionTarget())
    assert (ready.status_code, deaths) == (200, [])
    assert [one.stamp_s for one in heard] == sorted({one.stamp_s for one in heard})
    assert heard[0].pose is not None
    assert (heard[0].image_width_px, heard[0].model, heard[0].took_ms > 0.0) == (250, "untrained", True)
    assert [vote.voter for vote in told.votes] == ["detector", "clip", "vlm"]
    assert told.stamp_s > after_s


async def test_it_goes_on_by_itself_when_redis_and_the_bridge_come_back(
    untrained_detector: Path, untrained_clip: Path
) -> None:
    redis_port, bridge_port = free_port(), free_port()
    settings = Settings(
        redis_url=f"redis://127.0.0.1:{redis_port}/0",
        robot_bridge_url=f"http://127.0.0.1:{bridge_port}",
        detector_path=untrained_detector,
        clip_path=untrained_clip,
        detector_backend=Backend.TORCH,
        rest_rate_hz=20.0,
    )
    deaths: list[str] = []
    app = create_app(settings, on_death=lambda: deaths.append("a task died"))
    async with (
        LifespanManager(app, startup_timeout=60.0) as managed,
        httpx.AsyncClient(transport=httpx.ASGITransport(managed.app), base_url="http://inference") as client,
    ):
        for _ in range(2):
            redis = await asyncio.to_thread(start_redis, redis_port)
            try:
                with running_bridge(bridge_port):
                    await until_seen(settings.redis_url)
                    await until_ready_is(client, True)
            finally:
                redis.terminate()
                await asyncio.to_thread(redis.wait, 30.0)
            await until_ready_is(client, False)
    assert deaths == []


async def until_seen(redis_url: str) -> None:
    """A frame's detections are heard on this Redis."""
    heard = asyncio.Event()

    async def hear(_: Detections) -> None:
        heard.set()

    async with open_bus(redis_url) as bus, asyncio.timeout(60.0):
        listener = asyncio.create_task(bus.listen(VISION_DETECTIONS, hear))
        await heard.wait()
        listener.cancel()
        await asyncio.gather(listener, return_exceptions=True)


async def until_ready_is(client: httpx.AsyncClient, wanted: bool) -> None:
    async def is_it() -> bool:
        return (await client.get("/ready")).json()["ready"] is wanted

    await until_true(is_it, timeout_s=60.0)


async def test_it_starts_before_redis_and_the_bridge_and_says_what_is_missing(
    untrained_detector: Path, untrained_clip: Path
) -> None:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        closed_port = probe.getsockname()[1]
    settings = Settings(
        redis_url=f"redis://127.0.0.1:{closed_port}/0",
        robot_bridge_url=f"http://127.0.0.1:{closed_port}",
        detector_path=untrained_detector,
        clip_path=untrained_clip,
        detector_backend=Backend.TORCH,
    )
    app = create_app(settings)
    async with (
        LifespanManager(app) as managed,
        httpx.AsyncClient(transport=httpx.ASGITransport(managed.app), base_url="http://inference") as client,
    ):
        assert (await client.get("/health")).status_code == 200
        ready = (await client.get("/ready")).json()
    assert ready["ready"] is False
    assert {one["name"]: one["state"] for one in ready["dependencies"]}["redis"] == "unreachable"
