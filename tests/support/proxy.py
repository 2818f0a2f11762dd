"""A reverse proxy as people put one in front of the page, and the faults that lie in front of a page."""

import asyncio
import contextlib
from dataclasses import dataclass, field

import httpx
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect, WebSocketState
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

NOT_PASSED_ON = {"content-length", "content-encoding", "transfer-encoding", "connection"}
OF_THE_HANDSHAKE = {"host", "upgrade", "connection", "sec-websocket-key", "sec-websocket-version"}
FROZEN_S = 30.0


@dataclass
class Proxy:
    """Serves what is at `target` below `prefix`; everything else there belongs to another app."""

    target: str
    prefix: str = ""
    says: str = "x-forwarded-prefix"
    """The header that names the prefix; '' = none."""
    said: str | None = None
    """What it says instead of the prefix."""
    strips: bool = True
    keeps_host: bool = False
    missing: set[str] = field(default_factory=set)
    """Files (by the end of their path) that are answered 404."""
    frozen: bool = False
    """Connections are taken, and nothing answers."""
    no_sockets: bool = False
    seen: list[tuple[str, str]] = field(default_factory=list)
    sockets: set[WebSocket] = field(default_factory=set[WebSocket])

    def app(self) -> Starlette:
        methods = ["GET", "POST", "DELETE", "PUT"]
        return Starlette(
            routes=[WebSocketRoute("/{p:path}", self._socket), Route("/{p:path}", self._http, methods=methods)]
        )

    async def drop_sockets(self) -> None:
        """Ends the open ones, and opens no more until told otherwise."""
        self.no_sockets = True
        for socket in tuple(self.sockets):
            with contextlib.suppress(RuntimeError, WebSocketDisconnect):
                await socket.close(1001)

    def _behind(self, path: str, query: str) -> str | None:
        if not path.startswith(self.prefix) or any(path.endswith(name) for name in self.missing):
            return None
        inside = path[len(self.prefix) :] if self.strips else path
        return f"{inside or '/'}{'?' + query if query else ''}"

    def _forwarded(self, host: str) -> dict[str, str]:
        said = {"x-forwarded-host": host}
        if self.says and self.prefix:
            said[self.says] = self.said if self.said is not None else self.prefix
        return said | ({"host": host} if self.keeps_host else {})

    async def _http(self, request: Request) -> Response:
        self.seen.append((request.method, request.url.path))
        behind = self._behind(request.url.path, request.url.query)
        if behind is None:
            return PlainTextResponse("another app lives here", 404)
        body = await request.body()
        if self.frozen:
            await asyncio.sleep(FROZEN_S)
        kept = {name: value for name, value in request.headers.items() if name not in {"content-length", "host"}}
        async with httpx.AsyncClient(timeout=FROZEN_S, trust_env=False) as client:
            headers = kept | self._forwarded(request.headers["host"])
            answer = await client.request(request.method, f"{self.target}{behind}", headers=headers, content=body)
        headers = {name: value for name, value in answer.headers.items() if name not in NOT_PASSED_ON}
        return Response(answer.content, answer.status_code, headers)

    async def _socket(self, socket: WebSocket) -> None:
        self.seen.append(("WS", socket.url.path))
        behind = self._behind(socket.url.path, socket.url.query)
        if behind is None or self.no_sockets:
            await socket.close(1008)
            return
        headers = {name: value for name, value in socket.headers.items() if name not in OF_THE_HANDSHAKE}
        headers = {name: value for name, value in headers.items() if not name.startswith("sec-websocket")}
        headers |= self._forwarded(socket.headers["host"])
        host = headers.pop("host", None)
        origin = headers.pop("origin", None)
        address = f"ws{self.target.removeprefix('http')}{behind}"
        extra = list(headers.items()) + ([("Host", host)] if host else [])
        try:
            async with connect(address, origin=origin, additional_headers=extra, max_size=None, proxy=None) as inner:  # type: ignore[arg-type]
                await socket.accept()
                self.sockets.add(socket)
                await _both_ways(socket, inner)
        except (InvalidStatus, ConnectionClosed, OSError):
            pass
        finally:
            self.sockets.discard(socket)
            if socket.application_state is not WebSocketState.DISCONNECTED:
                with contextlib.suppress(RuntimeError, WebSocketDisconnect):
                    await socket.close(1011)


async def _both_ways(socket: WebSocket, inner: ClientConnection) -> None:
    async def inwards() -> None:
        while True:
            message = await socket.receive()
            if message["type"] == "websocket.disconnect":
                return
            await inner.send(message["text"] if message.get("text") is not None else message["bytes"])

    async def outwards() -> None:
        async for message in inner:
            await (socket.send_text(message) if isinstance(message, str) else socket.send_bytes(message))

    ways = {asyncio.create_task(inwards()), asyncio.create_task(outwards())}
    try:
        await asyncio.wait(ways, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for way in ways:
            way.cancel()
        with contextlib.suppress(WebSocketDisconnect, ConnectionClosed, RuntimeError):
            await asyncio.gather(*ways, return_exceptions=True)
