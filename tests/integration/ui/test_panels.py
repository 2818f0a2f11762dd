"""Driving by hand, the map, memory, history, questions, news, and whether everybody can use them."""

import pytest
from axe_playwright_python.async_playwright import Axe
from playwright.async_api import Browser, Page, expect

from contracts.actions import DockAction, ExploreAction, LookAroundAction
from contracts.exploration import Discovery, ExplorationMode, ExplorationStatus
from contracts.mission import Outcome
from contracts.topics import MISSION_EVENTS, MISSION_STATE, ROBOT_STATE, VISION_DETECTIONS
from contracts.vision import Detection, Detections
from support.browser import DESKTOP, PHONE
from support.ui_world import STARTED_S, event, mission, robot_state, thing
from support.waiting import until

from .conftest import Site

pytestmark = [pytest.mark.asyncio(loop_scope="module"), pytest.mark.timeout(240)]

SERIOUS = {"serious", "critical"}


async def test_a_held_key_drives_and_letting_go_sends_zero(page: Page, site: Site) -> None:
    await site.mission_is(paused=True)
    await expect(page.get_by_role("status", name="Mission state")).to_have_text("Paused")
    sent = site.world.robot.velocities
    await page.get_by_role("button", name="Drive by hand").click()
    await until(lambda: site.world.robot.lines_open == 1, timeout_s=30.0)
    await page.keyboard.down("w")
    await until(lambda: len(sent) >= 3, timeout_s=30.0)
    assert all(one.twist.linear_x > 0.0 and one.duration_s <= 0.5 for one in sent)
    await page.keyboard.up("w")
    await until(lambda: sent[-1].twist.linear_x == 0.0, timeout_s=30.0)
    await page.get_by_role("button", name="Drive by hand").click()
    await until(lambda: site.world.robot.lines_open == 0, timeout_s=30.0)


async def test_a_page_that_loses_its_focus_lets_go(page: Page, site: Site) -> None:
    await site.mission_is(paused=True)
    sent = site.world.robot.velocities
    await page.get_by_role("button", name="Drive by hand").click()
    await until(lambda: site.world.robot.lines_open == 1, timeout_s=30.0)
    await page.keyboard.down("a")
    await until(lambda: len(sent) >= 1 and sent[-1].twist.angular_z > 0.0, timeout_s=30.0)
    await page.evaluate("window.dispatchEvent(new Event('blur'))")
    await until(lambda: sent[-1].twist.angular_z == 0.0, timeout_s=30.0)
    await page.keyboard.up("a")


async def test_driving_while_a_mission_drives_is_refused_with_the_reason(page: Page, site: Site) -> None:
    await page.get_by_role("button", name="Drive by hand").click()
    await page.keyboard.down("w")
    await expect(page.locator('[data-atom="drive-note"]')).to_contain_text("Pause it first")
    await page.keyboard.up("w")
    assert site.world.robot.velocities == []


async def test_a_stop_under_a_held_key_ends_that_holding_for_good(page: Page, site: Site) -> None:
    await site.mission_is(paused=True)
    sent = site.world.robot.velocities
    await page.get_by_role("button", name="Drive by hand").click()
    await until(lambda: site.world.robot.lines_open == 1, timeout_s=30.0)
    await page.keyboard.down("d")
    await until(lambda: len(sent) >= 1, timeout_s=30.0)
    site.world.robot.stop = site.world.robot.stop.model_copy(update={"epoch": site.world.robot.stop.epoch + 1})
    await expect(page.locator('[data-atom="drive-note"]')).to_contain_text("the epoch is over")
    count = len(sent)
    await page.keyboard.up("d")
    assert len(sent) == count


async def test_only_one_page_drives(page: Page, site: Site, browser: Browser) -> None:
    await page.get_by_role("button", name="Drive by hand").click()
    await until(lambda: site.world.robot.lines_open == 1, timeout_s=30.0)
    async with site.opened(browser, DESKTOP) as other:
        await other.get_by_role("button", name="Drive by hand").click()
        await expect(other.locator('[data-atom="drive-note"]')).to_have_text("Another page is driving.")


async def test_a_hidden_page_pulls_no_pictures(page: Page, site: Site) -> None:
    await expect(page.locator('[data-atom="live"][data-old="false"]')).to_be_visible()
    await page.evaluate("Object.defineProperty(document, 'hidden', {get: () => true, configurable: true})")
    count = "Number(document.querySelector('[data-atom=live]').dataset.frames)"
    unchanged = f"(() => {{ const was = window.was; window.was = {count}; return was === window.was; }})()"
    await page.wait_for_function(unchanged, polling=1500, timeout=60_000)
    fetched = site.world.robot.frames
    await page.wait_for_timeout(1000)
    assert site.world.robot.frames == fetched


