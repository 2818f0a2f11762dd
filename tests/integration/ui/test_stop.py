"""A STOP that cannot work is seen to be dead within two seconds and says what to do; one that can, works."""

import re

import pytest
from axe_playwright_python.async_playwright import Axe
from playwright.async_api import Browser, Locator, Page, expect

from support.browser import DESKTOP, PHONE
from support.proxy import Proxy
from support.served import served
from support.waiting import until

from .conftest import Site

pytestmark = [pytest.mark.asyncio(loop_scope="module"), pytest.mark.timeout(240)]

REMEDY = "curl -X POST http://ROBOT:8004/emergency-stop, or: atom stop"
DEAD_MS_MAX = 2000.0
OURS = {"camera.js", "belief.js", "map.js", "drive.js", "memory.js", "speech.js", "ui.css"}
DEAD = '[data-atom="stop-dead"]'

SHOWN_AFTER = """async () => {
    const from = performance.now();
    while (document.querySelector('[data-atom="stop-place"]').dataset.watch !== "dead")
        await new Promise((seen) => { requestAnimationFrame(seen); });
    return performance.now() - from;
}"""


UNASKED_FOR = """async (silent_ms) => {
    let [at, number] = [performance.now(), 0];
    while (performance.now() - at < silent_ms) {
        const now = performance.getEntriesByType("resource").length;
        if (now !== number) [at, number] = [performance.now(), now];
        await new Promise((later) => { setTimeout(later, 50); });
    }
}"""

ANSWERED = """async (times) => {
    const before = performance.getEntriesByType("resource").length;
    while (performance.getEntriesByType("resource").length < before + times)
        await new Promise((later) => { setTimeout(later, 50); });
}"""


async def dead_after_ms(page: Page) -> float:
    """Milliseconds until STOP is shown as dead, by the browser's own clock."""
    ms: float = await page.evaluate(SHOWN_AFTER)
    await expect(page.locator(DEAD)).to_be_visible()
    return ms


async def asked_whether_to_resume(page: Page) -> Locator:
    """Stops the robot and opens the question; returns the button that answers it."""
    await page.locator(".stop").click()
    await page.get_by_role("button", name="Resume after the emergency stop").click()
    resume = page.get_by_role("button", name="Resume", exact=True)
    await expect(resume).to_be_visible()
    return resume


async def works_again(page: Page, site: Site) -> None:
    await expect(page.locator(DEAD)).to_be_hidden()
    before = len(site.world.robot.stops)
    await page.locator(".stop").click()
    await until(lambda: len(site.world.robot.stops) == before + 1, timeout_s=30.0)


async def test_while_the_robot_cannot_be_reached_stop_is_dead_says_what_to_do_and_comes_back(
    page: Page, site: Site
) -> None:
    site.world.robot.away = True
    assert await dead_after_ms(page) < DEAD_MS_MAX
    await expect(page.locator(DEAD)).to_contain_text("This STOP does not work: robot_bridge: not reachable.")
    await expect(page.locator(DEAD)).to_contain_text(REMEDY)
    await page.locator(".stop").click()
    await expect(page.locator('[data-atom="stop-result"]')).to_contain_text("STOP DID NOT REACH THE ROBOT")
    await expect(page.locator('[data-atom="stop-result"]')).to_contain_text(REMEDY)
    site.world.robot.away = False
    await works_again(page, site)


async def test_while_the_bridge_does_not_know_the_pages_key_stop_is_not_struck_through_and_stops(
    page: Page, site: Site
) -> None:
    site.world.robot.knows_the_page = False
    await page.evaluate(ANSWERED, 6)
    await expect(page.locator('[data-atom="stop-place"]')).to_have_attribute("data-watch", "good")
    await page.locator(".stop").click()
    await expect(page.locator('[data-atom="stop-result"]')).to_contain_text("first zero velocity")
    site.world.robot.knows_the_page = True


