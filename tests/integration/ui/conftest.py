"""The page in real Chromium, served by uvicorn, on fakes of the services behind it."""

import asyncio
import contextlib
from collections.abc import AsyncIterator
from dataclasses import dataclass

import pytest_asyncio
from playwright.async_api import Browser, Page, WebSocketRoute, async_playwright, expect

from contracts.belief import NoBelief
from contracts.robot import EmergencyStop
from contracts.topics import MISSION_STATE, ROBOT_STATE
from support.browser import CHROMIUM, CHROMIUM_ARGS, DESKTOP, FAKE_MICROPHONE
from support.served import served
from support.ui_world import UiWorld, fresh_nicegui, hearing, mission, robot_state, status, thing
from ui.app import create_app
from ui.settings import Settings

expect.set_options(timeout=60_000)


@dataclass
class Site:
    """A running service; `begin` puts the world behind it where every test starts."""

    url: str
    world: UiWorld
    missions: int = 0

    @property
    def mission_id(self) -> str:
        return f"m-{self.missions}"

    async def begin(self) -> None:
        """Everyone there, the robot free to move and telling where it is, a mission of its own under way."""
        world = self.world
        world.bus.connected = True
        for service in (world.robot, world.inference, world.missions, world.memory, world.speech):
            service.away = False
        world.missions.refusal, world.missions.hangs = "", False
        world.missions.commands.clear()
        world.speech.readings, world.speech.ends_by_itself = (hearing(""),), False
        world.speech.ears.clear()
        world.speech.spoken.clear()
        world.missions.past = ()
        world.missions.believed = NoBelief.ANOTHER_RULE
        world.memory.things = [thing(1), thing(2, "blue cup", belief=0.3)]
        world.robot.stop = EmergencyStop(latched=False, epoch=len(world.robot.stops))
        world.robot.velocities.clear()
        world.robot.goals.clear()
        world.robot.asked.clear()
        self.missions += 1
        await self.robot_stands()
        await self.mission_is()

    async def robot_stands(self) -> None:
        await self.world.bus.publish(ROBOT_STATE, robot_state(stop=self.world.robot.stop))

    async def mission_is(self, **changes: object) -> None:
        self.world.missions.current = status(mission(id=self.mission_id, **changes))
        await self.world.bus.publish(MISSION_STATE, self.world.missions.current)

    @contextlib.asynccontextmanager
    async def opened(
        self,
        browser: Browser,
        size: dict[str, int],
        *,
        dark: bool = False,
        connects: asyncio.Event | None = None,
        touch: bool = False,
        at: str = "",
    ) -> AsyncIterator[Page]:
        """The page, connected; fails when it asks for anything from outside, or a script of it fails.

        `connects`: until it is set, what is done on the page cannot reach the service, as over a slow network.
        `at`: the address, where a proxy stands before it.
        """
        await self.begin()
        context = await browser.new_context(
            viewport=size,  # pyright: ignore[reportArgumentType]
            color_scheme="dark" if dark else "light",
            has_touch=touch,
        )
        try:
            page = await context.new_page()
            outside: list[str] = []
            complaints: list[str] = []
            address = at or self.url
            ours = (address.rstrip("/"), "blob:", "data:")
            page.on("request", lambda asked: None if asked.url.startswith(ours) else outside.append(asked.url))
            page.on("pageerror", lambda error: complaints.append(str(error)))
            if connects is not None:
                await page.route_web_socket("**/_nicegui_ws/**", lambda socket: _connect(socket, connects))
            await page.goto(address, timeout=120_000)
            await expect(page.get_by_role("status", name="Mission state")).to_have_text("Looking around")
            await expect(page.locator('[data-atom="map"][data-fresh="true"]')).to_be_visible()
            yield page
            assert outside == []
            assert complaints == []
        finally:
            await context.close()


async def _connect(socket: WebSocketRoute, when: asyncio.Event) -> None:
    await when.wait()
    socket.connect_to_server()


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def site() -> AsyncIterator[Site]:
    fresh_nicegui()
    world = UiWorld()
    app = create_app(
        Settings(health_period_s=0.3, state_period_s=0.2, memory_period_s=0.3, silence_s_max=30.0),
        bus=world.bus,
        robot=world.robot,
        inference=world.inference.client(),
        missions=world.missions,
        memory=world.memory,
        speech=world.speech,
    )
    async with served(app) as url:
        yield Site(url, world)


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def browser() -> AsyncIterator[Browser]:
    async with async_playwright() as playwright:
        opened = await playwright.chromium.launch(executable_path=CHROMIUM, args=[*CHROMIUM_ARGS, *FAKE_MICROPHONE])
        yield opened
        await opened.close()


@pytest_asyncio.fixture(loop_scope="module")
async def page(site: Site, browser: Browser) -> AsyncIterator[Page]:
    """A desktop's page, connected, with a robot that tells where it is."""
    async with site.opened(browser, DESKTOP) as ready:
        yield ready
