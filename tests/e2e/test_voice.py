"""Spoken to in real Chromium: a voice through the microphone, Whisper, the mesh, and the simulated robot acts."""

import logging
import time
import wave
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Playwright, expect, sync_playwright

from demo.mapping import tour
from sim.home import Home
from speech.sound import from_wav, to_wav
from support.browser import CHROMIUM, CHROMIUM_ARGS, DESKTOP, FAKE_MICROPHONE, Seat, seated
from support.mesh_run import MeshRun

SPEECH = True
RATE_HZ = 16_000
WAIT_MS = 60_000
BEFORE_S, BEHIND_S = 1.0, 30.0
"""Silence in the microphone before and behind what is said: Chromium plays the file from when it is opened."""

STOPPED_S_MAX = 10.0
"""From the end of the word, on a machine that is busy with the rest of the mesh as well."""

log = logging.getLogger(__name__)
pytestmark = pytest.mark.timeout(300)
expect.set_options(timeout=WAIT_MS)


@pytest.fixture(scope="module")
def playwright() -> Generator[Playwright]:
    with sync_playwright() as opened:
        yield opened


@contextmanager
def speaker(mesh: MeshRun, playwright: Playwright, words: str, folder: Path) -> Generator[Seat]:
    """Somebody before the page whose microphone says `words`, in the speech service's own voice."""
    said = mesh.post("speech", "/speak", {"text": words}).raise_for_status().content
    silence = [np.zeros(int(seconds * RATE_HZ), np.float32) for seconds in (BEFORE_S, BEHIND_S)]
    file = folder / "said.wav"
    file.write_bytes(to_wav(np.concatenate([silence[0], from_wav(said), silence[1]]), RATE_HZ))
    microphone = [*FAKE_MICROPHONE, f"--use-file-for-fake-audio-capture={file}%noloop"]
    browser = playwright.chromium.launch(executable_path=CHROMIUM, args=[*CHROMIUM_ARGS, *microphone])
    try:
        with seated(browser, mesh.url("ui", "/"), DESKTOP) as seat:
            expect(seat.page.locator('[data-atom="map"][data-fresh="true"]')).to_be_visible()
            yield seat
    finally:
        browser.close()


def ended_after_s(folder: Path) -> float:
    """How long after the microphone was opened what is said has ended."""
    with wave.open(str(folder / "said.wav")) as file:
        return file.getnframes() / file.getframerate() - BEHIND_S


def listen(seat: Seat) -> None:
    """A tap on the button: what is said ends by itself."""
    seat.page.get_by_role("button", name="Hold to speak").click()
    expect(seat.page.get_by_text("Microphone open")).to_be_visible()


@pytest.mark.timeout(900)  # the mesh starts and is toured within it
def test_a_spoken_command_makes_the_robot_find_the_red_bottle(
    mesh: MeshRun, playwright: Playwright, tmp_path: Path
) -> None:
    mesh.rested()
    tour(Home.load(mesh.stack.home), seed=mesh.stack.seed, ports=mesh.ports, on_frame=lambda _: None)
    with speaker(mesh, playwright, "Find the red bottle.", tmp_path) as seat:
        page = seat.page
        page.get_by_label("Send at once what was heard").check()
        listen(seat)
        expect(page.locator('[data-atom="heard"]')).not_to_have_text("Listening …")
        seat.picture("listening")
        expect(page.get_by_text("Looking for: red bottle", exact=True)).to_be_visible()
        assert mesh.get("coordinator", "/state")["mission"]["command"].lower().rstrip(".") == "find the red bottle"
        expect(page.get_by_role("status", name="Mission state")).to_have_text("Found", timeout=500_000)


def test_a_spoken_stop_in_mid_drive_stops_the_robot_and_it_stays_stopped(
    mesh: MeshRun, playwright: Playwright, tmp_path: Path
) -> None:
    mesh.rested()
    with speaker(mesh, playwright, "Stop!", tmp_path) as seat:
        mesh.driving("find the teddy bear")
        listen(seat)
        said_s = time.time() + ended_after_s(tmp_path)
        mesh.until(
            lambda: bool(mesh.get("robot_bridge", "/emergency-stop")["latched"]), timeout_s=60.0, what="a latched stop"
        )
        state = mesh.get("robot_bridge", "/emergency-stop")
        log.info("from the end of the word: %.2f s", state["since_s"] - said_s)
        assert state["since_s"] - said_s < STOPPED_S_MAX, "by the robot's own record"
        # it latches before what came with it is read: the reason follows
        mesh.until(
            lambda: mesh.get("robot_bridge", "/emergency-stop")["reason"].lower().startswith("said: stop"),
            timeout_s=5.0,
            what="a stop with its reason",
        )
        mesh.until(mesh.still, timeout_s=30.0, what="a robot at rest")
        mesh.stays_at_rest_for(2.0)
        expect(seat.page.get_by_text("The robot is stopped and stays stopped.")).to_be_visible()
        expect(seat.page.locator('[data-atom="heard"]')).to_contain_text("The robot was told to stop")
        assert mesh.get("coordinator", "/state")["mission"]["outcome"] is not None


def test_killing_speech_changes_nothing_else(mesh: MeshRun, playwright: Playwright, tmp_path: Path) -> None:
    mesh.rested()
    with speaker(mesh, playwright, "Find the red bottle.", tmp_path) as seat:
        mission_id = mesh.driving("find the teddy bear")
        others = {name: mesh.pid(name) for name in mesh.stack.states() if name != "speech"}
        listen(seat)
        mesh.kill("speech")
        expect(seat.page.locator('[data-atom="heard"]')).to_contain_text("The microphone is away")
        driven_m = mesh.truth()["path_length_m"]
        mesh.until(
            lambda: mesh.truth()["path_length_m"] > driven_m + 0.3, timeout_s=60.0, what="a robot that drives on"
        )
        mission = mesh.get("coordinator", f"/missions/{mission_id}")
        assert (mission["outcome"], mission["paused"]) == (None, False)
        assert {name: mesh.pid(name) for name in others} == others, "nobody else was started anew"
        seat.page.get_by_role("button", name="Emergency stop").click()
        mesh.until(mesh.still, timeout_s=30.0, what="a robot at rest: STOP needs no speech")
        mesh.until(mesh.ready, timeout_s=120.0, what="speech back by itself")
