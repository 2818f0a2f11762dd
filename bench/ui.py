"""The operator's page: a frame's way to the screen, what a viewer costs, and how soon the page can be used.

A ROS process publishes numbered frames; robot_bridge, ui and Redis run as they do in the mesh; Chromium shows the page
and a script reads the number back out of the canvas's pixels. Both ends read this machine's wall clock. CPU is that of
the ui process, with viewers without a screen that speak to it as the page's scripts do.
"""

import argparse
import contextlib
import json
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import httpx
import numpy as np
from playwright.sync_api import Page, Request, sync_playwright

from bench.processes import Processes, bridge_environment, cpu_s, until
from bench.results import pyplot, save

START_S_MAX = 90.0
CHROMIUM = "/usr/bin/chromium"
ARGUMENTS = ["--no-sandbox", "--disable-gpu", "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1"]
READ_NUMBER = """
window.shown = [];
document.addEventListener('atom-frame', () => {
  const canvas = document.querySelector('[data-atom=live]');
  const side = canvas.width / 250 * 15;
  const pixels = canvas.getContext('2d').getImageData(0, Math.round(side / 2), canvas.width, 1).data;
  let number = 0;
  for (let bit = 0; bit < 16; bit++) {
    if (pixels[4 * Math.round((bit + 0.5) * side)] > 127) number |= 1 << bit;
  }
  window.shown.push([number, Date.now()]);
});
"""


class Camera:
    """The publishing process, and when it published which frame (ms since the epoch)."""

    def __init__(self, process: "subprocess.Popen[str]") -> None:
        self.published_ms: dict[int, float] = {}
        self._process = process
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            number, at_ms = line.split()
            self.published_ms[int(number)] = float(at_ms)


@dataclass(frozen=True)
class Rig:
    """Redis, a bridge, the numbered camera and the ui, each a process of its own."""

    url: str
    processes: Processes
    camera: Camera
    ui: "subprocess.Popen[bytes]"


