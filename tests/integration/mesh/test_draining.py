"""SIGTERM to a service that is busy: it ends by itself, soon, with 0, and its lifespan has closed what it opened."""

import asyncio
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from websockets.asyncio.client import connect

from support.redis_server import free_port
from support.waiting import until_true

DRAINED_S = 10.0
"""The grace that compose.yaml gives; five seconds are meant, which two cores under a load of 16 do not always keep."""
PROGRAM = """
import asyncio, contextlib, pathlib, sys
from fastapi import FastAPI, WebSocket
from fastapi.responses import StreamingResponse
from mesh.server import serve

@contextlib.asynccontextmanager
async def lifespan(app):
    yield
    pathlib.Path(sys.argv[2]).write_text("closed")

app = FastAPI(lifespan=lifespan)

@app.get("/slow")
async def slow():
    await asyncio.Event().wait()

@app.get("/stream")
async def stream():
    async def parts():
        while True:
            yield b"part"
            await asyncio.sleep(0.01)
    return StreamingResponse(parts())

@app.websocket("/socket")
async def socket(socket: WebSocket):
    await socket.accept()
    await socket.send_text("open")
    await asyncio.Event().wait()

serve(app, host="127.0.0.1", port=int(sys.argv[1]))
"""


@pytest.fixture
def port() -> int:
    return free_port()


@pytest.fixture
def closed(tmp_path: Path) -> Path:
    return tmp_path / "closed"


@pytest.fixture
def server(port: int, closed: Path) -> Iterator[subprocess.Popen[bytes]]:
    process = subprocess.Popen([sys.executable, "-c", PROGRAM, str(port), str(closed)], stderr=subprocess.DEVNULL)
    yield process
    process.kill()
    process.wait()


async def asked(port: int, path: str) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    writer.write(f"GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
    await writer.drain()
    return reader, writer


@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGINT])
async def test_open_sockets_streams_and_slow_requests_hold_no_end_up(
    server: subprocess.Popen[bytes], port: int, closed: Path, how: signal.Signals
) -> None:
    async def answers() -> bool:
        try:
            _, writer = await asyncio.open_connection("127.0.0.1", port)
        except OSError:
            return False
        writer.close()
        return True

    await until_true(answers)
    _, slow = await asked(port, "/slow")
    streaming, stream = await asked(port, "/stream")
    await streaming.readuntil(b"part")
    async with connect(f"ws://127.0.0.1:{port}/socket", proxy=None) as socket:
        assert await socket.recv() == "open"
        begun_s = time.monotonic()
        server.send_signal(how)
        code = await asyncio.to_thread(server.wait, 30.0)
        took_s = time.monotonic() - begun_s
    for one in (slow, stream):
        one.close()
    assert code == 0
    assert await asyncio.to_thread(closed.read_text) == "closed"
    assert took_s < DRAINED_S
