"""The page below a path of a proxy: everything on it works, and it asks for nothing beside that path."""

import pytest
from playwright.async_api import Browser, expect

from contracts.mission import Outcome
from contracts.topics import MISSION_EVENTS, VISION_DETECTIONS
from contracts.vision import Detection, Detections
from support.browser import DESKTOP
from support.proxy import Proxy
from support.served import served
from support.ui_world import STARTED_S, event, thing
from support.waiting import until

from .conftest import Site

pytestmark = [pytest.mark.asyncio(loop_scope="module"), pytest.mark.timeout(240)]

OTHERS = [
    pytest.param({"prefix": "/robot", "strips": False, "keeps_host": True}, "/robot/", id="it leaves the prefix on"),
    pytest.param(
        {"prefix": "/api/hassio_ingress/aB3_-x", "says": "x-ingress-path", "keeps_host": True},
        "/api/hassio_ingress/aB3_-x/",
        id="Home Assistant's ingress",
    ),
    pytest.param({"prefix": "/robot", "said": "/robot/"}, "/robot", id="opened without its slash at the end"),
]


@pytest.mark.parametrize(("how", "path"), OTHERS)
async def test_however_a_proxy_serves_it_the_page_lives_drives_and_stops(
    site: Site, browser: Browser, how: dict[str, object], path: str
) -> None:
    proxy = Proxy(site.url, **how)  # type: ignore[arg-type]
    async with served(proxy.app()) as url, site.opened(browser, DESKTOP, at=url + path) as page:
        await expect(page.locator('[data-atom="live"][data-old="false"]')).to_be_visible()
        await page.get_by_role("button", name="Drive by hand").click()
        await until(lambda: site.world.robot.lines_open == 1, timeout_s=30.0)
        stops = len(site.world.robot.stops)
        await page.get_by_role("button", name="Emergency stop").click()
        await until(lambda: len(site.world.robot.stops) == stops + 1, timeout_s=30.0)
    assert [path for _, path in proxy.seen if not path.startswith(proxy.prefix)] == []


async def test_below_a_prefix_everything_works_and_nothing_beside_it_is_asked_for(site: Site, browser: Browser) -> None:
    proxy = Proxy(site.url, prefix="/robot")
    async with served(proxy.app()) as url, site.opened(browser, DESKTOP, at=f"{url}/robot/") as page:
        stops = len(site.world.robot.stops)
        await page.get_by_role("button", name="Emergency stop").click()
        await expect(page.get_by_text("The robot is stopped and stays stopped.")).to_be_visible()
        await page.keyboard.press("Escape")
        await until(lambda: len(site.world.robot.stops) == stops + 2, timeout_s=30.0)
        await page.get_by_role("button", name="Resume after the emergency stop").click()
        await page.get_by_role("button", name="Resume", exact=True).click()
        await expect(page.get_by_text("The robot is stopped and stays stopped.")).to_be_hidden()

        await expect(page.locator('[data-atom="live"][data-old="false"]')).to_be_visible()
        shown = page.get_by_alt_text("Map of the rooms")
        assert await shown.evaluate("image => image.decode().then(() => image.naturalWidth)") > 0

        await page.get_by_label("What to find").fill("find the blue cup")
        await page.keyboard.press("Enter")
        await expect(page.get_by_text("Looking for: red bottle")).to_be_visible()

        await site.mission_is(paused=True)
        await expect(page.get_by_role("status", name="Mission state")).to_have_text("Paused")
        await page.get_by_role("button", name="Drive by hand").click()
        await until(lambda: site.world.robot.lines_open == 1, timeout_s=30.0)
        await page.keyboard.down("w")
        await until(lambda: len(site.world.robot.velocities) >= 2, timeout_s=30.0)
        await page.keyboard.up("w")
        await page.get_by_role("button", name="Drive by hand").click()

        await site.world.bus.publish(MISSION_EVENTS, event(7, "seen on the way", mission_id=site.mission_id))
        await page.get_by_role("button", name="seen on the way").click()
        picture = page.get_by_alt_text("What the camera saw then")
        assert await picture.evaluate("image => image.decode().then(() => image.naturalWidth)") == 500

        await site.mission_is(outcome=Outcome.CANCELED)
        await expect(page.get_by_role("status", name="Mission state")).to_have_text("Cancelled")
        await site.robot_stands()
        await page.locator('[data-atom="map"]').click(position={"x": 100, "y": 100})
        await page.get_by_role("button", name="Go there").click()
        await expect(page.locator('[data-atom="place-note"]')).to_have_text("Driving there.")

        stamp_s = STARTED_S + site.world.robot.frames + 0.5
        one = Detection(label="bottle", confidence=0.9, bbox_xyxy=(200, 140, 270, 254))
        seen = Detections(stamp_s=stamp_s, image_width_px=480, image_height_px=502, detections=(one,))
        site.world.memory.things = [thing(1, last_seen_s=stamp_s)]
        await site.world.bus.publish(VISION_DETECTIONS, seen)
        await page.get_by_role("tab", name="Memory").click()
        async with page.expect_response("**/things/1?v=*") as thumbnail:
            await expect(page.locator('.thumb[style*="things/1"]')).to_be_visible()
        assert (await thumbnail.value).status == 200
        async with page.expect_download() as download:
            await page.get_by_text("Export").click()
        assert (await download.value).suggested_filename == "atom-memory.jsonl"
        await page.locator("input[type=file]").set_input_files(
            {"name": "m.jsonl", "mimeType": "text/plain", "buffer": b'{"form":"full"}'}
        )
        await expect(page.get_by_text("Imported: 2 objects, 3 views.")).to_be_visible()
    assert [path for _, path in proxy.seen if not path.startswith(proxy.prefix)] == []