async def test_a_service_that_hangs_is_dead_too_and_nothing_else_can_be_pressed_meanwhile(
    site: Site, browser: Browser
) -> None:
    proxy = Proxy(site.url)
    async with served(proxy.app()) as url, site.opened(browser, DESKTOP, at=f"{url}/") as page:
        await page.get_by_label("What to find").fill("find the cup")
        proxy.frozen = True
        assert await dead_after_ms(page) < DEAD_MS_MAX
        await expect(page.locator(DEAD)).to_contain_text("the server does not answer")
        await expect(page.locator('[data-atom="page-lost"]')).to_contain_text("only STOP can be pressed")
        assert await page.evaluate("document.getElementById('app').inert")
        proxy.frozen = False
        await expect(page.get_by_label("What to find")).to_be_focused()
        assert not await page.evaluate("document.getElementById('app').inert")
        await works_again(page, site)


async def test_a_service_that_is_gone_is_dead_too(site: Site, browser: Browser) -> None:
    await site.begin()
    page = await browser.new_page()
    async with served(Proxy(site.url).app()) as url:
        await page.goto(f"{url}/")
        await expect(page.get_by_role("status", name="Mission state")).to_have_text("Looking around")
    assert await dead_after_ms(page) < DEAD_MS_MAX
    await expect(page.locator(DEAD)).to_contain_text("the server does not answer")
    await page.close()


async def test_a_page_without_a_network_is_dead_and_comes_back(page: Page, site: Site) -> None:
    await page.context.set_offline(True)
    assert await dead_after_ms(page) < DEAD_MS_MAX
    await page.context.set_offline(False)
    await works_again(page, site)


async def test_another_app_that_answers_in_its_place_is_no_stop(page: Page) -> None:
    await page.route("**/stop*", lambda route: route.fulfill(status=200, content_type="text/html", body="Log in"))
    assert await dead_after_ms(page) < DEAD_MS_MAX
    await expect(page.locator(DEAD)).to_contain_text("another program answers at this address")
    await page.locator(".stop").click()
    await expect(page.locator('[data-atom="stop-result"]')).to_contain_text("STOP DID NOT REACH THE ROBOT")
    await page.unroute_all(behavior="wait")


async def test_with_the_pages_own_connection_lost_stop_works_and_a_resume_pressed_then_never_comes_true(
    site: Site, browser: Browser
) -> None:
    proxy = Proxy(site.url)
    async with served(proxy.app()) as url, site.opened(browser, DESKTOP, at=f"{url}/") as page:
        resume = await asked_whether_to_resume(page)
        resets, stops = len(site.world.robot.resets), len(site.world.robot.stops)
        await proxy.drop_sockets()
        await expect(page.locator('[data-atom="page-lost"]')).to_contain_text("only STOP can be pressed")
        await resume.evaluate("button => button.click()")
        await expect(page.locator(DEAD)).to_be_hidden()
        await page.keyboard.press("Escape")
        await until(lambda: len(site.world.robot.stops) == stops + 1, timeout_s=30.0)
        proxy.no_sockets = False
        await expect(page.locator('[data-atom="page-lost"]')).to_be_hidden()
        await page.get_by_label("What to find").wait_for(state="attached")
        assert len(site.world.robot.resets) == resets


async def test_a_resume_pressed_while_the_server_is_slow_never_comes_true_though_the_pages_connection_stands(
    site: Site, browser: Browser
) -> None:
    proxy = Proxy(site.url)
    async with served(proxy.app()) as url, site.opened(browser, DESKTOP, at=f"{url}/") as page:
        resume = await asked_whether_to_resume(page)
        resets = len(site.world.robot.resets)
        proxy.frozen = True
        await expect(page.locator('[data-atom="page-lost"]')).to_contain_text("only STOP can be pressed")
        assert await page.evaluate("window.socket.connected")
        await resume.evaluate("button => button.click()")
        proxy.frozen = False
        await expect(page.locator('[data-atom="page-lost"]')).to_be_hidden()
        assert len(site.world.robot.resets) == resets
        await resume.click()
        await until(lambda: len(site.world.robot.resets) == resets + 1, timeout_s=30.0)


async def test_without_any_file_of_ours_stop_works_and_what_is_missing_is_named(site: Site, browser: Browser) -> None:
    await site.begin()
    page = await browser.new_page()
    async with served(Proxy(site.url, missing=OURS).app()) as url:
        await page.goto(f"{url}/")
        missing = page.locator('[data-atom="page-missing"]')
        for name in sorted(OURS):
            await expect(missing).to_contain_text(name)
        await expect(page.locator('[data-atom="drive-switch"]')).to_be_hidden()
        stops = len(site.world.robot.stops)
        await page.locator(".stop").click()
        await page.keyboard.press("Escape")
        await until(lambda: len(site.world.robot.stops) == stops + 2, timeout_s=30.0)
        assert await page.locator(".stop").evaluate("button => getComputedStyle(button).position") == "fixed"
    await page.close()


