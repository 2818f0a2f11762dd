"""Runs child processes in an environment of their own and keeps what they say."""

import os
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path

from interface_wheels.errors import CommandFailedError

TAIL_LINES = 40
# A sourced or bootstrapped ROS leaks these: compilers and CMake would pick up the wrong libraries.
LEAKING = (
    "AMENT_PREFIX_PATH",
    "CMAKE_PREFIX_PATH",
    "COLCON_PREFIX_PATH",
    "LD_LIBRARY_PATH",
    "PYTHONHOME",
    "PYTHONPATH",
    "VIRTUAL_ENV",
    "_ROS_WHEELS_BOOTSTRAP_COMPLETE",
)


def clean_environment(extra: Mapping[str, str] | None = None) -> dict[str, str]:
    """This process's environment without what ROS leaks into it, plus `extra`."""
    return {name: value for name, value in os.environ.items() if name not in LEAKING} | dict(extra or {})


def run(what: str, command: Sequence[str], log: Path, environment: Mapping[str, str] | None = None) -> None:
    """Run `command`, its output appended to `log`; raises CommandFailedError with the end of that output."""
    with log.open("ab") as output:
        completed = subprocess.run(
            command, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT, check=False,
            env=clean_environment() if environment is None else dict(environment),
        )  # fmt: skip
    if completed.returncode != 0:
        tail = log.read_text(errors="replace").splitlines()[-TAIL_LINES:]
        raise CommandFailedError(f"{what} (exit {completed.returncode})", "\n".join(tail))
