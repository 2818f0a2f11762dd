"""ASGI middleware: each route, socket and mount opens to whom it is declared for, before any of a body is read."""

import contextlib
import time
from collections.abc import Callable
from typing import Final

import structlog
from fastapi import FastAPI
from starlette._utils import get_route_path  # what the router matches, to the letter
from starlette.requests import ClientDisconnect, HTTPConnection
from starlette.responses import RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocketClose

from contracts.access import Holder, Role
from mesh.access.attempts import Attempts
from mesh.access.declarations import ANY, SOCKET, Door, NotDeclaredError, doors_of
from mesh.access.ring import LOOK_S, KeyRing
from mesh.problems import problem

log = structlog.get_logger()

Ticket = Callable[[HTTPConnection, KeyRing], Holder | None]
"""A second way to say who asks, beside a key: the page's cookie."""

ANYBODY: Final = Holder(name="anybody", role=Role.ADMIN)
"""Who asks a service without keys; it listens on this machine alone."""
_WHO: Final = "atom.who"
_AGAIN: Final = "atom.who.again"


def who(connection: HTTPConnection) -> Holder | None:
    """Who asks; None at an open route, which asks nobody."""
    return connection.scope.get(_WHO)


def who_now(connection: HTTPConnection) -> Holder | None:
    """Who asks, looked up again: None once the key is revoked or the cookie has expired. For what stays open long."""
    again: Callable[[], Holder | None] | None = connection.scope.get(_AGAIN)
    return again() if again is not None else who(connection)


class Doors:
    """401 without a key that is known, 403 with one whose role is too low, 429 after too many wrong ones.

    What no route matches asks for a viewer: a stranger learns from no answer what there is. What is open is passed on
    at once: a stop waits for no key to be compared.
    """

    def __init__(
        self, app: ASGIApp, *, ring: KeyRing | None, ticket: Ticket | None = None, log_in_at: str | None = None
    ) -> None:
        """No ring: everybody may everything. `log_in_at`, from the root, is where browsers without a ticket go."""
        self.app = app
        self._ring = ring
        self._ticket = ticket
        self._log_in_at = log_in_at
        self._attempts = Attempts()
        self._doors: tuple[Door, ...] | None = None
        self._open: frozenset[tuple[str, str]] = frozenset()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if self._doors is None:
            self._doors = await self._declared(scope, receive, send)
            opened = {(one.method, one.path) for one in self._doors if one.role is None}
            self._open = frozenset(one for one in opened if self._needed(*one) is None)
            if self._ring is None:
                log.info("no keys: whoever is on this machine may everything; `atom keys make` makes some")
        if self._ring is None or scope["type"] == "lifespan":
            scope[_WHO] = ANYBODY
            await self.app(scope, receive, send)
            return
        method, path = scope.get("method", SOCKET), get_route_path(scope)
        if (method, path) in self._open or (needed := self._needed(method, path)) is None:
            await self.app(scope, receive, send)
            return
        asking, ring = HTTPConnection(scope), self._ring
        known = self._holder(asking, ring) or self._unknown(asking)
        if isinstance(known, Response):
            await self._refuse(known, scope, receive, send)
        elif not known.role.may(needed):
            detail = f"{known.name} is {known.role}; this needs {needed}"
            await self._refuse(problem(403, "Not permitted", detail, path), scope, receive, send)
        else:
            scope[_WHO], scope[_AGAIN] = known, lambda: self._holder(asking, ring)
            with contextlib.suppress(_RevokedError, ClientDisconnect):
                await self.app(scope, *_while_known(asking, needed, receive, send))

    async def _declared(self, scope: Scope, receive: Receive, send: Send) -> tuple[Door, ...]:
        app: FastAPI = scope["app"]
        try:
            return doors_of(app.routes)
        except NotDeclaredError as error:
            if scope["type"] == "lifespan":
                await receive()
                await send({"type": "lifespan.startup.failed", "message": str(error)})
            raise

    def _needed(self, method: str, path: str) -> Role | None:
        """Of the first route that matches, as the router takes it; one that matches but for its method counts last."""
        assert self._doors is not None
        partly: Door | None = None
        for door in self._doors:
            if (method == SOCKET) != (door.method == SOCKET) and door.method != ANY:
                continue
            if door.pattern.match(path):
                if door.method in (method, ANY):
                    return door.role
                partly = partly or door
        return partly.role if partly is not None else Role.VIEWER

    def _holder(self, asking: HTTPConnection, ring: KeyRing) -> Holder | None:
        key = _key_of(asking)
        if key is not None:
            return ring.holder_of(key)
        return self._ticket(asking, ring) if self._ticket is not None else None

    def _unknown(self, asking: HTTPConnection) -> Response:
        url, key = asking.url, _key_of(asking)
        page = asking.scope["type"] == "http" and "text/html" in asking.headers.get("accept", "")
        if key is None and page and self._log_in_at is not None and asking.scope["method"] == "GET":
            return RedirectResponse("../" * (get_route_path(asking.scope).count("/") - 1) + self._log_in_at, 303)
        if key is not None and not self._attempts.wrong(asking):
            refusal = problem(429, "Too many wrong keys", "wait a minute", url.path)
            refusal.headers["Retry-After"] = "60"
            return refusal
        detail, challenge = "it needs a key (Authorization: Bearer ...)", "Bearer"
        if key is not None:
            log.warning("a wrong key", client=asking.client.host if asking.client else "", path=url.path)
            detail, challenge = "this key is not known", 'Bearer error="invalid_token"'
        refusal = problem(401, "Who asks is not known", detail, url.path)
        refusal.headers["WWW-Authenticate"] = challenge
        return refusal

    async def _refuse(self, refusal: Response, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "http" or "websocket.http.response" in scope.get("extensions", {}):
            await refusal(scope, receive, send)
        else:
            await WebSocketClose(code=1008, reason="not permitted")(scope, receive, send)


def _key_of(asking: HTTPConnection) -> str | None:
    """None without one; another scheme is a proxy's own business."""
    scheme, _, key = asking.headers.get("authorization", "").partition(" ")
    return key.strip() if scheme.lower() == "bearer" else None


class _RevokedError(OSError):
    """To who still sends it is as if the client had gone."""


def _while_known(asking: HTTPConnection, needed: Role, receive: Receive, send: Send) -> tuple[Receive, Send]:
    """A socket or a stream ends with the key or the cookie it was opened with: at its next word, or within `LOOK_S`."""
    looked_s = time.monotonic()

    def known() -> bool:
        holder = who_now(asking)
        return holder is not None and holder.role.may(needed)

    async def received() -> Message:
        message = await receive()
        if message["type"] == "websocket.receive" and not known():
            return {"type": "websocket.disconnect", "code": 1008, "reason": "not permitted any more"}
        return message

    async def sent(message: Message) -> None:
        nonlocal looked_s
        if message["type"] in _LAST and time.monotonic() - looked_s >= LOOK_S:
            looked_s = time.monotonic()
            if not known():
                await send(_LAST[message["type"]])
                raise _RevokedError("not permitted any more")
        await send(message)

    return received, sent


_LAST: Final[dict[str, Message]] = {
    "http.response.body": {"type": "http.response.body", "body": b"", "more_body": False},
    "websocket.send": {"type": "websocket.close", "code": 1008, "reason": "not permitted any more"},
}
