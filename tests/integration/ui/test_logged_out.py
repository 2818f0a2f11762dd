"""A log-in that ends while its page is open leads to the form; a STOP that is refused stays and says so."""

from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_asyncio
from playwright.async_api import Page, async_playwright, expect
from pydantic import SecretStr

from contracts.access import CredentialFile, Principal, Role, sha256_of
from support.browser import CHROMIUM, CHROMIUM_ARGS
from support.served import served
from support.ui_world import UiWorld, fresh_nicegui
from ui.app import create_app
from ui.settings import Settings

pytestmark = [pytest.mark.asyncio(loop_scope="module"), pytest.mark.timeout(240)]
OTTO = Principal(name="otto", role=Role.OPERATOR, key_sha256=sha256_of("otto's"))
MIA = Principal(name="mia", role=Role.VIEWER, key_sha256=sha256_of("mia's"))


def know(file: Path, *who: Principal) -> None:
    file.write_text(CredentialFile(principals=who).model_dump_json())


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def page(tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[tuple[Page, Path]]:
    """Logged in, with the file that says who may."""
    fresh_nicegui()
    world, file = UiWorld(), tmp_path_factory.mktemp("keys") / "keys.json"
    know(file, OTTO, MIA)
    app = create_app(
        Settings(keys_file=file, key=SecretStr("the page's own")),
        bus=world.bus, robot=world.robot, inference=world.inference.client(), missions=world.missions,
        memory=world.memory, speech=world.speech,
    )  # fmt: skip
    async with served(app) as url, async_playwright() as playwright:
        browser = await playwright.chromium.launch(executable_path=CHROMIUM, args=CHROMIUM_ARGS)
        opened = await browser.new_page()
        await opened.goto(url)
        await opened.get_by_label("Password or key").fill("otto's")
        await opened.get_by_role("button", name="Log in").click()
        await expect(opened.get_by_label("What to find")).to_be_visible()
        yield opened, file
        await browser.close()


async def test_a_refused_stop_stays_on_the_page_and_tells_what_helps(page: tuple[Page, Path]) -> None:
    """As a proxy before the page may refuse it."""
    opened, _ = page
    await opened.route("**/stop*", lambda route: route.fulfill(status=401, json={"title": "who are you?"}))
    await opened.keyboard.press("Escape")
    await expect(opened.get_by_text("STOP DID NOT REACH THE ROBOT: who are you?")).to_be_visible()
    assert not opened.url.endswith("/login")
    await opened.unroute("**/stop*")
    await opened.reload()
    await expect(opened.get_by_label("What to find")).to_be_visible()


async def test_who_may_only_look_is_shown_no_microphone(page: tuple[Page, Path]) -> None:
    """Speech would refuse the sound, and a stop said into it would reach nobody."""
    opened, _ = page
    await expect(opened.get_by_role("button", name="Hold to speak")).to_be_visible()
    assert opened.context.browser is not None
    hers = await opened.context.browser.new_page()
    await hers.goto(opened.url)
    await hers.get_by_label("Password or key").fill("mia's")
    await hers.get_by_role("button", name="Log in").click()
    await expect(hers.get_by_label("What to find")).to_be_visible()
    await expect(hers.get_by_role("button", name="Hold to speak")).to_be_hidden(timeout=5000)


async def test_a_revoked_log_in_leads_to_the_form(page: tuple[Page, Path]) -> None:
    opened, file = page
    know(file)
    await expect(opened.get_by_text("Who are you?")).to_be_visible()
    assert opened.url.endswith("/login")
