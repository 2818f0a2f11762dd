"""A served app, as a process: the addresses it listens at."""

import asyncio
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosedError
from websockets.frames import Frame, Opcode

from support.redis_server import free_port
from support.waiting import until_true

HOSTS = ("127.0.0.1", "127.0.0.2")
PROGRAM = """
import asyncio, sys
from fastapi import FastAPI, WebSocket
from fastapi.responses import Response, StreamingResponse
from mesh import server

pages = FastAPI()
released = asyncio.Event()

@pages.get("/held")
async def held() -> StreamingResponse:
    async def late():
        await released.wait()
        for letter in "late":
            yield letter
            await asyncio.sleep(0)

    return StreamingResponse(late())

@pages.get("/release")
async def release() -> str:
    released.set()
    return "released"

let_go = asyncio.Event()

@pages.get("/endless")
async def endless() -> StreamingResponse:
    async def parts():
        try:
            while True:
                yield bytes(65536)
                await asyncio.sleep(0)
        finally:
            let_go.set()

    return StreamingResponse(parts())

@pages.get("/giant")
async def giant() -> Response:
    return Response(bytes(12_000_000))

@pages.get("/let-go")
async def is_let_go() -> bool:
    return let_go.is_set()

@pages.websocket("/socket")
async def socket(socket: WebSocket) -> None:
    await socket.accept()
    async for _ in socket.iter_text():
        pass

async def app(scope, receive, send):
    # /length answers with how much came, and with the fields it sees once all has come
    if scope["type"] != "http" or scope["path"] != "/length":
        return await pages(scope, receive, send)
    size, more = 0, True
    while more:
        message = await receive()
        size, more = size + len(message.get("body", b"")), message.get("more_body", False)
    told = b"%d %s" % (size, b",".join(name for name, _ in scope["headers"]))
    await send({"type": "http.response.start", "status": 200, "headers": []})
    await send({"type": "http.response.body", "body": told})

server.HEADER_S_MAX = 0.5
server.BODY_WAIT_S_MAX = 0.5
server.ANSWER_WAIT_S_MAX = 0.5
server.serve(app, host=sys.argv[1], port=int(sys.argv[2]))
"""


@pytest.fixture
def port(tmp_path: Path) -> Iterator[int]:
    """Of a server; whatever was done to it, it has nothing to complain of."""
    port, complaints = free_port(), tmp_path / "stderr"
    with complaints.open("wb") as stderr:
        server = subprocess.Popen([sys.executable, "-c", PROGRAM, ",".join(HOSTS), str(port)], stderr=stderr)
    yield port
    server.send_signal(signal.SIGTERM)
    assert server.wait(30.0) == 0
    assert "Traceback" not in complaints.read_text()


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


async def served_at(port: int) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
    """A connection, as soon as the server takes one."""
    opened: list[tuple[asyncio.StreamReader, asyncio.StreamWriter]] = []

    async def connects() -> bool:
        try:
            opened.append(await asyncio.open_connection(HOSTS[0], port))
        except OSError:
            return False
        return True

    await until_true(connects)
    return opened[0]


async def test_who_says_nothing_is_not_waited_for(port: int) -> None:
    reader, writer = await served_at(port)
    async with asyncio.timeout(20.0):
        assert await reader.read() == b""
    writer.close()


async def test_whose_headers_do_not_end_in_time_is_not_waited_for(port: int) -> None:
    reader, writer = await served_at(port)
    writer.write(b"GET /openapi.json HTTP/1.1\r\nHost: localhost\r\n\r\n")
    async with asyncio.timeout(20.0):
        assert (await reader.readline()).startswith(b"HTTP/1.1 200")
        writer.write(b"GET / HTTP/1.1\r\nX-Slow: ")
        await reader.read()
    writer.close()


async def test_who_takes_nothing_of_an_answer_is_let_go_with_what_it_is_made_of(port: int) -> None:
    reader, writer = await served_at(port)
    writer.write(b"GET /endless HTTP/1.1\r\nHost: localhost\r\n\r\n")
    async with asyncio.timeout(20.0), httpx.AsyncClient(base_url=f"http://{HOSTS[0]}:{port}") as client:
        assert (await reader.readline()).startswith(b"HTTP/1.1 200")
        await until_true(lambda: is_true(client, "/let-go"))
    writer.close()


async def test_who_takes_a_long_answer_slowly_gets_all_of_it(port: int) -> None:
    """Longer, all in all, than anybody is waited for."""
    reader, writer = await served_at(port)
    writer.write(b"GET /endless HTTP/1.1\r\nHost: localhost\r\n\r\n")
    began_s = time.monotonic()
    async with asyncio.timeout(20.0):
        while time.monotonic() < began_s + 2.0:
            assert await reader.read(65536)
    writer.close()


