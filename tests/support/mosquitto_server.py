"""A real mosquitto for tests, on a port of its own; gone afterwards."""

import contextlib
import socket
import subprocess
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from system_packages import mosquitto

from support.redis_server import free_port

READY_S = 15.0


@dataclass(frozen=True)
class Broker:
    port: int
    process: "subprocess.Popen[bytes]"


@contextlib.contextmanager
def running_mosquitto(folder: Path, *, port: int | None = None, password_file: Path | None = None) -> Iterator[Broker]:
    """With `password_file` nobody is let in without one; else anybody on this machine."""
    found = mosquitto()
    assert found is not None, "mosquitto is not installed: `make setup` names it"
    port = port or free_port()
    who = f"password_file {password_file}\nallow_anonymous false\n" if password_file else "allow_anonymous true\n"
    config = folder / "mosquitto.conf"
    config.write_text(f"listener {port} 127.0.0.1\n{who}persistence false\n", encoding="utf-8")
    process = subprocess.Popen([found, "-c", str(config)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        _wait(port, process)
        yield Broker(port, process)
    finally:
        process.terminate()
        process.wait(timeout=10.0)


def _wait(port: int, process: "subprocess.Popen[bytes]") -> None:
    until_s = time.monotonic() + READY_S
    while time.monotonic() < until_s:
        assert process.poll() is None, "mosquitto ended"
        with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), timeout=0.2):
            return
    raise AssertionError("mosquitto does not answer")