async def test_a_click_on_the_map_sends_the_robot_there(page: Page, site: Site) -> None:
    await site.mission_is(outcome=Outcome.CANCELED)
    await expect(page.get_by_role("status", name="Mission state")).to_have_text("Cancelled")
    await page.locator('[data-atom="map"]').click(position={"x": 100, "y": 100})
    await site.world.bus.publish(ROBOT_STATE, robot_state())  # a robot tells it ten times a second
    await page.get_by_role("button", name="Go there").click()
    await expect(page.locator('[data-atom="place-note"]')).to_have_text("Driving there.")
    assert len(site.world.robot.goals) == 1
    await page.get_by_role("button", name="Stop driving there").click()
    await expect(page.locator('[data-atom="place-note"]')).to_have_text("Drive cancelled.")


async def test_a_click_on_the_map_during_a_mission_says_what_to_do_first(page: Page, site: Site) -> None:
    await page.locator('[data-atom="map"]').click(position={"x": 100, "y": 100})
    await page.get_by_role("button", name="Turn to look there").click()
    await expect(page.locator('[data-atom="place-note"]')).to_have_text("A mission is running. Pause it first.")
    assert site.world.robot.turns == []


async def test_the_memory_is_searched_and_a_thing_forgotten_after_a_question(page: Page, site: Site) -> None:
    await page.get_by_role("tab", name="Memory").click()
    things = page.get_by_role("list", name="Remembered things")
    await expect(things.locator("li")).to_have_count(2)
    await page.get_by_label("Search the memory").fill("red")
    await expect(things.locator("li")).to_have_count(1)
    await things.get_by_role("button", name="Forget red bottle").click()
    await expect(page.get_by_text("Forget the red bottle? It cannot be undone.")).to_be_visible()
    await page.get_by_role("button", name="Forget", exact=True).last.click()
    await expect(things.locator("li")).to_have_count(0)
    assert [one.description for one in site.world.memory.things] == ["blue cup"]


async def test_a_row_stays_under_the_hand_while_what_it_tells_changes(page: Page, site: Site) -> None:
    await page.get_by_role("tab", name="Memory").click()
    things = page.get_by_role("list", name="Remembered things")
    await expect(things.locator("li").first).to_contain_text("red bottle")
    forget = things.get_by_role("button", name="Forget red bottle")
    await forget.focus()
    site.world.memory.things = [thing(2, "blue cup", belief=0.9), thing(1, belief=0.2), thing(3, "green vase")]
    await expect(things.locator("li").first).to_contain_text("90 % sure")
    await expect(things.locator("li").last).to_contain_text("red bottle")
    await expect(forget).to_be_focused()


async def test_a_remembered_thing_shows_how_it_was_last_seen(page: Page, site: Site) -> None:
    stamp_s = STARTED_S + site.world.robot.frames + 0.5
    one = Detection(label="bottle", confidence=0.9, bbox_xyxy=(200, 140, 270, 254))
    seen = Detections(stamp_s=stamp_s, image_width_px=480, image_height_px=502, detections=(one,))
    site.world.memory.things = [thing(1, last_seen_s=stamp_s)]
    await site.world.bus.publish(VISION_DETECTIONS, seen)
    await page.get_by_role("tab", name="Memory").click()
    await expect(page.locator('.thumb[style*="things/1"]')).to_be_visible()


async def test_an_exported_memory_is_imported_again(page: Page, site: Site) -> None:
    await page.get_by_role("tab", name="Memory").click()
    data = b'{"form":"full"}' * 3000
    await page.locator("input[type=file]").set_input_files(
        {"name": "m.jsonl", "mimeType": "text/plain", "buffer": data}
    )
    await expect(page.get_by_text("Imported: 2 objects, 3 views.")).to_be_visible()
    assert site.world.memory.imported[-1] == data


async def test_a_question_is_answered_and_starts_no_mission(page: Page, site: Site) -> None:
    before = list(site.world.missions.commands)
    await page.get_by_label("What to find").fill("where did you last see my keys?")
    await page.keyboard.press("Enter")
    await expect(page.get_by_text("You asked: where did you last see my keys?")).to_be_visible()
    assert site.world.missions.commands == before


async def test_suggestions_come_from_memory(page: Page) -> None:
    offered = await page.get_by_label("What to find").get_attribute("list")
    await expect(page.locator(f"#{offered} option").first).to_have_attribute("value", "find the red bottle")


async def test_a_mission_of_the_history_is_opened_in_the_timeline(page: Page, site: Site) -> None:
    past = mission(
        "find the blue cup", id="old", outcome=Outcome.NOT_FOUND, ended_s=STARTED_S + 60.0, reason="not there"
    )
    site.world.missions.past = (past,)
    site.world.missions.timeline = (event(1, "looked everywhere", mission_id="old"),)
    await page.get_by_role("tab", name="Missions").click()
    await page.get_by_role("button", name="Open the timeline of find the blue cup").click()
    await expect(page.get_by_role("log")).to_contain_text("looked everywhere")
    await page.get_by_role("button", name="Back to now").click()
    await expect(page.get_by_role("log")).not_to_contain_text("looked everywhere")


