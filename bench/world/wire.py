"""HTTP and WebSockets without sockets: a service's own client at one end, its own routes at the other."""

import asyncio
import contextlib
from collections import Counter
from collections.abc import AsyncGenerator, Mapping
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import urlsplit

import httpx
from fastapi import FastAPI

from bench.world.line import SENSELESS, Line

DELAY_S = 0.001
"""Each way."""


@dataclass
class Served:
    """An app whose lifespan has begun, and what its routes find in `request.state`. `calls`: by caller and route."""

    name: str
    app: FastAPI
    state: Mapping[str, Any]
    calls: Counter[str] = field(default_factory=Counter[str])
    handling: set["asyncio.Task[None]"] = field(default_factory=set["asyncio.Task[None]"])
    sockets: set["Socket"] = field(default_factory=set["Socket"])
    up: bool = False
    """Without it nobody listens here: who calls is refused."""

    def scope(self, kind: str, url: httpx.URL, headers: list[tuple[bytes, bytes]]) -> dict[str, Any]:
        return {
            "type": kind,
            "asgi": {"version": "3.0"},
            "http_version": "1.1",
            "scheme": url.scheme,
            "path": url.path,
            "raw_path": url.raw_path.split(b"?")[0],
            "query_string": url.query,
            "root_path": "",
            "headers": headers,
            "client": ("127.0.0.1", 1),
            "server": (url.host, url.port),
            "state": dict(self.state),
        }


@contextlib.asynccontextmanager
async def served(name: str, app: FastAPI, calls: Counter[str]) -> AsyncGenerator[Served]:
    one = Served(name, app, {}, calls)
    async with living(one):
        yield one


@contextlib.asynccontextmanager
async def living(one: Served) -> AsyncGenerator[None]:
    """While it lasts the service answers; at its end open connections break before it winds up."""
    async with one.app.router.lifespan_context(one.app) as state:
        one.state, one.up = state or {}, True
        try:
            yield
        finally:
            one.up = False
            for task in list(one.handling):
                task.cancel()
            for socket in list(one.sockets):
                socket.cut()


class Wire(httpx.AsyncBaseTransport):
    """From `caller` to a service. A caller that gives up is gone for the service, which goes on with what it may."""

    def __init__(self, caller: str, to: Served, line: Line | None = None) -> None:
        self._caller = caller
        self._to = to
        self._line = line or Line()

    async def handle_async_request(self, request: httpx.Request) -> httpx.Response:
        self._to.calls[f"{self._caller} {request.method} {self._to.name}{_route(request.url.path)}"] += 1
        limit_s = request.extensions.get("timeout", {}).get("read")
        exchange = _Exchange(await request.aread())
        becomes = self._line.answering(asyncio.get_running_loop().time())
        try:
            async with asyncio.timeout(limit_s):
                await asyncio.sleep(DELAY_S + becomes.late_s / 2)
                await _for_ever(becomes.lost_there and limit_s is not None)
                if not self._to.up or self._caller in self._line.dead:
                    raise httpx.ConnectError("connection refused", request=request)
                scope = self._to.scope("http", request.url, [(k.lower(), v) for k, v in request.headers.raw])
                task = asyncio.ensure_future(self._handle(scope | {"method": request.method}, exchange))
                self._to.handling.add(task)
                task.add_done_callback(self._to.handling.discard)
                await exchange.over.wait()
                await asyncio.sleep(DELAY_S + becomes.late_s / 2)
                await _for_ever(becomes.lost_back and limit_s is not None)
        except TimeoutError as error:
            raise httpx.ReadTimeout("no answer in time", request=request) from error
        finally:
            exchange.left.set()
        if not exchange.whole:
            raise httpx.RemoteProtocolError("the service broke off", request=request)
        if becomes.senseless:
            return httpx.Response(exchange.status, content=SENSELESS, request=request)
        return httpx.Response(exchange.status, headers=exchange.headers, content=bytes(exchange.body), request=request)

    async def _handle(self, scope: dict[str, Any], exchange: "_Exchange") -> None:
        try:
            await self._to.app(scope, exchange.receive, exchange.send)
        finally:
            exchange.over.set()


async def _for_ever(really: bool) -> None:
    if really:
        await asyncio.Event().wait()


class _Exchange:
    """One request and its answer, as ASGI messages."""

    def __init__(self, body: bytes) -> None:
        self.status = 0
        self.whole = False
        self.headers: list[tuple[bytes, bytes]] = []
        self.body = bytearray()
        self.over, self.left = asyncio.Event(), asyncio.Event()
        self._ask: bytes | None = body

    async def receive(self) -> dict[str, Any]:
        if self._ask is not None:
            body, self._ask = self._ask, None
            return {"type": "http.request", "body": body, "more_body": False}
        await self.left.wait()
        return {"type": "http.disconnect"}

    async def send(self, message: Any) -> None:
        if message["type"] == "http.response.start":
            self.status, self.headers = message["status"], list(message["headers"])
        else:
            self.body += message.get("body", b"")
            if not message.get("more_body", False):
                self.whole = True
                self.over.set()


class Socket:
    """The client's end of a WebSocket."""

    def __init__(self) -> None:
        self.inbox: asyncio.Queue[dict[str, Any]] = asyncio.Queue()
        self.outbox: asyncio.Queue[dict[str, Any]] = asyncio.Queue()

    def cut(self) -> None:
        """The connection breaks: each end is told."""
        self.inbox.put_nowait({"type": "websocket.close"})
        self.outbox.put_nowait({"type": "websocket.disconnect", "code": 1006})

    async def recv(self) -> str:
        message = await self.inbox.get()
        if message["type"] == "websocket.close":
            raise OSError("the service closed the socket")
        return str(message["text"])

    async def send(self, message: str) -> None:
        if not self.inbox.empty():
            await self.recv()
        self.outbox.put_nowait({"type": "websocket.receive", "text": message})


@contextlib.asynccontextmanager
async def open_socket(to: Served, address: str) -> AsyncGenerator[Socket]:
    """Raises OSError where nobody listens, and where the service refuses."""
    if not to.up:
        raise OSError("connection refused")
    url = httpx.URL(address)
    assert urlsplit(address).scheme == "ws"
    socket = Socket()
    task = asyncio.ensure_future(
        to.app(to.scope("websocket", url, [(b"host", url.netloc)]), socket.outbox.get, socket.inbox.put)  # type: ignore[arg-type]
    )
    socket.outbox.put_nowait({"type": "websocket.connect"})
    if (await socket.inbox.get())["type"] != "websocket.accept":
        raise OSError("the service refused the socket")
    to.sockets.add(socket)
    try:
        yield socket
    finally:
        to.sockets.discard(socket)
        socket.outbox.put_nowait({"type": "websocket.disconnect", "code": 1000})
        await asyncio.gather(task, return_exceptions=True)


def _route(path: str) -> str:
    """Without what differs from one request to the next."""
    return "/".join("{id}" if len(part) >= 32 else part for part in path.split("/"))
