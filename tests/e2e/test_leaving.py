"""Ctrl-C leaves no process behind."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from demo.stack import SERVICES, Ports, Stack
from support.mesh_run import MeshRun

PORT_BASE = 18600


def alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


@pytest.mark.timeout(300)
def test_ctrl_c_in_the_middle_of_a_mission_ends_every_process(tmp_path: Path) -> None:
    stack = Stack(Ports(PORT_BASE), tmp_path / "out/demo" / str(PORT_BASE), Path(), 0)
    demo = subprocess.Popen(
        [sys.executable, "-m", "demo", "run", "--no-tour", "--port-base", str(PORT_BASE)],
        cwd=tmp_path,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        with MeshRun(stack) as mesh:
            mesh.until(
                lambda: mesh.get("coordinator", "/state")["mission"] is not None, timeout_s=120.0, what="a mission"
            )
            pids = {name: stack.pid(name) for name in ("redis", "sim", *SERVICES)}
        assert all(alive(pid) for pid in pids.values())
        demo.send_signal(signal.SIGINT)
        demo.wait(timeout=60)
    finally:
        demo.kill()
        demo.wait()
        stack.stop()
    assert [name for name, pid in pids.items() if alive(pid)] == []
