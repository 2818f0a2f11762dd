"""What a person does on the page, and what it says; the services behind it are fakes."""

import asyncio

import pytest
from playwright.async_api import Browser, Page, expect

from contracts.mission import EventFacts
from contracts.topics import MISSION_EVENTS
from support.browser import DESKTOP, PHONE
from support.ui_world import event, votes
from support.waiting import until

from .conftest import Site

pytestmark = [pytest.mark.asyncio(loop_scope="module"), pytest.mark.timeout(240)]


async def test_a_typed_command_becomes_a_mission(page: Page, site: Site) -> None:
    await page.get_by_label("What to find").fill("find the blue cup")
    await page.keyboard.press("Enter")
    await expect(page.get_by_text("Looking for: red bottle")).to_be_visible()
    assert site.world.missions.commands[-1] == "find the blue cup"


async def test_what_was_typed_and_sent_before_the_page_was_connected_arrives_whole(
    site: Site, browser: Browser
) -> None:
    for command in ("find the blue cup", "find the teddy bear", "find the green bottle"):
        connects = asyncio.Event()
        async with site.opened(browser, DESKTOP, connects=connects) as page:
            await page.get_by_label("What to find").press_sequentially(command)
            await page.keyboard.press("Enter")
            connects.set()
            await expect(page.get_by_text("Looking for: red bottle")).to_be_visible()
            assert site.world.missions.commands[-1] == command


async def test_a_refusal_is_shown_in_its_own_words(page: Page, site: Site) -> None:
    site.world.missions.refusal = "nothing in it is known to me"
    await page.get_by_label("What to find").fill("find the flux capacitor")
    await page.get_by_role("button", name="Find").click()
    await expect(page.get_by_text("Refused: nothing in it is known to me")).to_be_visible()
    await expect(page.get_by_label("What to find")).to_have_value("find the flux capacitor")


async def test_the_stop_button_stops_and_resume_asks_first(page: Page, site: Site) -> None:
    before = len(site.world.robot.stops)
    await page.get_by_role("button", name="Emergency stop").click()
    await expect(page.get_by_text("The robot is stopped and stays stopped.")).to_be_visible()
    await expect(page.get_by_text("first zero velocity after 2.4 ms")).to_have_count(1)
    await expect(page.locator('[data-atom="stop-result"]')).to_be_empty()
    await expect(page.locator(".stop")).to_contain_text("STOPPED")
    assert len(site.world.robot.stops) == before + 1
    await page.get_by_role("button", name="Resume after the emergency stop").click()
    resets = len(site.world.robot.resets)
    await page.get_by_role("button", name="Keep stopped").click()
    await expect(page.get_by_text("Let the robot move again?")).to_be_hidden()
    assert len(site.world.robot.resets) == resets
    await page.get_by_role("button", name="Resume after the emergency stop").click()
    await page.get_by_role("button", name="Resume", exact=True).click()
    await expect(page.get_by_text("The robot is stopped and stays stopped.")).to_be_hidden()
    assert len(site.world.robot.resets) == resets + 1


async def test_stop_goes_out_when_the_button_goes_down_and_a_whole_press_is_one_stop(page: Page, site: Site) -> None:
    before = len(site.world.robot.stops)
    await page.get_by_role("button", name="Emergency stop").hover()
    await page.mouse.down()
    await until(lambda: len(site.world.robot.stops) == before + 1, timeout_s=30.0)
    await page.mouse.up()
    await page.locator(".stop").focus()
    await page.keyboard.press("Enter")
    await until(lambda: len(site.world.robot.stops) >= before + 2, timeout_s=30.0)
    await expect(page.get_by_text("The robot is stopped and stays stopped.")).to_be_visible()
    assert len(site.world.robot.stops) == before + 2


async def test_escape_stops_from_anywhere_also_while_typing(page: Page, site: Site) -> None:
    before = len(site.world.robot.stops)
    await page.get_by_label("What to find").fill("find the")
    await page.keyboard.press("Escape")
    await expect(page.get_by_text("The robot is stopped and stays stopped.")).to_be_visible()
    assert [stop.reason for stop in site.world.robot.stops[before:]] == ["Esc pressed on the page"]


async def test_stop_can_be_pressed_over_an_open_question(page: Page, site: Site) -> None:
    await page.get_by_role("button", name="Emergency stop").click()
    await page.get_by_role("button", name="Resume after the emergency stop").click()
    before = len(site.world.robot.stops)
    await page.locator(".stop").click()
    await until(lambda: len(site.world.robot.stops) == before + 1, timeout_s=30.0)


async def test_a_stop_that_does_not_reach_the_robot_is_unmistakable(page: Page, site: Site) -> None:
    site.world.robot.away = True
    await page.get_by_role("button", name="Emergency stop").click()
    await expect(page.get_by_text("STOP DID NOT REACH THE ROBOT: robot_bridge: not reachable")).to_be_visible()


async def test_a_service_that_goes_away_is_named_until_it_is_back(page: Page, site: Site) -> None:
    site.world.memory.away = True
    await expect(page.get_by_text("memory not reachable")).to_be_visible()
    site.world.memory.away = False
    await expect(page.get_by_text("memory not reachable")).to_be_hidden()


async def test_redis_away_is_named_and_the_page_goes_on(page: Page, site: Site) -> None:
    site.world.bus.connected = False
    await expect(page.get_by_text("Redis not reachable")).to_be_visible()
    await page.get_by_label("What to find").fill("find the cup")
    await page.keyboard.press("Enter")
    await until(lambda: site.world.missions.commands[-1:] == ["find the cup"], timeout_s=30.0)


async def test_pictures_flow_and_a_lost_eye_is_named(page: Page, site: Site) -> None:
    await expect(page.locator('[data-atom="live"][data-old="false"]')).to_be_visible()
    before = site.world.robot.frames
    await until(lambda: site.world.robot.frames >= before + 3, timeout_s=30.0)
    site.world.robot.away = True
    await expect(page.locator('[data-atom="live-note"]')).to_contain_text("robot_bridge: not reachable")
    site.world.robot.away = False
    await expect(page.locator('[data-atom="live"][data-old="false"]')).to_be_visible()


async def test_the_timeline_shows_the_newest_first_with_votes_as_numbers(page: Page, site: Site) -> None:
    await site.world.bus.publish(MISSION_EVENTS, event(1, "begun", mission_id=site.mission_id))
    data = EventFacts(votes=votes())
    await site.world.bus.publish(
        MISSION_EVENTS, event(2, "2 of 3 say yes", kind="votes", data=data, mission_id=site.mission_id)
    )
    lines = page.get_by_role("log").locator("li")
    await expect(lines).to_have_count(2)
    await expect(lines.first).to_contain_text("2 of 3 say yes")
    await expect(lines.first).to_contain_text("yes 0.62 / 0.45")
    await expect(lines.last).to_contain_text("begun")


async def test_on_a_phone_everything_is_in_one_column_and_stop_stays_on_screen(site: Site, browser: Browser) -> None:
    async with site.opened(browser, PHONE) as page:
        assert await page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]
        await page.get_by_role("tab", name="Robot").click()
        await page.get_by_text("Sensors").scroll_into_view_if_needed()
        await expect(page.get_by_role("button", name="Emergency stop")).to_be_in_viewport(ratio=1.0)


async def test_on_a_desktop_everything_fits_one_screen(page: Page) -> None:
    assert await page.evaluate("document.documentElement.scrollHeight") <= DESKTOP["height"]
    await page.get_by_role("tab", name="Robot").click()
    await expect(page.get_by_role("button", name="Undock")).to_be_in_viewport(ratio=1.0)
