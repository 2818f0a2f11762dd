"""Missions one after another for hours, while two people look at the page: does any process grow?

The real mesh with keys and the simulated robot. Each round asks for something else: a thing that is there, a question,
a thing that may not be there and is cancelled, a mission that is stopped in mid-drive and reset. Memory (RSS), handles
and threads of every process are noted every few seconds. Judged is the median of the last third beside that of the
second, the first being for warming up: one large picture decides nothing.
"""

import argparse
import json
import math
import os
import signal
import sys
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from statistics import median
from typing import Any, Final

import httpx

from bench.hostility.holding import Holding, complaints, holdings
from bench.hostility.mesh import GuardedMesh, guarded
from bench.processes import Processes
from bench.results import pyplot, save
from support.mesh_run import MeshRun

SAMPLE_S: Final = 5.0
TELL_S: Final = 60.0
MISSION_S_MAX: Final = 900.0
MIB_MORE_MAX: Final = 16.0
"""From the second third to the last: a page of SQLite's cache, a picture that waits."""
HANDLES_MORE_MAX: Final = 4
THREADS_MORE_MAX: Final = 2
FAULTS_MAX: Final = 10
"""Rounds that failed: then it ends, and tells what it has."""
COMMANDS: Final = ("find the red bottle", "find the blue cup", "find the teddy bear", "bring me a book")


@dataclass
class Soak:
    """What was held when, and what came of the missions."""

    began_s: float = field(default_factory=time.monotonic)
    samples: list[tuple[float, dict[str, Holding]]] = field(default_factory=list[tuple[float, dict[str, Holding]]])
    disk: list[tuple[float, int]] = field(default_factory=list[tuple[float, int]])
    ended: Counter[str] = field(default_factory=Counter[str])
    told_s: float = -math.inf

    def look(self, mesh: MeshRun) -> None:
        """Notes what is held, unless that was done just now."""
        now_s = time.monotonic() - self.began_s
        if not self.samples or now_s - self.samples[-1][0] >= SAMPLE_S:
            self.samples.append((now_s, holdings(mesh.stack)))
            self.disk.append((now_s, _disk_bytes(mesh.stack.folder)))
            if now_s - self.told_s >= TELL_S:
                self.told_s = now_s
                held = " ".join(f"{name} {one.rss_mib:.0f}/{one.handles}" for name, one in self.samples[-1][1].items())
                sys.stdout.write(f"{now_s / 60:.1f} min, {dict(self.ended)}; MiB/handles: {held}\n")
                sys.stdout.flush()


def _disk_bytes(folder: Path) -> int:
    """Of all files; one that goes while it is looked at counts nothing."""
    size = 0
    for file in folder.rglob("*"):
        try:
            size += file.stat().st_size if file.is_file() else 0
        except FileNotFoundError:
            continue
    return size


def growth(samples: Sequence[tuple[float, Mapping[str, Holding]]]) -> list[str]:
    """A sentence for each process that was started anew, or holds more in the last third than in the second.

    Raises ValueError for fewer than six samples.
    """
    if len(samples) < 6:
        raise ValueError(f"{len(samples)} samples are too few to compare")
    third = len(samples) // 3
    said = list[str]()
    for name in samples[0][1]:
        seen = [one[name] for _, one in samples if name in one]
        if len(seen) < len(samples) or len({one.pid for one in seen}) > 1:
            said.append(f"{name} ended or was started anew")
            continue
        before, after = seen[third : 2 * third], seen[-third:]
        for what, unit, more_max in (
            ("rss_mib", "MiB", MIB_MORE_MAX),
            ("handles", "handles", HANDLES_MORE_MAX),
            ("threads", "threads", THREADS_MORE_MAX),
        ):
            was, now = (median(getattr(one, what) for one in part) for part in (before, after))
            if now > was + more_max:
                said.append(f"{name} holds {now:g} {unit} after {was:g}")
    return said


def _rest(mesh: MeshRun, soak: Soak) -> None:
    mesh.post("robot_bridge", "/emergency-stop/reset").raise_for_status()
    mesh.until(lambda: _idle(mesh, soak), timeout_s=120.0, what="an idle robot")


def _idle(mesh: MeshRun, soak: Soak) -> bool:
    soak.look(mesh)
    time.sleep(0.2)
    return mesh.get("coordinator", "/state")["state"] == "IDLE"


def _looked(mesh: MeshRun, soak: Soak) -> bool:
    soak.look(mesh)
    time.sleep(1.0)
    return True


def _begin(mesh: MeshRun, command: str) -> str:
    return str(mesh.post("coordinator", "/missions", {"command": command}).raise_for_status().json()["id"])


def _followed(mesh: MeshRun, soak: Soak, mission_id: str, seconds_max: float) -> str | None:
    """Its outcome; none where it goes on after so many seconds."""
    until_s = time.monotonic() + seconds_max
    while time.monotonic() < until_s:
        soak.look(mesh)
        outcome = mesh.get("coordinator", f"/missions/{mission_id}")["outcome"]
        if outcome is not None:
            return str(outcome)
        time.sleep(0.5)
    return None


