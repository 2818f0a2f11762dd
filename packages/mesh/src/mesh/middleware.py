"""ASGI middleware of every service: how much may be sent, from which pages, and that streams are streams."""

import contextlib
from collections.abc import Collection, Mapping

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocketClose

from mesh.errors import TooLargeError
from mesh.origins import ours_to_answer, place_of_host, place_of_origin
from mesh.problems import problem

READING = frozenset({"GET", "HEAD", "OPTIONS"})


class BodyLimit:
    """ASGI middleware: a request body over the limit is answered 413, whether its length was declared or not."""

    def __init__(self, app: ASGIApp, *, bytes_max: int, bytes_max_at: Mapping[str, int | None] | None = None) -> None:
        """`bytes_max_at` names paths with another limit; none = they look after their bodies themselves."""
        self.app = app
        self.bytes_max = bytes_max
        self.bytes_max_at = bytes_max_at or {}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        bytes_max = self.bytes_max_at.get(route_path(scope), self.bytes_max)
        if scope["type"] != "http" or bytes_max is None:
            await self.app(scope, receive, send)
            return
        declared = next((value for name, value in scope["headers"] if name == b"content-length"), b"0")
        if not declared.isdigit() or int(declared) > bytes_max:
            await self._refuse(bytes_max, scope, receive, send)
            return
        seen = 0

        async def counted() -> Message:
            nonlocal seen
            message = await receive()
            seen += len(message.get("body", b""))
            if seen > bytes_max:
                raise TooLargeError(f"the limit is {bytes_max} bytes")
            return message

        async def unless_refused(message: Message) -> None:
            if seen <= bytes_max:
                await send(message)

        with contextlib.suppress(TooLargeError):
            await self.app(scope, counted, unless_refused)
        if seen > bytes_max:
            await self._refuse(bytes_max, scope, receive, send)

    async def _refuse(self, bytes_max: int, scope: Scope, receive: Receive, send: Send) -> None:
        refusal = problem(413, TooLargeError.title, f"the limit is {bytes_max} bytes", scope["path"])
        refusal.headers["Connection"] = "close"
        await refusal(scope, receive, send)


class Unbuffered:
    """ASGI middleware: an answer of unknown length is a stream, and nginx is told to pass it on as it comes."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        async def told(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                if "content-length" not in headers:
                    headers["X-Accel-Buffering"] = "no"
            await send(message)

        await self.app(scope, receive, told if scope["type"] == "http" else send)


def route_path(scope: Scope) -> str:
    """The path as routes know it, without the prefix (`root_path`) under which a proxy serves them."""
    path: str = scope.get("path", "")
    root: str = scope.get("root_path", "")
    return path[len(root) :] if root and path.startswith(f"{root}/") else path


class SameOrigin:
    """ASGI middleware: what a foreign web page asks for through the browser of somebody who may is answered 403.

    Browsers say with `Origin` which page a request comes from; programs (curl, the other services) send none. Without
    this any page on the internet could drive the robot of whoever looks at it. Reading is not refused: a browser keeps
    the answer from a foreign page by itself. Sockets are, before they open.

    A proxy may ask under another `Host`; the one the browser asked for is then in `X-Forwarded-Host`, which counts too.
    No foreign page can send it: for a header of a page's own a browser first asks (CORS), and no service says yes.

    A page that has its own name point here (DNS rebinding) is of that origin and could send anything; the `Host` it
    asks by gives it away, and is answered 421. Reading too.
    """

    def __init__(self, app: ASGIApp, *, allowed: Collection[str] = (), open_paths: Collection[str] = ()) -> None:
        """`allowed` are further origins (`https://robot.lan`, behind a proxy); `open_paths` take what anybody asks."""
        self.app = app
        self.allowed = frozenset(place for origin in allowed if (place := place_of_origin(origin)) is not None)
        self.names = frozenset(place.host for _, place in self.allowed)
        self.open_paths = frozenset(open_paths)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in {"http", "websocket"} or route_path(scope) in self.open_paths:
            await self.app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        if (scope["type"] == "websocket" or scope["method"] not in READING) and self._foreign(headers):
            refusal = problem(403, "Asked by another page", "its origin is not this service's", scope["path"])
        elif not all(ours_to_answer(host, self.names) for host in headers.getlist("host")):
            detail = "it is not asked by a name of its own; further ones are set with ..._ORIGINS_ALLOWED"
            refusal = problem(421, "Asked by another name", detail, scope["path"])
        else:
            await self.app(scope, receive, send)
            return
        if scope["type"] == "websocket":
            await WebSocketClose(code=1008, reason="from another page")(scope, receive, send)
        else:
            await refusal(scope, receive, send)

    def _foreign(self, headers: Headers) -> bool:
        origins = headers.getlist("origin")
        if not origins:
            return False
        page = place_of_origin(origins[0]) if len(origins) == 1 else None
        if page is None or page in self.allowed:
            return page is None
        scheme, place = page
        asked = (headers.get("host", ""), headers.get("x-forwarded-host", "").split(",")[0].strip())
        return place not in [place_of_host(host, scheme) for host in asked]