@contextlib.contextmanager
def rigged(folder: Path, port: int, domain: int, camera_hz: float) -> Iterator[Rig]:
    """Yields once a frame has come through the bridge and the page is served. Raises `TimeoutError`."""
    bridge_url, url = f"http://127.0.0.1:{port + 4}", f"http://127.0.0.1:{port + 80}"
    environment = bridge_environment(folder, port=port + 4, redis_port=port + 5, domain=domain)
    environment |= {"UI_PORT": str(port + 80), "UI_ROBOT_BRIDGE_URL": bridge_url}
    environment["UI_REDIS_URL"] = environment["ROBOT_BRIDGE_REDIS_URL"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    with Processes(environment) as processes, httpx.Client(trust_env=False, timeout=5.0) as http:
        processes.redis(port + 5)
        processes.python("-m", "robot_bridge", **quiet)
        publishing = ("-m", "bench.showing.camera", "--camera-hz", str(camera_hz))
        camera = Camera(processes.python(*publishing, stdout=subprocess.PIPE, text=True))
        ui = processes.python("-m", "ui", **quiet)
        for there in (f"{bridge_url}/camera/frame", f"{url}/health"):
            until(lambda there=there: _answers(http, there), f"answer from {there}", timeout_s=START_S_MAX)
        yield Rig(url, processes, camera, ui)


def _answers(http: httpx.Client, url: str) -> bool:
    with contextlib.suppress(httpx.HTTPError):
        return http.get(url).is_success
    return False


@contextlib.contextmanager
def opened(url: str, outside: list[str]) -> Iterator[Page]:
    """The page in Chromium; requests elsewhere find no way and are counted."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        context = browser.new_context(viewport={"width": 1280, "height": 800})

        context.add_init_script(READ_NUMBER)
        page = context.new_page()

        def count(request: Request) -> None:
            if not request.url.startswith((url, "blob:", "data:")):
                outside.append(request.url)

        page.on("request", count)
        yield page
        browser.close()


def look(rig: Rig, seconds: float) -> tuple[list[float], float, float, list[str]]:
    """Latencies (ms), seconds to the first usable page, its weight (bytes over the wire), requests elsewhere."""
    outside: list[str] = []
    with opened(rig.url, outside) as page:
        began_s = time.monotonic()
        page.goto(rig.url, timeout=60_000)
        page.get_by_role("button", name="Find").wait_for()
        page.wait_for_function("window.shown.length > 0 && window.socket && window.socket.connected", timeout=60_000)
        interactive_s = time.monotonic() - began_s
        weight = page.evaluate(
            "[...performance.getEntriesByType('resource'), ...performance.getEntriesByType('navigation')]"
            ".reduce((sum, one) => sum + one.transferSize, 0)"
        )
        time.sleep(2.0)
        page.evaluate("window.shown = []")
        time.sleep(seconds)
        shown: list[list[float]] = page.evaluate("window.shown")
    published = rig.camera.published_ms
    latencies = [at_ms - published[int(number)] for number, at_ms in shown if int(number) in published]
    say(f"{len(shown)} frames shown in {seconds:.0f} s, {len(shown) - len(latencies)} could not be read back")
    return latencies, interactive_s, weight, outside


def cpu_percent(rig: Rig, viewers: int, seconds: float) -> tuple[float, float]:
    """Of one core, by the ui process; and the frames a second each viewer got."""
    arguments = ("-m", "bench.showing.viewers", "--url", rig.url, "--viewers", str(viewers))
    watching = rig.processes.python(*arguments, stdout=subprocess.PIPE, text=True)
    assert watching.stdout is not None
    watching.stdout.readline()
    time.sleep(3.0)
    began_s, spent_s = time.monotonic(), cpu_s(rig.ui)
    time.sleep(seconds)
    percent = 100.0 * (cpu_s(rig.ui) - spent_s) / (time.monotonic() - began_s)
    watching.terminate()
    output, _ = watching.communicate(timeout=30.0)
    return percent, float(output.split()[-1])


def plot(latencies: list[float], cpu: dict[str, float], path: Path) -> None:
    plt = pyplot()
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4), layout="constrained")
    left.hist(latencies, bins=40)
    left.axvline(250.0, color="grey", linewidth=0.8)
    left.set(xlabel="published to drawn, ms (aim: p95 at 250)", ylabel="frames")
    right.plot([int(viewers) for viewers in cpu], list(cpu.values()), marker="o")
    right.set(xlabel="viewers", ylabel="CPU of ui, % of one core", ylim=(0, None))
    figure.savefig(path, dpi=110)


def say(text: str) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=30.0, help="each measurement")
    parser.add_argument("--camera-hz", type=float, default=10.0)
    parser.add_argument("--viewers", type=int, nargs="+", default=[1, 5, 20])
    parser.add_argument("--port", type=int, default=18900, help="base of the ports")
    parser.add_argument("--domain", type=int, default=89, help="ROS_DOMAIN_ID")
    parser.add_argument("--out", type=Path, default=Path("out/bench"))
    parser.add_argument("--quick", action="store_true", help="5 s each: does it run?")
    arguments = parser.parse_args()
    seconds = 5.0 if arguments.quick else arguments.seconds
    with (
        tempfile.TemporaryDirectory() as folder,
        rigged(Path(folder), arguments.port, arguments.domain, arguments.camera_hz) as rig,
    ):
        latencies, interactive_s, weight, outside = look(rig, seconds)
        cpu: dict[str, float] = {}
        for viewers in arguments.viewers:
            percent, fps = cpu_percent(rig, viewers, seconds)
            cpu[str(viewers)] = round(percent, 1)
            say(f"{viewers:3d} viewers: {percent:5.1f} % of a core, {fps:.1f} frames/s each")
    p50, p95 = np.percentile(latencies, [50, 95])
    report = {
        "frame_latency_p50_ms": round(float(p50), 1),
        "frame_latency_p95_ms": round(float(p95), 1),
        "cpu_percent_by_viewers": cpu,
        "outside_requests": len(outside),
        "interactive_s": round(interactive_s, 2),
    }
    save(arguments.out / "ui.json", report)
    plot(latencies, cpu, arguments.out / "ui.png")
    say(json.dumps(report, indent=2))
    say(f"page weight {weight / 1e6:.2f} MB over the wire, nothing cached")


if __name__ == "__main__":
    main()