def round_of(mesh: MeshRun, soak: Soak, number: int) -> None:
    """Begins with an idle robot. Raises AssertionError when it never gets idle, or never drives."""
    _rest(mesh, soak)
    mesh.post("coordinator", "/ask", {"question": "where is the red bottle?"}).raise_for_status()
    mission_id = _begin(mesh, COMMANDS[number % len(COMMANDS)])
    if number % 4 == 3:
        mesh.until(lambda: mesh.truth()["twist"]["linear_x"] > 0.1, timeout_s=120.0, what="a driving robot")
        mesh.post("robot_bridge", "/emergency-stop").raise_for_status()
    seconds_max = MISSION_S_MAX if number % 4 == 0 else 60.0
    outcome = _followed(mesh, soak, mission_id, seconds_max)
    if outcome is None:
        asked = mesh.post("coordinator", f"/missions/{mission_id}/cancel")
        if asked.status_code != httpx.codes.CONFLICT:  # it ended by itself meanwhile
            asked.raise_for_status()
        outcome = _followed(mesh, soak, mission_id, 60.0) or "hangs"
    soak.ended[outcome] += 1


def soaked(mesh: GuardedMesh, minutes: float) -> dict[str, Any]:
    """Rounds until the time is over; `faults` is empty when everything went well."""
    soak, faults = Soak(), list[str]()
    soak.look(mesh)
    for number in count():
        if time.monotonic() - soak.began_s > minutes * 60.0:
            break
        try:
            round_of(mesh, soak, number)
        except (AssertionError, httpx.HTTPError) as error:
            faults.append(f"round {number}: {error}")
            if len(faults) == FAULTS_MAX:
                break
            mesh.until(lambda: _looked(mesh, soak) and mesh.ready(), timeout_s=300.0, what="every service ready again")
    faults += growth(soak.samples) + [f"{name}: {lines}" for name, lines in complaints(mesh.stack).items()]
    if soak.ended["hangs"]:
        faults.append(f"{soak.ended['hangs']} missions did not end when cancelled")
    return {
        "minutes": round((time.monotonic() - soak.began_s) / 60.0, 1),
        "missions": dict(soak.ended),
        "bounds": {"mib_more": MIB_MORE_MAX, "handles_more": HANDLES_MORE_MAX, "threads_more": THREADS_MORE_MAX},
        "disk_mib": [
            (round(at_s), round(size / 2**20, 2)) for at_s, size in soak.disk[:: max(1, len(soak.disk) // 60)]
        ],
        "held": {
            name: [
                (round(at_s), one[name].rss_mib, one[name].handles, one[name].threads)
                for at_s, one in soak.samples
                if name in one
            ]
            for name in soak.samples[0][1]
        },
        "faults": faults,
        "load_average": os.getloadavg(),
    }


def draw(result: Mapping[str, Any], file: Path) -> None:
    """Memory and handles over time, a line each process."""
    plt = pyplot()
    figure, (above, below) = plt.subplots(2, 1, figsize=(9, 6), sharex=True)
    for name, rows in result["held"].items():
        minutes = [at_s / 60.0 for at_s, *_ in rows]
        above.plot(minutes, [rss_mib for _, rss_mib, _, _ in rows], label=name, linewidth=1)
        below.plot(minutes, [handles for _, _, handles, _ in rows], linewidth=1)
    above.set_ylabel("memory (MiB)")
    below.set_ylabel("handles")
    below.set_xlabel("minutes")
    above.legend(ncol=4, fontsize="small")
    figure.tight_layout()
    figure.savefig(file, dpi=90)
    plt.close(figure)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=120.0)
    parser.add_argument("--seed", type=int, default=3, help="of the home")
    parser.add_argument("--port-base", type=int, default=9600)
    parser.add_argument("--out", type=Path, default=Path("out/bench/soak.json"))
    arguments = parser.parse_args()
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    with guarded(arguments.port_base, arguments.seed) as mesh, Processes({"ATOM_KEY": mesh.keys["viewer"]}) as beside:
        viewing = ["--url", mesh.ports.url("ui"), "--viewers", "2"]
        viewers = beside.python("-m", "bench.showing.viewers", *viewing)
        result = soaked(mesh, arguments.minutes)
        if viewers.poll() is not None:
            result["faults"].append("the viewers of the page ended before the missions did")
    save(arguments.out, result)
    picture = arguments.out.with_suffix(".png")
    draw(result, picture)
    shown = {key: result[key] for key in ("minutes", "missions", "faults", "load_average")}
    sys.stdout.write(json.dumps(shown, indent=1) + f"\n{arguments.out}\n{picture}\n")
    return 1 if result["faults"] else 0


if __name__ == "__main__":
    sys.exit(main())