async def test_a_moment_of_the_timeline_shows_its_picture(page: Page, site: Site) -> None:
    await site.world.bus.publish(MISSION_EVENTS, event(7, "seen on the way", mission_id=site.mission_id))
    await page.get_by_role("button", name="seen on the way").click()
    picture = page.get_by_alt_text("What the camera saw then")
    await expect(picture).to_be_visible()
    assert await picture.evaluate("image => image.decode().then(() => image.naturalWidth)") == 500


async def test_the_end_of_a_mission_is_told_wherever_one_looks(page: Page, site: Site) -> None:
    await page.get_by_role("tab", name="Robot").click()
    await site.mission_is(outcome=Outcome.FOUND, reason="found the red bottle")
    await expect(page.get_by_text("Found: “find the red bottle”. found the red bottle.")).to_be_visible()


async def test_an_exploration_is_shown_with_what_it_may_ask_and_what_it_discovered(page: Page, site: Site) -> None:
    await page.get_by_role("tab", name="Robot").click()
    await expect(page.get_by_role("heading", name="Exploration")).to_be_hidden()
    found = Discovery(label="kitchen", note="a fridge", x_m=1.0, y_m=2.0, stamp_s=STARTED_S)
    told = ExplorationStatus(
        mission_id=site.mission_id, mode=ExplorationMode.MODEL, why="begun", model="small",
        calls=3, calls_max=300, tokens=900, tokens_max=300_000, discoveries=(found,),
    )  # fmt: skip
    await site.mission_is()
    await site.world.bus.publish(MISSION_STATE, site.world.missions.current.model_copy(update={"exploration": told}))
    await expect(page.get_by_role("heading", name="Exploration")).to_be_visible()
    panel = page.locator(".exploration")
    for text in ("the model leads", "3 / 300", "900 / 300000", "kitchen: a fridge (x 1.0 m, y 2.0 m)"):
        await expect(panel.get_by_text(text)).to_be_visible()


async def test_a_button_begins_an_exploration_and_says_why_where_it_cannot(page: Page, site: Site) -> None:
    done = site.world.missions.done
    done.clear()
    await page.get_by_role("tab", name="Robot").click()
    explore = page.get_by_role("button", name="Explore for 2 min")
    answer = page.locator("section .answer:visible")
    await explore.click()
    await expect(answer.get_by_text("A mission is running or waits. Cancel it first")).to_be_visible()
    await site.mission_is(outcome=Outcome.CANCELED)
    await expect(page.get_by_role("status", name="Mission state")).to_have_text("Cancelled")
    await explore.click()
    await expect(answer.get_by_text("Begun: explore")).to_be_visible()
    await page.get_by_role("button", name="Go home").click()
    await expect(answer.get_by_text("Begun: dock")).to_be_visible()
    await page.get_by_role("button", name="Look around").click()
    await expect(answer.get_by_text("Begun: look_around")).to_be_visible()
    await page.get_by_role("button", name="Explore", exact=True).click()
    await until(lambda: len(done) == 4, timeout_s=30.0)
    assert done == [ExploreAction(duration_s=120.0), DockAction(), LookAroundAction(), ExploreAction()]
    await page.get_by_role("button", name="Emergency stop").click()
    await expect(page.get_by_text("The robot is stopped and stays stopped.")).to_be_visible()
    await explore.click()
    await expect(answer.get_by_text("The robot is stopped. Resume first.")).to_be_visible()
    assert len(done) == 4


@pytest.mark.parametrize(("size", "dark"), [(DESKTOP, False), (DESKTOP, True), (PHONE, False)])
async def test_axe_finds_nothing_serious(site: Site, browser: Browser, size: dict[str, int], dark: bool) -> None:
    found: list[str] = []
    async with site.opened(browser, size, dark=dark) as page:
        await expect(page.locator('[data-atom="live"][data-old="false"]')).to_be_visible()
        for tab in ("Timeline", "Memory", "Missions", "Robot"):
            await page.get_by_role("tab", name=tab).click()
            await expect(page.get_by_role("tab", name=tab)).to_have_attribute("aria-selected", "true")
            found += [f"{tab}: {one}" for one in await serious(page)]
        await page.get_by_role("button", name="Emergency stop").click()
        await expect(page.get_by_text("The robot is stopped and stays stopped.")).to_be_visible()
        await page.get_by_role("button", name="Resume after the emergency stop").click()
        await expect(page.get_by_text("Let the robot move again?")).to_be_visible()
        found += [f"stopped: {one}" for one in await serious(page)]
    assert not found, "\n".join(found)


async def serious(page: Page) -> list[str]:
    """Rules that are broken badly, and where."""
    results = await Axe().run(page)
    return [
        f"{one['id']} {node['target']} {node['html'][:160]} {node['any'][:1] and node['any'][0]['message']}"
        for one in results.response["violations"]
        if one["impact"] in SERIOUS
        for node in one["nodes"][:4]
    ]