async def test_behind_a_proxy_that_says_nothing_of_its_prefix_stop_works_all_the_same(
    site: Site, browser: Browser
) -> None:
    await site.begin()
    proxy = Proxy(site.url, prefix="/robot", says="")
    async with served(proxy.app()) as url:
        page = await browser.new_page()
        stops = len(site.world.robot.stops)
        await page.goto(f"{url}/robot/")
        await page.get_by_role("button", name="Emergency stop").click()
        await until(lambda: len(site.world.robot.stops) == stops + 1, timeout_s=30.0)
        await expect(page.locator('[data-atom="page-missing"]')).to_contain_text("did not load")
        await page.close()


async def test_a_page_of_another_origin_can_stop_and_do_nothing_else(site: Site, browser: Browser) -> None:
    await site.begin()
    page = await browser.new_page()
    elsewhere = Proxy("http://127.0.0.1:1", prefix="/nothing")
    async with served(elsewhere.app()) as url:
        await page.goto(f"{url}/")
        asked = """async ([url, headers]) => fetch(url, {method: "POST", headers, mode: "no-cors", body: ""})
            .then((answer) => answer.type, (error) => "refused")"""
        stops, goals = len(site.world.robot.stops), len(site.world.robot.goals)
        assert await page.evaluate(asked, [f"{site.url}/place/halt", {}]) == "opaque"
        assert await page.evaluate(asked, [f"{site.url}/stop", {}]) == "opaque"
        forged = """async ([url, host]) => fetch(url, {method: "POST", headers: {"X-Forwarded-Host": host}, body: ""})
            .then((answer) => answer.type, (error) => "refused")"""
        assert await page.evaluate(forged, [f"{site.url}/place/halt", url.removeprefix("http://")]) == "refused"
        socket = """(url) => new Promise((done) => { const socket = new WebSocket(url);
            socket.onopen = () => done("open"); socket.onerror = () => done("refused"); })"""
        assert await page.evaluate(socket, f"ws{site.url.removeprefix('http')}/teleop") == "refused"
    await page.close()
    assert (len(site.world.robot.stops), len(site.world.robot.goals)) == (stops + 1, goals)
    assert "end motion" not in site.world.robot.asked
