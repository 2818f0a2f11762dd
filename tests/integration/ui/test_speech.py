"""Speaking to the page, in real Chromium with a microphone of its own, on a fake of the speech service."""

import json
from collections.abc import AsyncIterator

import pytest
import pytest_asyncio
from playwright.async_api import Browser, Locator, Page, expect

from contracts.mission import Outcome
from support.browser import DESKTOP, PHONE
from support.ui_world import hearing
from support.waiting import until

from .conftest import Site

pytestmark = [pytest.mark.asyncio(loop_scope="module"), pytest.mark.timeout(240)]

RATE_HZ = 16_000
LIGHT = "Microphone open"


@pytest_asyncio.fixture(loop_scope="module")
async def page(site: Site, browser: Browser) -> AsyncIterator[Page]:
    async with site.opened(browser, DESKTOP) as ready:
        await expect(mic(ready)).to_be_visible()
        yield ready


def mic(page: Page) -> Locator:
    return page.get_by_role("button", name="Hold to speak")


def heard(page: Page) -> Locator:
    return page.locator('[data-atom="heard"]')


async def heard_for_half_a_second(site: Site) -> None:
    """Longer than a tap, and the browser's microphone beeps once a second."""
    await until(lambda: len(site.world.speech.ears[-1].heard) >= RATE_HZ, timeout_s=30.0)


async def spoken(page: Page, site: Site) -> None:
    """Holds the button while the microphone is open for a moment."""
    await mic(page).hover()
    await page.mouse.down()
    await expect(page.get_by_text(LIGHT)).to_be_visible()
    await heard_for_half_a_second(site)
    await page.mouse.up()
    await expect(page.get_by_text(LIGHT)).to_be_hidden()


async def test_what_is_said_while_the_button_is_held_is_shown_and_put_in_the_box_and_not_sent(
    page: Page, site: Site
) -> None:
    site.world.speech.readings = (hearing("find the", final=False), hearing("Find the blue cup."))
    await mic(page).hover()
    await page.mouse.down()
    await expect(heard(page)).to_have_text("find the")
    await expect(page.get_by_text(LIGHT)).to_be_visible()
    await until(lambda: any(site.world.speech.ears[0].heard), timeout_s=30.0)  # the browser's microphone beeps
    assert site.world.speech.ears[0].held, "silence ends nothing"
    await page.mouse.up()
    await expect(page.get_by_label("What to find")).to_have_value("Find the blue cup.")
    await expect(page.get_by_text(LIGHT)).to_be_hidden()
    assert site.world.missions.commands == []
    sound = bytes(site.world.speech.ears[0].heard)
    assert len(sound) % 3200 == 0, "a tenth of a second at a time"
    await page.get_by_role("button", name="Find", exact=True).click()
    await until(lambda: site.world.missions.commands[:1] == ["Find the blue cup."], timeout_s=30.0)


async def test_the_space_bar_held_opens_the_microphone_but_not_while_something_is_typed(page: Page, site: Site) -> None:
    site.world.speech.readings = (hearing("find the cup"),)
    said = page.get_by_label("What to find")
    await said.click()
    await page.keyboard.press("Space")
    await expect(said).to_have_value(" ")
    assert site.world.speech.ears == []
    await said.fill("")
    await page.get_by_role("log").focus()
    await page.keyboard.press("Space")
    assert site.world.speech.ears == []
    await page.get_by_role("log").evaluate("element => element.blur()")
    await page.keyboard.down("Space")
    await expect(page.get_by_text(LIGHT)).to_be_visible()
    await heard_for_half_a_second(site)
    await page.keyboard.up("Space")
    await expect(said).to_have_value("find the cup")


async def test_a_tap_listens_until_the_speaker_is_done(page: Page, site: Site) -> None:
    site.world.speech.readings, site.world.speech.ends_by_itself = (hearing("find the cup"),), True
    await mic(page).click()
    await expect(page.get_by_label("What to find")).to_have_value("find the cup")
    await expect(page.get_by_text(LIGHT)).to_be_hidden()
    assert not site.world.speech.ears[0].ended.is_set()
    assert not site.world.speech.ears[0].held, "silence ends a tap"


async def test_what_was_heard_is_sent_at_once_where_that_is_set_and_the_browser_keeps_the_setting(
    page: Page, site: Site
) -> None:
    site.world.speech.readings = (hearing("find the cup"),)
    await page.get_by_label("Send at once what was heard").check()
    await page.reload()
    await expect(page.get_by_label("Send at once what was heard")).to_be_checked()
    await expect(page.locator('[data-atom="map"][data-fresh="true"]')).to_be_visible()
    await spoken(page, site)
    await until(lambda: site.world.missions.commands == ["find the cup"], timeout_s=30.0)


async def test_readings_that_differ_are_a_choice_and_what_is_chosen_is_sent(page: Page, site: Site) -> None:
    site.world.speech.readings = (hearing("find the blue cap", "find the blue cup"),)
    await spoken(page, site)
    await expect(heard(page)).to_have_text("Did you mean: find the blue cup, or find the blue cap?")
    assert site.world.missions.commands == []
    await page.get_by_role("button", name="find the blue cap").click()
    await until(lambda: site.world.missions.commands == ["find the blue cap"], timeout_s=30.0)
    await expect(page.get_by_role("button", name="find the blue cup")).to_be_hidden()


