"""The whole mesh with its simulated robot, keys, and Redis with its rules: to be rude to, or to live in."""

import contextlib
import re
import secrets
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

from demo.ready import wait_until_ready
from demo.stack import Ports, Stack
from sim.home import Home, Wanted
from support.mesh_run import MeshRun

START_S_MAX: Final = 420.0
ROLES: Final = ("viewer", "operator", "service", "admin")
SHOWN: Final = re.compile(r"shown this once: (\S+)")


class GuardedMesh(MeshRun):
    """Asks with an admin's key; `keys` has one for each role, and a wrong one."""

    def __init__(self, stack: Stack, keys: dict[str, str]) -> None:
        super().__init__(stack)
        self.keys = keys
        self.http.headers["Authorization"] = f"Bearer {keys['admin']}"

    def moves_and_stops(self) -> dict[str, Any]:
        """Drives on a lease until ground truth says so, stops, and sees it at rest. Raises AssertionError."""
        self.post("robot_bridge", "/emergency-stop/reset").raise_for_status()

        def turns() -> bool:
            epoch = self.get("robot_bridge", "/emergency-stop")["epoch"]
            lease = {"twist": {"angular_z": 0.6}, "source": "bench", "epoch": epoch, "duration_s": 1.0, "priority": 3}
            self.post("robot_bridge", "/velocity", lease)
            return abs(self.truth()["twist"]["angular_z"]) > 0.1

        began_s = time.monotonic()
        self.until(turns, timeout_s=60.0, what="a turning robot")
        moved_s = time.monotonic() - began_s
        self.post("robot_bridge", "/emergency-stop").raise_for_status()
        self.until(self.still, timeout_s=20.0, what="a robot at rest")
        self.post("robot_bridge", "/emergency-stop/reset").raise_for_status()
        return {"moved_after_s": round(moved_s, 2), "stopped": True}


@contextlib.contextmanager
def guarded(port_base: int, seed: int, *, speech: bool = False) -> Iterator[GuardedMesh]:
    """Yields once everything is ready; ends it by its own supervisor."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        keys = {role: _key(folder / "keys", role) for role in ROLES} | {"wrong": secrets.token_urlsafe(32)}
        _make(folder / "keys", "--services")
        stack = Stack(Ports(port_base), folder, folder / "home.json", seed, folder / "keys", speech=speech)
        Home.generate(seed, wanted=Wanted("bottle", "red")).save(stack.home)
        process = stack.start()
        try:
            wait_until_ready(
                stack, timeout_s=START_S_MAX, on_ready=lambda *_: None, alive=lambda: process.poll() is None
            )
            with GuardedMesh(stack, keys) as mesh:
                yield mesh
        finally:
            stack.stop(process)


def _make(folder: Path, *arguments: str) -> str:
    command = [sys.executable, "-m", "atom_cli", "keys", "make", *arguments, "--folder", str(folder)]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def _key(folder: Path, role: str) -> str:
    (key,) = SHOWN.findall(_make(folder, f"bench-{role}", "--role", role))
    return key
