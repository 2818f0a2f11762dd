"""Rooms on the page in real Chromium: drawn, named by what stands there, named by a person, and looked in alone."""

import pytest
from playwright.sync_api import Page, expect, sync_playwright

from sim.home import Home
from support.browser import CHROMIUM, CHROMIUM_ARGS, PHONE, seated
from support.mesh_run import MeshRun

HIGH = {"width": 1280, "height": 900}
MARKS = {"refrigerator", "oven", "bed", "couch"}
"""What tells memory which room is which; of the bathroom nothing does."""
pytestmark = pytest.mark.timeout(300)
expect.set_options(timeout=60_000)


def remember_furniture(mesh: MeshRun) -> None:
    seen = [
        {
            "label": one.kind,
            "confidence": 0.9,
            "pose": {"x": one.x_m, "y": one.y_m, "yaw": 0.0},
            "stamp_s": mesh.simulated_s() + 0.001 * k,
            "position": {"x": one.x_m, "y": one.y_m, "z": 0.4},
        }
        for k, one in enumerate(Home.load(mesh.stack.home).furniture)
        if one.kind in MARKS
    ]
    mesh.post("memory", "/observations", {"observations": seen}).raise_for_status()


def name_on_the_map(page: Page, name: str) -> None:
    """Typed into what a click on the first name nobody gave opens."""
    page.locator(".room-name.by-nobody").first.click()
    asked = page.get_by_role("dialog", name="Name this room")
    expect(asked).to_contain_text("nobody has named it")
    asked.get_by_label("Name of the room").fill(name)
    asked.get_by_role("button", name="Name it", exact=True).click()
    expect(asked).to_be_hidden()


def test_rooms_are_drawn_and_named_and_a_search_keeps_to_one(mesh: MeshRun) -> None:
    mesh.rested()
    remember_furniture(mesh)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=CHROMIUM_ARGS)
        with seated(browser, mesh.url("ui", "/"), HIGH) as seat:
            page = seat.page
            expect(page.locator('[data-atom="map"]:not([data-rooms="0"])')).to_be_visible()
            expect(page.locator(".room-name", has_text="kitchen?")).to_have_count(1)
            expect(page.locator(".room-name.by-nobody").first).to_contain_text("unnamed room")
            name_on_the_map(page, "Anna's room")
            expect(page.locator(".room-name.by-person")).to_have_text("Anna's room")
            expect(page.get_by_text("It is called Anna's room now.")).to_be_visible()
            expect(page.locator('[data-atom="stop-place"][data-watch="good"]')).to_be_attached()
            seat.picture("rooms", of=page.get_by_role("region", name="Map"))
            begun = mesh.post("coordinator", "/missions", {"command": "find the umbrella in the kitchen"}).json()
            assert [one["name"] for one in begun["rooms"]] == ["kitchen"]
            kitchen = next(one for one in Home.load(mesh.stack.home).rooms if one.name == "kitchen")

            def goes_there() -> bool:
                points = mesh.get("coordinator", "/state")["scan_points"]
                return bool(points) and all(kitchen.contains(one["x"], one["y"]) for one in points)

            mesh.until(goes_there, timeout_s=60.0, what="a plan in the kitchen alone")
            mesh.post("coordinator", f"/missions/{begun['id']}/cancel").raise_for_status()
            page.locator(".room-name.by-person").click()
            page.get_by_role("button", name="Take the name away").click()
            expect(page.locator(".room-name.by-person")).to_have_count(0)
            page.get_by_role("tab", name="Memory").click()
            page.get_by_label("Search the memory").fill("kitchen")
            expect(
                page.get_by_role("list", name="Remembered things").get_by_text("room: kitchen").first
            ).to_be_visible()
            expect(page.get_by_role("list", name="Remembered things").get_by_text("bed", exact=True)).to_have_count(0)
        with seated(browser, mesh.url("ui", "/"), PHONE, dark=True) as seat:
            expect(seat.page.locator(".room-name", has_text="kitchen?")).to_be_visible()
        browser.close()