async def test_without_the_page_frameworks_files_stop_works(site: Site, browser: Browser) -> None:
    await site.begin()
    page = await browser.new_page()
    async with served(Proxy(site.url, missing={".js"}).app()) as url:
        await page.goto(f"{url}/")
        stops = len(site.world.robot.stops)
        await page.locator(".stop").click()
        await expect(page.locator('[data-atom="stop-result"]')).to_contain_text("first zero velocity")
        assert len(site.world.robot.stops) == stops + 1
    await page.close()


@pytest.mark.parametrize(
    "scripts",
    [{"java_script_enabled": False}, {"java_script_enabled": True}],
    ids=["JavaScript is off", "the script fails"],
)
async def test_without_a_script_the_page_says_so_and_stop_is_a_form_whose_answer_says_whether_it_worked(
    site: Site, browser: Browser, scripts: dict[str, bool]
) -> None:
    await site.begin()
    context = await browser.new_context(viewport=PHONE, **scripts)  # type: ignore[arg-type]
    page = await context.new_page()
    await page.add_init_script("Object.defineProperty(window, 'atom', { value: null })")
    await page.goto(site.url)
    await expect(page.locator(DEAD)).to_contain_text("nothing monitors this STOP")
    await expect(page.locator(DEAD)).to_contain_text(REMEDY)
    await expect(page.locator(DEAD)).to_be_visible(timeout=10_000)
    stops = len(site.world.robot.stops)
    await page.locator(".stop").click()
    await expect(page.get_by_role("heading")).to_have_text("The robot is stopped.")
    assert len(site.world.robot.stops) == stops + 1
    site.world.robot.away = True
    await page.get_by_role("button", name="STOP").click()
    await expect(page.get_by_role("heading")).to_have_text("STOP DID NOT REACH THE ROBOT")
    await expect(page.get_by_text(REMEDY)).to_be_visible()
    site.world.robot.away = False
    await page.get_by_role("link", name="Back to the page").click()
    await expect(page).to_have_url(re.compile(re.escape(site.url) + "/?$"))
    await context.close()


async def test_a_page_taken_back_from_the_browsers_cache_asks_anew(page: Page, site: Site) -> None:
    site.world.robot.away = True
    await dead_after_ms(page)
    site.world.robot.away = False
    await page.evaluate("window.dispatchEvent(new PageTransitionEvent('pageshow', { persisted: true }))")
    await expect(page.locator(DEAD)).to_be_hidden()


async def test_a_hidden_page_does_not_ask_and_says_nothing_false_when_it_is_shown_again(page: Page, site: Site) -> None:
    hide = """(hidden) => {
        Object.defineProperty(document, "hidden", { get: () => hidden, configurable: true });
        document.dispatchEvent(new Event("visibilitychange"));
    }"""
    await page.evaluate(hide, True)
    await page.evaluate(UNASKED_FOR, 1500)
    seen = """() => { window.dead = 0; new MutationObserver(() => {
        if (document.querySelector('[data-atom="stop-place"]').dataset.watch === "dead") window.dead += 1;
    }).observe(document.querySelector('[data-atom="stop-place"]'), { attributes: true }); }"""
    await page.evaluate(seen)
    await page.evaluate(hide, False)
    asked = site.world.robot.asked.count("stop answers")
    await until(lambda: site.world.robot.asked.count("stop answers") >= asked + 3, timeout_s=30.0)
    assert await page.evaluate("window.dead") == 0


async def test_who_reads_the_page_aloud_is_told_and_axe_finds_nothing_serious_in_a_dead_stop(
    page: Page, site: Site
) -> None:
    site.world.robot.away = True
    await dead_after_ms(page)
    await page.locator(".stop").click()
    await expect(page.get_by_role("alert").first).to_contain_text("This STOP does not work")
    results = await Axe().run(page)
    bad = [one["id"] for one in results.response["violations"] if one["impact"] in {"serious", "critical"}]
    assert bad == []
