"""What a search holds probable, on the page in real Chromium, while the simulated robot searches by it."""

import pytest
from playwright.sync_api import expect, sync_playwright

from support.browser import CHROMIUM, CHROMIUM_ARGS, seated
from support.mesh_run import MeshRun

SETTINGS = {"COORDINATOR_COVERAGE_RULE": "belief"}
COMMAND = "find the umbrella"  # this home has none: it searches
HIGH = {"width": 1280, "height": 900}  # the words below the map are in the picture
pytestmark = pytest.mark.timeout(600)
expect.set_options(timeout=60_000)


def test_the_layer_follows_the_search_and_says_where_the_robot_looks_next(mesh: MeshRun) -> None:
    mesh.rested()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=CHROMIUM_ARGS)
        with seated(browser, mesh.url("ui", "/"), HIGH) as seat:
            page = seat.page
            expect(page.locator('[data-atom="map"][data-fresh="true"]')).to_be_visible()
            page.get_by_role("button", name="Where it may be").click()
            words = page.locator('[data-atom="belief-words"]')
            expect(words.get_by_role("status")).to_have_text("No mission is under way.")
            mission = mesh.post("coordinator", "/missions", {"command": COMMAND}).raise_for_status().json()
            expect(page.locator('[data-atom="map"][data-belief="true"]')).to_be_visible()
            first = mesh.get("coordinator", f"/missions/{mission['id']}/belief")

            def has_looked() -> bool:
                return bool(
                    mesh.get("coordinator", f"/missions/{mission['id']}/belief")["absent"] > first["absent"] + 0.05
                )

            mesh.until(has_looked, timeout_s=180.0, what="looks in vain")
            now = mesh.get("coordinator", f"/missions/{mission['id']}/belief")
            expect(words.get_by_role("status")).to_contain_text("that it is here")
            expect(words).not_to_contain_text(f"Not here: {first['absent']:.0%}".replace("%", " %"))
            assert now["view"] is not None
            expect(page.locator('[data-atom="stop-place"][data-watch="good"]')).to_be_attached()
            seat.picture("belief", of=page.get_by_role("region", name="Map"))
            mesh.post("coordinator", f"/missions/{mission['id']}/cancel").raise_for_status()
            expect(words.get_by_role("status")).to_have_text("The mission is over.")
            expect(page.locator('[data-atom="map"][data-belief="false"]')).to_be_visible()
        browser.close()
