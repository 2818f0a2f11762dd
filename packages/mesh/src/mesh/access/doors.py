"""ASGI middleware: each route, socket and mount opens to whom it is declared for, before any of a body is read."""

from collections.abc import Callable
from typing import Final

import structlog
from fastapi import FastAPI
from starlette._utils import get_route_path  # what the router matches, to the letter
from starlette.requests import HTTPConnection
from starlette.responses import RedirectResponse, Response
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.websockets import WebSocketClose

from contracts.access import Holder, Role
from mesh.access.attempts import Attempts
from mesh.access.declarations import ANY, SOCKET, Door, NotDeclaredError, doors_of
from mesh.access.ring import KeyRing
from mesh.problems import problem

log = structlog.get_logger()

Ticket = Callable[[HTTPConnection], Holder | None]
"""A second way to say who asks, beside a key: the page's cookie."""

ANYBODY: Final = Holder(name="anybody", role=Role.ADMIN)
"""Who asks a service without keys; it listens on this machine alone."""
_WHO: Final = "atom.who"


def who(connection: HTTPConnection) -> Holder | None:
    """Who asks; None at an open route, which asks nobody."""
    return connection.scope.get(_WHO)


class Doors:
    """401 without a key that is known, 403 with one whose role is too low, 429 after too many wrong ones.

    What no route matches asks for a viewer: a stranger learns from no answer what there is. What is open is passed on
    at once: a stop waits for no key to be compared.
    """

    def __init__(
        self, app: ASGIApp, *, ring: KeyRing | None, ticket: Ticket | None = None, log_in_at: str | None = None
    ) -> None:
        """No ring: everybody may everything. `log_in_at` is where a browser without a ticket is sent."""
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
        if self._ring is None or scope["type"] == "lifespan":
            scope[_WHO] = ANYBODY
            await self.app(scope, receive, send)
            return
        method, path = scope.get("method", SOCKET), get_route_path(scope)
        if (method, path) in self._open or (needed := self._needed(method, path)) is None:
            await self.app(scope, receive, send)
            return
        asking = HTTPConnection(scope)
        known = self._known(asking, self._ring)
        if isinstance(known, Response):
            await self._refuse(known, scope, receive, send)
        elif not known.role.may(needed):
            detail = f"{known.name} is {known.role}; this needs {needed}"
            await self._refuse(problem(403, "Not permitted", detail, path), scope, receive, send)
        else:
            scope[_WHO] = known
            await self.app(scope, receive, send)

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

    def _known(self, asking: HTTPConnection, ring: KeyRing) -> Holder | Response:
        scheme, _, key = asking.headers.get("authorization", "").partition(" ")
        if scheme.lower() != "bearer":  # another scheme is a proxy's own business
            ticket = self._ticket(asking) if self._ticket is not None else None
            return ticket or self._unknown(asking, "it needs a key (Authorization: Bearer ...)", "Bearer")
        if (holder := ring.holder_of(key.strip())) is not None:
            return holder
        if not self._attempts.wrong(asking):
            return problem(429, "Too many wrong keys", "wait a minute", asking.url.path)
        log.warning("a wrong key", client=asking.client.host if asking.client else "", path=asking.url.path)
        return self._unknown(asking, "this key is not known", 'Bearer error="invalid_token"')

    def _unknown(self, asking: HTTPConnection, detail: str, challenge: str) -> Response:
        page = asking.scope["type"] == "http" and "text/html" in asking.headers.get("accept", "")
        if self._log_in_at is not None and page and asking.scope["method"] == "GET":
            return RedirectResponse(asking.scope.get("root_path", "") + self._log_in_at, 303)
        refusal = problem(401, "Who asks is not known", detail, asking.url.path)
        refusal.headers["WWW-Authenticate"] = challenge
        return refusal

    async def _refuse(self, refusal: Response, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "http" or "websocket.http.response" in scope.get("extensions", {}):
            await refusal(scope, receive, send)
        else:
            await WebSocketClose(code=1008, reason="not permitted")(scope, receive, send)
