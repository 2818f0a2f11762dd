"""The operator's page in real Chromium, against the running mesh with the simulated robot."""

import logging
import os
import signal
import time
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, expect, sync_playwright

from demo.mapping import tour
from sim.home import Home
from support.browser import CHROMIUM, CHROMIUM_ARGS, DESKTOP, PHONE, Seat, seated
from support.mesh_run import MeshRun

REST_WITHIN_S = 0.5
WAIT_MS = 60_000

log = logging.getLogger(__name__)
pytestmark = pytest.mark.timeout(300)
expect.set_options(timeout=WAIT_MS)


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        opened = playwright.chromium.launch(executable_path=CHROMIUM, args=CHROMIUM_ARGS)
        yield opened
        opened.close()


@pytest.fixture
def seat(mesh: MeshRun, browser: Browser) -> Iterator[Seat]:
    """A desktop's page, connected, before a robot at rest."""
    mesh.rested()
    with seated(browser, mesh.url("ui", "/"), DESKTOP) as opened:
        connected(opened.page)
        yield opened


def connected(page: Page) -> None:
    expect(page.locator('[data-atom="map"][data-fresh="true"]')).to_be_visible()
    expect(page.locator('[data-atom="live"][data-old="false"]')).to_be_visible()


def find(page: Page, command: str = "find the red bottle") -> None:
    page.get_by_label("What to find").fill(command)
    page.keyboard.press("Enter")


def drives(mesh: MeshRun) -> None:
    mesh.until(lambda: mesh.truth()["twist"]["linear_x"] > 0.15, timeout_s=90.0, what="a driving robot")


def last_motion_s(mesh: MeshRun) -> float:
    """Simulated time of the robot's last motion before it stood with the stop latched, as the simulation kept it."""

    def stands() -> bool:
        return bool(mesh.get("robot_bridge", "/emergency-stop")["latched"]) and mesh.still()

    mesh.until(stands, timeout_s=60.0, what="a robot at rest with the stop latched")
    return float(mesh.truth()["moved_at_s"])


def frames(page: Page) -> int:
    return int(page.locator('[data-atom="live"]').get_attribute("data-frames") or 0)


def more_frames(page: Page, count: int = 3) -> None:
    before = frames(page)
    page.wait_for_function(
        "least => Number(document.querySelector('[data-atom=live]').dataset.frames) >= least",
        arg=before + count,
        timeout=WAIT_MS,
    )


def test_a_mission_is_typed_watched_paused_and_taken_up_again(mesh: MeshRun, seat: Seat) -> None:
    page = seat.page
    find(page)
    expect(page.get_by_text("Looking for: red bottle", exact=True)).to_be_visible()
    drives(mesh)
    more_frames(page)
    expect(page.locator('[data-atom="map"]:not([data-laser="0"])')).to_be_visible()
    expect(page.get_by_role("log").locator("li").first).to_be_visible()
    seat.picture("mission")
    page.get_by_role("button", name="Pause the mission").click()
    expect(page.get_by_role("status", name="Mission state")).to_have_text("Paused")
    mesh.until(mesh.still, timeout_s=30.0, what="a paused robot at rest")
    page.get_by_role("button", name="Continue the mission").click()
    expect(page.get_by_role("status", name="Mission state")).not_to_have_text("Paused")
    page.get_by_role("log").locator("button").first.click()
    expect(page.get_by_alt_text("What the camera saw then")).to_be_visible()
    page.get_by_role("button", name="Cancel the mission").click()
    expect(page.get_by_role("status", name="Mission state")).to_have_text("Cancelled")
    page.get_by_role("tab", name="Missions").click()
    page.get_by_role("button", name="Open the timeline of find the red bottle").first.click()
    expect(page.get_by_role("button", name="Back to now")).to_be_visible()


