"""The layer of what the search holds probable: a switch brings it, and takes it away."""

import pytest
from axe_playwright_python.async_playwright import Axe
from playwright.async_api import Page, expect

from contracts.belief import NoBelief
from support.ui_world import search_belief

from .conftest import Site

pytestmark = [pytest.mark.asyncio(loop_scope="module"), pytest.mark.timeout(240)]

SWITCH = "Where it may be"
LAYER, NO_LAYER = '[data-atom="map"][data-belief="true"]', '[data-atom="map"][data-belief="false"]'
IN_THE_CORNER, OUTSIDE = (1.875, -2.25), (-4.4, -3.7)
"""m, in map: where the fake's belief has its peak, and beyond its walls."""
SERIOUS = {"serious", "critical"}

INK_AT = """([x, y]) => {
    const canvas = document.querySelector('[data-atom="map"]');
    const [left, top] = [-4.5 + 11 * 0.05, 3.75 - 11 * 0.05];  // the picture begins 4 cells before what is known
    const across = Math.round(((x - left) / 0.05) * 4);
    const down = Math.round(((top - y) / 0.05) * 4);
    return Array.from(canvas.getContext("2d").getImageData(across, down, 1, 1).data);
}"""


async def ink_at(page: Page, place: tuple[float, float]) -> tuple[int, int, int, int]:
    """Red, green, blue and alpha of the canvas over a place of the map."""
    red, green, blue, alpha = await page.evaluate(INK_AT, list(place))
    return red, green, blue, alpha


async def test_the_layer_appears_with_its_words_and_disappears(page: Page, site: Site) -> None:
    site.world.missions.believed = search_belief(site.mission_id)
    words = page.locator('[data-atom="belief-words"]')
    await expect(page.locator(NO_LAYER)).to_be_visible()
    await expect(words).to_be_hidden()
    bare = await ink_at(page, IN_THE_CORNER)
    await page.get_by_role("button", name=SWITCH).click()
    await expect(page.locator(LAYER)).to_be_visible()
    await expect(page.get_by_role("button", name=SWITCH)).to_have_attribute("aria-pressed", "true")
    await expect(words).to_contain_text("Not here: 20 %")
    await expect(words).to_contain_text("2.5 % in 15 cm")
    await expect(words.get_by_role("status")).to_have_text(search_belief().why)
    red, green, blue, alpha = await ink_at(page, IN_THE_CORNER)
    assert (bare[3], alpha > 200, red > blue > green) == (0, True, True)
    assert (await ink_at(page, OUTSIDE))[3] == 0
    await page.get_by_role("button", name=SWITCH).click()
    await expect(page.locator(NO_LAYER)).to_be_visible()
    await expect(words).to_be_hidden()
    assert await ink_at(page, IN_THE_CORNER) == bare


async def test_what_the_next_look_changes_is_drawn_and_when_the_mission_ends_it_goes(page: Page, site: Site) -> None:
    site.world.missions.believed = search_belief(site.mission_id)
    words = page.locator('[data-atom="belief-words"]')
    await page.get_by_role("button", name=SWITCH).click()
    await expect(words).to_contain_text("Not here: 20 %")
    site.world.missions.believed = search_belief(site.mission_id, absent=0.35, why="3 looks here: 9% to see it, in 4 s")
    await expect(words).to_contain_text("Not here: 35 %")
    await expect(words.get_by_role("status")).to_have_text("3 looks here: 9% to see it, in 4 s")
    site.world.missions.believed = NoBelief.ENDED
    await site.mission_is(outcome="not_found")
    await expect(page.locator(NO_LAYER)).to_be_visible()
    await expect(words.get_by_role("status")).to_have_text("The mission is over.")
    await expect(words).not_to_contain_text("Not here")


async def test_it_is_still_shown_when_the_page_has_loaded_itself_anew(page: Page, site: Site) -> None:
    site.world.missions.believed = search_belief(site.mission_id)
    await page.get_by_role("button", name=SWITCH).click()
    await expect(page.locator(LAYER)).to_be_visible()
    await page.reload()
    await expect(page.locator(LAYER)).to_be_visible()
    await expect(page.get_by_role("button", name=SWITCH)).to_have_attribute("aria-pressed", "true")
    await expect(page.locator('[data-atom="belief-words"]')).to_contain_text("Not here: 20 %")


async def test_a_mission_by_another_rule_says_so(page: Page, site: Site) -> None:
    site.world.missions.believed = NoBelief.ANOTHER_RULE
    await page.get_by_role("button", name=SWITCH).click()
    words = page.locator('[data-atom="belief-words"]')
    await expect(words.get_by_role("status")).to_have_text("This mission does not search by probability.")
    await expect(page.locator(NO_LAYER)).to_be_visible()


async def test_everybody_can_use_it(page: Page, site: Site) -> None:
    site.world.missions.believed = search_belief(site.mission_id)
    await page.get_by_role("button", name=SWITCH).click()
    await expect(page.locator(LAYER)).to_be_visible()
    results = await Axe().run(page)
    assert [one["id"] for one in results.response["violations"] if one["impact"] in SERIOUS] == []
