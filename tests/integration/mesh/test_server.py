"""A served app, as a process: the addresses it listens at."""

import signal
import subprocess
import sys
from collections.abc import Iterator

import httpx
import pytest

from support.redis_server import free_port
from support.waiting import until_true

HOSTS = ("127.0.0.1", "127.0.0.2")
PROGRAM = """
import sys
from fastapi import FastAPI
from mesh.server import serve
serve(FastAPI(), host=sys.argv[1], port=int(sys.argv[2]))
"""


@pytest.fixture
def port() -> Iterator[int]:
    port = free_port()
    server = subprocess.Popen([sys.executable, "-c", PROGRAM, ",".join(HOSTS), str(port)])
    yield port
    server.send_signal(signal.SIGTERM)
    assert server.wait(30.0) in {0, -signal.SIGTERM}


async def test_a_service_listens_at_every_address_named_and_at_no_other(port: int) -> None:
    async with httpx.AsyncClient() as client:

        async def answers(host: str) -> bool:
            try:
                return (await client.get(f"http://{host}:{port}/openapi.json")).status_code == 200
            except httpx.ConnectError:
                return False

        for host in HOSTS:
            await until_true(lambda host=host: answers(host))
        assert not await answers("127.0.0.3")
