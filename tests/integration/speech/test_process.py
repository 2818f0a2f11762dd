"""Speech as a process: it gives way to all else, so that a stop by curl does not wait for a reading."""

import os
import subprocess
import sys
from collections.abc import Iterator

import httpx
import psutil
import pytest

from support.redis_server import free_port
from support.waiting import until_true

NICE = 9


@pytest.fixture
def started() -> Iterator[tuple[psutil.Process, int]]:
    """Its process and its port."""
    port = free_port()
    environment = {**os.environ, "SPEECH_PORT": str(port), "SPEECH_NICE": str(NICE)}
    process = subprocess.Popen([sys.executable, "-m", "speech"], env=environment, stdout=subprocess.DEVNULL)
    yield psutil.Process(process.pid), port
    process.kill()
    process.wait()


async def test_every_thread_of_it_gives_way(started: tuple[psutil.Process, int]) -> None:
    process, port = started
    async with httpx.AsyncClient(base_url=f"http://127.0.0.1:{port}", trust_env=False) as http:

        async def ready() -> bool:
            try:
                return (await http.get("/ready")).is_success
            except httpx.TransportError:
                return False

        await until_true(ready)
    threads = [os.getpriority(os.PRIO_PROCESS, one.id) for one in process.threads()]
    assert len(threads) > 1
    assert set(threads) == {min(19, os.nice(0) + NICE)}
