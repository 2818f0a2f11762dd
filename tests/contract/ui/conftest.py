"""The service behind its front door, on fakes."""

from collections.abc import AsyncIterator

import httpx
import pytest
from asgi_lifespan import LifespanManager

from support.ui_world import UiWorld, fresh_nicegui
from ui.app import create_app
from ui.settings import Settings


@pytest.fixture
def world() -> UiWorld:
    return UiWorld()


@pytest.fixture
async def client(world: UiWorld) -> AsyncIterator[httpx.AsyncClient]:
    fresh_nicegui()
    deaths: list[str] = []
    app = create_app(
        Settings(),
        bus=world.bus,
        robot=world.robot,
        inference=world.inference.client(),
        missions=world.missions,
        memory=world.memory,
        on_death=lambda: deaths.append("a task died"),
    )
    async with (
        LifespanManager(app) as managed,
        httpx.AsyncClient(transport=httpx.ASGITransport(managed.app), base_url="http://ui") as opened,
    ):
        yield opened
    assert deaths == []