def test_stop_in_mid_drive_brings_the_robot_to_rest_and_resume_only_permits(mesh: MeshRun, seat: Seat) -> None:
    page = seat.page
    find(page)
    drives(mesh)
    pressed_sim_s, pressed_s = mesh.simulated_s(), time.time()
    page.get_by_role("button", name="Emergency stop").click()
    moved_sim_s = last_motion_s(mesh)
    reached_s = mesh.get("robot_bridge", "/emergency-stop")["since_s"] - pressed_s
    log.info("press to bridge %.3f s, press to the last motion %.2f s", reached_s, moved_sim_s - pressed_sim_s)
    assert moved_sim_s - pressed_sim_s - reached_s <= REST_WITHIN_S
    expect(page.get_by_text("The robot is stopped and stays stopped.")).to_be_visible()
    expect(page.get_by_text("at rest after")).to_be_visible()
    expect(page.get_by_role("status", name="Mission state")).to_have_text("Stopped")
    seat.picture("stopped")
    mesh.stays_at_rest_for(1.0)
    page.get_by_role("button", name="Resume after the emergency stop").click()
    page.get_by_role("button", name="Resume", exact=True).click()
    expect(page.get_by_text("The robot is stopped and stays stopped.")).to_be_hidden()
    mesh.stays_at_rest_for(2.0)


def test_a_remembered_thing_is_forgotten_after_a_question(mesh: MeshRun, seat: Seat) -> None:
    page = seat.page
    pose = mesh.get("robot_bridge", "/state")["pose"]
    place = {"x": pose["x"] + 1.0, "y": pose["y"], "z": 0.4}
    sighting = {"label": "zebra", "confidence": 0.9, "pose": pose, "stamp_s": time.time(), "position": place}
    mesh.post("memory", "/observations", {"observations": [sighting]}).raise_for_status()
    page.get_by_role("tab", name="Memory").click()
    page.get_by_label("Search the memory").fill("zebra")
    things = page.get_by_role("list", name="Remembered things")
    expect(things).to_contain_text("zebra")
    things.get_by_role("button", name="Forget zebra").click()
    page.get_by_role("button", name="Keep").click()
    expect(page.get_by_role("button", name="Keep")).to_be_hidden()
    things.get_by_role("button", name="Forget zebra").click()
    page.get_by_role("button", name="Forget", exact=True).last.click()
    expect(things).not_to_contain_text("zebra")
    assert mesh.get("memory", "/objects?label=zebra") == []


def turning(mesh: MeshRun) -> None:
    mesh.until(lambda: abs(mesh.truth()["twist"]["angular_z"]) > 0.2, timeout_s=30.0, what="a turning robot")


def test_the_robot_is_driven_by_keys_and_by_the_stick_and_rests_when_let_go(mesh: MeshRun, seat: Seat) -> None:
    page = seat.page
    page.get_by_role("button", name="Drive by hand").click()
    page.keyboard.down("a")
    turning(mesh)
    page.keyboard.up("a")
    mesh.until(mesh.still, timeout_s=30.0, what="rest after the key was let go")
    stick = page.locator('[data-atom="stick"]').bounding_box()
    assert stick is not None
    middle = (stick["x"] + stick["width"] / 2, stick["y"] + stick["height"] / 2)
    page.mouse.move(*middle)
    page.mouse.down()
    page.mouse.move(middle[0] - 60, middle[1])
    turning(mesh)
    seat.picture("driving")
    page.mouse.up()
    mesh.until(mesh.still, timeout_s=30.0, what="rest after the stick was let go")
    mesh.stays_at_rest_for(1.0)


def test_a_page_that_is_gone_while_it_drives_lets_go(mesh: MeshRun, browser: Browser) -> None:
    mesh.rested()
    with seated(browser, mesh.url("ui", "/"), DESKTOP) as seat:
        connected(seat.page)
        seat.page.get_by_role("button", name="Drive by hand").click()
        seat.page.keyboard.down("d")
        turning(mesh)
    mesh.until(mesh.still, timeout_s=30.0, what="rest after the page was closed")
    mesh.stays_at_rest_for(1.0)


