"""Processes that a benchmark starts beside itself, and how they end."""

import contextlib
import os
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import psutil

from demo.stack import redis_server

ROOT = Path(__file__).resolve().parents[1]
END_S_MAX = 20.0


class Processes:
    """For as long as the block lasts; the last started is the first that is asked to end, and killed if it will not."""

    def __init__(self, environment: Mapping[str, str]) -> None:
        """`environment` is added to this process's own."""
        self._environment = os.environ | environment
        self._started: list[subprocess.Popen[Any]] = []

    def python(self, *arguments: str, **options: Any) -> "subprocess.Popen[Any]":
        """`python ARGUMENTS`; `options` are Popen's."""
        return self._start([sys.executable, *arguments], self._environment, **options)

    def redis(self, port: int) -> str:
        """Its URL; it keeps nothing on disk, and may not be listening yet."""
        command = [redis_server(), "--port", str(port), "--bind", "127.0.0.1", "--save", ""]
        plain = {key: value for key, value in self._environment.items() if key != "LD_LIBRARY_PATH"}
        self._start(command, plain, stdout=subprocess.DEVNULL)
        return f"redis://127.0.0.1:{port}/0"

    def _start(self, command: list[str], environment: Mapping[str, str], **options: Any) -> "subprocess.Popen[Any]":
        process = subprocess.Popen(command, env=environment, cwd=ROOT, **options)
        self._started.append(process)
        return process

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for process in reversed(self._started):
            process.terminate()
        for process in self._started:
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(END_S_MAX)
            process.kill()
            process.wait()


def bridge_environment(folder: Path, *, port: int, redis_port: int, domain: int) -> dict[str, str]:
    """Of robot_bridge and the ROS processes beside it; what they write stands in `folder`."""
    return {
        "ROS_DOMAIN_ID": str(domain),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_LOG_DIR": str(folder / "ros"),
        "ROBOT_BRIDGE_PORT": str(port),
        "ROBOT_BRIDGE_REDIS_URL": f"redis://127.0.0.1:{redis_port}/0",
        "ROBOT_BRIDGE_STATE_DIR": str(folder / "state"),
        "PYTHONUNBUFFERED": "1",
        "OMP_NUM_THREADS": "1",
    }


def cpu_s(process: "subprocess.Popen[Any]") -> float:
    """Seconds of processor time it has used so far."""
    times = psutil.Process(process.pid).cpu_times()
    return times.user + times.system


def until(condition: Callable[[], bool], what: str, *, timeout_s: float) -> None:
    """Returns as soon as the condition holds. Raises `TimeoutError` naming `what`."""
    deadline_s = time.monotonic() + timeout_s
    while not condition():
        if time.monotonic() > deadline_s:
            raise TimeoutError(f"no {what} within {timeout_s:g} s")
        time.sleep(0.05)