async def test_who_takes_an_answer_of_one_piece_slowly_gets_all_of_it(port: int) -> None:
    """What waits for him never falls to where more would be written, until the end; it does fall."""
    reader, writer = await served_at(port)
    writer.write(b"GET /giant HTTP/1.1\r\nHost: localhost\r\n\r\n")
    began_s, left = time.monotonic(), 12_000_000
    async with asyncio.timeout(60.0):
        while await reader.readline() != b"\r\n":
            pass
        while left:
            part = await reader.read(1 << 20)
            assert part, f"cut off after {time.monotonic() - began_s:.1f} s, {left} bytes before the end"
            left -= len(part)
            await asyncio.sleep(len(part) / 4e6)
    assert time.monotonic() - began_s > 1.0, "longer than anybody is waited for"
    writer.close()


async def is_true(client: httpx.AsyncClient, path: str) -> bool:
    return (await client.get(path)).json() is True


async def test_headers_without_an_end_are_answered_431_and_not_kept(port: int) -> None:
    reader, writer = await served_at(port)
    writer.write(b"GET / HTTP/1.1\r\nX-Giant: " + b"a" * 2_000_000)
    async with asyncio.timeout(20.0):
        assert (await reader.readline()).startswith(b"HTTP/1.1 431")
    writer.close()


async def test_the_body_of_a_request_that_was_refused_early_is_no_header(port: int) -> None:
    reader, writer = await served_at(port)
    body = b"a" * 1_000_000
    writer.write(b"POST /nowhere HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000000\r\n\r\n")
    async with asyncio.timeout(20.0):
        assert (await reader.readline()).startswith(b"HTTP/1.1 404")
        writer.write(body + b"GET /openapi.json HTTP/1.1\r\nHost: localhost\r\n\r\n")
        while not (line := await reader.readline()).startswith((b"HTTP/1.1", b'{"detail":"Not Found"}HTTP/1.1')):
            assert line
        assert b"HTTP/1.1 200" in line
    writer.close()


def chunked(*parts: bytes) -> bytes:
    head = b"POST /length HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n"
    return head + b"".join(b"%x\r\n%s\r\n" % (len(part), part) for part in parts)


async def test_trailers_are_no_headers(port: int) -> None:
    """A long body in short parts, and a field behind it that an app must not take for one of those before."""
    reader, writer = await served_at(port)
    writer.write(chunked(*[b"ab"] * 50_000) + b"0\r\nX-More: yes\r\nAuthorization: Bearer x\r\n\r\n")
    async with asyncio.timeout(20.0):
        answer = await reader.readuntil(b"\r\n0\r\n\r\n")
    assert b"100000 host,transfer-encoding\r\n" in answer
    writer.close()


@pytest.mark.parametrize(
    "endless", [b"0\r\nX-More: " + b"a" * 2_000_000, b"0\r\n" + b"X-More: a\r\n" * 200_000, b"1;" + b"a" * 2_000_000]
)
async def test_trailers_and_extensions_without_an_end_are_not_kept(port: int, endless: bytes) -> None:
    reader, writer = await served_at(port)
    writer.write(chunked(b"ab") + endless)
    async with asyncio.timeout(20.0):
        try:
            answer = await reader.read()
        except ConnectionResetError:
            answer = b""
    assert b" 200 " not in answer
    writer.close()


async def test_a_body_that_stops_coming_is_answered_408(port: int) -> None:
    reader, writer = await served_at(port)
    writer.write(b"POST /length HTTP/1.1\r\nHost: localhost\r\nTransfer-Encoding: chunked\r\n\r\n1\r\na\r\n")
    async with asyncio.timeout(20.0):
        assert (await reader.readline()).startswith(b"HTTP/1.1 408")
        assert (await reader.read()).endswith(b"\r\n\r\n")
    writer.close()


async def test_answers_to_a_connection_that_is_gone_are_dropped(port: int) -> None:
    reader, writer = await served_at(port)
    async with asyncio.timeout(20.0), httpx.AsyncClient(base_url=f"http://{HOSTS[0]}:{port}") as client:
        writer.write(b"GET /held HTTP/1.1\r\nHost: localhost\r\n\r\n" * 2)
        assert await reader.readline() == b"HTTP/1.1 200 OK\r\n"
        writer.transport.abort()
        for _ in range(3):
            assert (await client.get("/release")).json() == "released"
        assert (await client.get("/held")).text == "late"


async def test_text_that_is_no_utf8_closes_a_socket_with_1007(port: int) -> None:
    _, writer = await served_at(port)
    writer.close()
    async with connect(f"ws://{HOSTS[0]}:{port}/socket", proxy=None) as socket:
        socket.protocol.writes.append(Frame(Opcode.TEXT, b"\xff").serialize(mask=True))
        await socket.send("and more")
        with pytest.raises(ConnectionClosedError) as closed:
            await socket.recv()
    assert closed.value.rcvd is not None
    assert closed.value.rcvd.code == 1007


async def test_an_upgrade_that_is_no_handshake_is_answered_400(port: int) -> None:
    upgrade = b"GET /socket HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
    for rest in (b"Content-Length: 3\r\n", b"".join(b"X-%d: 1\r\n" % number for number in range(200))):
        reader, writer = await served_at(port)
        writer.write(upgrade + rest + b"\r\n")
        async with asyncio.timeout(20.0):
            assert (await reader.readline()).startswith(b"HTTP/1.1 400")
            await reader.read()
        writer.close()