def test_a_service_that_hangs_and_is_killed_is_named_and_recovers_by_itself(mesh: MeshRun, seat: Seat) -> None:
    away = seat.page.locator(".away")
    seat.page.get_by_role("tab", name="Robot").click()
    os.kill(mesh.pid("memory"), signal.SIGSTOP)
    try:
        expect(away).to_contain_text("memory")
        seat.picture("service-away")
    finally:
        mesh.kill("memory")
    expect(away).not_to_contain_text("memory")
    mesh.until(mesh.ready, timeout_s=240.0, what="the mesh ready again")


def test_two_people_see_the_same_robot_and_either_may_stop_it(mesh: MeshRun, seat: Seat, browser: Browser) -> None:
    with seated(browser, mesh.url("ui", "/"), DESKTOP, dark=True) as other:
        connected(other.page)
        find(seat.page)
        expect(other.page.get_by_text("“find the red bottle”").first).to_be_visible()
        more_frames(seat.page)
        more_frames(other.page)
        other.picture("dark")
        other.page.keyboard.press("Escape")
        expect(seat.page.get_by_text("The robot was stopped: Esc pressed on the page")).to_be_visible()
        for page in (seat.page, other.page):
            expect(page.get_by_text("The robot is stopped and stays stopped.")).to_be_visible()
        expect(seat.page.get_by_text("emergency stop: Esc pressed on the page").first).to_be_visible()


@pytest.mark.timeout(600)
def test_a_typed_mission_ends_with_a_find_and_what_it_rests_on(mesh: MeshRun, seat: Seat) -> None:
    tour(Home.load(mesh.stack.home), seed=mesh.stack.seed, ports=mesh.ports, on_frame=lambda _: None)
    page = seat.page
    find(page)
    expect(page.get_by_role("status", name="Mission state")).to_have_text("Found", timeout=500_000)
    expect(page.get_by_role("log").locator("li").filter(has_text="found the red bottle").first).to_be_visible()
    expect(page.get_by_text("Looking for: red bottle", exact=True)).to_be_hidden()
    expect(page.get_by_role("log").locator("li").filter(has_text="confirmed: detector yes").first).to_be_visible()
    more_frames(page)
    seat.picture("found")
    page.get_by_role("tab", name="Missions").click()
    expect(page.get_by_role("list", name="Missions, newest first")).to_contain_text("Found")
    seat.picture("history")
    page.get_by_label("What to find").fill("where did you last see the red bottle?")
    page.keyboard.press("Enter")
    expect(page.locator(".command .answer.good")).to_contain_text("I saw a red bottle")
    seat.picture("asked")
    page.get_by_role("tab", name="Memory").click()
    expect(page.get_by_role("list", name="Remembered things").locator("li").first).to_be_visible()
    seat.picture("memory")


def test_on_a_phone_the_page_is_one_column_with_stop_always_on_screen(mesh: MeshRun, browser: Browser) -> None:
    mesh.rested()
    with seated(browser, mesh.url("ui", "/"), PHONE) as seat:
        page = seat.page
        connected(page)
        find(page, "find the teddy bear")  # not the bottle: before that it may stand, and would have found it at once
        expect(page.get_by_text("Looking for: teddy bear", exact=True)).to_be_visible()
        expect(page.get_by_role("button", name="Cancel the mission")).to_be_enabled()
        more_frames(page)
        seat.picture("phone")
        assert page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]
        page.get_by_role("tab", name="Robot").click()
        page.get_by_text("Sensors").scroll_into_view_if_needed()
        expect(page.get_by_role("button", name="Emergency stop")).to_be_in_viewport(ratio=1.0)
        page.get_by_role("button", name="Emergency stop").tap()
        expect(page.get_by_text("The robot is stopped and stays stopped.")).to_be_attached()
        mesh.until(mesh.still, timeout_s=30.0, what="a robot at rest")
