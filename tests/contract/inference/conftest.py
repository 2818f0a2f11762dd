"""The service behind its front door, on fakes."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from dataclasses import dataclass, field
from typing import Any

import httpx
import pytest
from asgi_lifespan import LifespanManager

from contracts.mission import MissionTarget
from contracts.topics import MISSION_TARGET
from contracts.vision import Target
from inference.app import create_app
from inference.perception.models import Loaded
from inference.settings import Settings
from support.bus import MemoryBus
from support.inference_fakes import FakeCamera, FakeClip, FakeDetector, FakeLanguageModel, bottle, loads

RED_BOTTLE = Target(label="bottle", description="red bottle")


@dataclass
class House:
    """Everything the service touches, and a client of it."""

    bus: MemoryBus = field(default_factory=MemoryBus)
    camera: FakeCamera = field(default_factory=FakeCamera)
    detector: FakeDetector = field(default_factory=lambda: FakeDetector((bottle(),)))
    clip: FakeClip | None = field(default_factory=FakeClip)
    load: Callable[[], Loaded] | None = None
    language_model: FakeLanguageModel | None = None
    vlm: FakeLanguageModel | None = None
    deaths: list[str] = field(default_factory=list)
    client: httpx.AsyncClient = field(init=False)

    async def look_for(self, target: Target | None, *, fast: bool = False) -> None:
        await self.bus.publish(MISSION_TARGET, MissionTarget(target=target, fast=fast))

    async def until_loaded(self) -> dict[str, Any]:
        """The first readiness that does not say that models load."""
        async with asyncio.timeout(45.0):
            while True:
                ready = (await self.client.get("/ready")).json()
                if ready["dependencies"][0]["detail"] != "loading":
                    return ready
                await asyncio.sleep(0.01)

    async def until_drawn(self, stamp_s: float) -> None:
        """The frame of that stamp has been through the whole loop."""
        async with asyncio.timeout(45.0):
            drawn_s = None
            while drawn_s != stamp_s:
                answer = await self.client.get(
                    "/annotated", params={"wait_s": 5.0} | ({"after": drawn_s} if drawn_s else {})
                )
                drawn_s = float(answer.headers["x-stamp-s"])


Opened = Callable[..., AbstractAsyncContextManager[House]]


@pytest.fixture
def opened() -> Opened:
    """Opens a house; its models are loaded, unless it brings a `load` of its own."""

    @asynccontextmanager
    async def open_house(house: House | None = None, **changed: Any) -> AsyncIterator[House]:
        inside = house or House()
        quick: dict[str, Any] = {"rest_rate_hz": 50.0, "fast_rate_hz": 50.0, "frame_wait_s": 0.2}
        quick |= {"validate_frame_wait_s": 0.2, "vlm_deadline_s": 0.2, "parse_deadline_s": 0.2}
        app = create_app(
            Settings(**(quick | changed)),
            bus=inside.bus,
            camera=inside.camera,
            models=inside.load or loads(detector=inside.detector, clip=inside.clip),
            language_models=None if inside.language_model is None else [inside.language_model],
            vlm=inside.vlm,
            on_death=lambda: inside.deaths.append("a task died"),
        )
        async with (
            LifespanManager(app) as managed,
            httpx.AsyncClient(transport=httpx.ASGITransport(managed.app), base_url="http://inference") as client,
        ):
            inside.client = client
            if inside.load is None:
                await inside.until_loaded()
            yield inside
        assert inside.deaths == []

    return open_house