async def test_a_spoken_stop_is_shown_and_is_no_command(page: Page, site: Site) -> None:
    site.world.speech.readings = (hearing("stop", final=False, stop=True), hearing("Stop!", stop=True))
    stops = len(site.world.robot.stops)
    await spoken(page, site)
    await expect(heard(page)).to_have_text("The robot was told to stop: “Stop!”")
    assert [one.reason for one in site.world.robot.stops[stops:]] == ["said: stop"]
    assert site.world.missions.commands == []


async def test_what_was_said_is_pondered_with_the_microphone_shut_and_a_press_opens_it_anew(
    page: Page, site: Site
) -> None:
    site.world.missions.hangs = True
    site.world.speech.readings, site.world.speech.ends_by_itself = (hearing("find the cup"),), True
    stops = len(site.world.robot.stops)
    await mic(page).click()
    await expect(heard(page)).to_have_text("find the cup", timeout=2500)  # the coordinator has three seconds
    await expect(page.get_by_text(LIGHT)).to_be_hidden(timeout=100)
    site.world.speech.readings, site.world.speech.ends_by_itself = (hearing("Stop!", stop=True),), False
    await spoken(page, site)
    await expect(heard(page)).to_have_text("The robot was told to stop: “Stop!”")
    assert [one.reason for one in site.world.robot.stops[stops:]] == ["said: Stop!"]
    assert len(site.world.speech.ears) == 2
    await expect(page.get_by_label("What to find")).to_have_value("")


async def test_a_stop_that_did_not_arrive_stays_on_the_page_when_speech_dies_behind_it(page: Page, site: Site) -> None:
    site.world.robot.away = True
    site.world.speech.readings = (hearing("stop", final=False, stop=True), hearing("stop", stop=True))
    await mic(page).hover()
    await page.mouse.down()
    await expect(heard(page)).to_have_text("“stop” did not reach the robot. Press STOP.")
    await heard_for_half_a_second(site)
    site.world.speech.away = True
    await page.mouse.up()
    await expect(heard(page)).to_have_text(
        "“stop” did not reach the robot. Press STOP. The microphone is away: speech: not reachable"
    )


async def test_while_speech_is_away_it_is_named_and_the_rest_of_the_page_works(page: Page, site: Site) -> None:
    site.world.speech.away = True
    await expect(page.locator(".away")).to_have_text("speech not reachable")
    await mic(page).click()
    await expect(heard(page)).to_have_text("The microphone is away: speech: not reachable")
    await expect(page.get_by_text(LIGHT)).to_be_hidden()
    await page.get_by_label("What to find").fill("find the red bottle")
    await page.keyboard.press("Enter")
    await until(lambda: site.world.missions.commands == ["find the red bottle"], timeout_s=30.0)


async def test_answers_and_endings_are_read_aloud_only_where_that_is_set(page: Page, site: Site) -> None:
    said = page.get_by_label("What to find")
    await said.fill("where is my cup?")
    await page.keyboard.press("Enter")
    await expect(page.get_by_text("You asked: where is my cup?")).to_be_visible()
    assert site.world.speech.spoken == []
    await page.get_by_label("Read answers aloud").check()
    await said.fill("where is my book?")
    await page.keyboard.press("Enter")
    await until(lambda: site.world.speech.spoken == ["You asked: where is my book?"], timeout_s=30.0)
    await site.mission_is(outcome=Outcome.NOT_FOUND, reason="looked everywhere", ended_s=1_800_000_100.0)
    await until(lambda: "looked everywhere" in site.world.speech.spoken[-1], timeout_s=30.0)


async def test_a_page_that_is_not_secure_says_why_there_is_no_microphone(page: Page, site: Site) -> None:
    await page.add_init_script("Object.defineProperty(window, 'isSecureContext', { value: false })")
    await page.reload()
    await expect(heard(page)).to_contain_text("The microphone needs https")
    await mic(page).click()
    await expect(heard(page)).to_contain_text("docs/speech.md")
    assert site.world.speech.ears == []


async def test_the_browser_keeps_no_sound(page: Page, site: Site) -> None:
    site.world.speech.readings = (hearing("find the cup"),)
    await spoken(page, site)
    await expect(page.get_by_label("What to find")).to_have_value("find the cup")
    kept = await page.evaluate("() => JSON.stringify(Object.entries(localStorage))")
    assert [name for name, _ in json.loads(kept) if name.startswith("atom")] == []


async def test_on_a_phone_a_finger_on_the_button_opens_the_microphone(site: Site, browser: Browser) -> None:
    site_world = site.world.speech
    async with site.opened(browser, PHONE, touch=True) as phone:
        site_world.readings, site_world.ends_by_itself = (hearing("find the cup"),), True
        await mic(phone).tap()
        await expect(phone.get_by_label("What to find")).to_have_value("find the cup")
        assert await phone.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]
