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

from contracts.access import Principal, Role
from mesh.access.credentials import LOOK_S, CredentialStore
from mesh.access.policies import ANY, SOCKET, NotDeclaredError, RoutePolicy, route_policies
from mesh.access.rate_limit import FailureRateLimit
from mesh.problems import problem

log = structlog.get_logger()

SessionAuthenticator = Callable[[HTTPConnection, CredentialStore], Principal | None]
"""Says who asks by something else than a key: the page's cookie."""

ANYBODY: Final = Principal(name="anybody", role=Role.ADMIN)
"""Who asks a service without keys; it listens on this machine alone."""
_PRINCIPAL: Final = "atom.principal"
_CURRENT: Final = "atom.principal.current"


def principal_of(connection: HTTPConnection) -> Principal | None:
    """Who asks; None at an open route, which asks nobody."""
    return connection.scope.get(_PRINCIPAL)


def current_principal(connection: HTTPConnection) -> Principal | None:
    """Who asks, looked up again: None once the key is revoked or the cookie has expired. For what stays open long."""
    current: Callable[[], Principal | None] | None = connection.scope.get(_CURRENT)
    return current() if current is not None else principal_of(connection)


class AuthorizationMiddleware:
    """401 without a key that is known, 403 with one whose role is too low, 429 after too many wrong ones.

    What no route matches asks for a viewer: a stranger learns from no answer what there is. What is open is passed on
    at once: a stop waits for no key to be compared.
    """

    def __init__(
        self,
        app: ASGIApp,
        *,
        credentials: CredentialStore | None,
        authenticate_session: SessionAuthenticator | None = None,
        log_in_at: str | None = None,
    ) -> None:
        """No credentials: everybody may everything. Browsers without a session go to `log_in_at`, from the root."""
        self.app = app
        self._credentials = credentials
        self._authenticate_session = authenticate_session
        self._log_in_at = log_in_at
        self._failures = FailureRateLimit()
        self._policies: tuple[RoutePolicy, ...] | None = None
        self._open: frozenset[tuple[str, str]] = frozenset()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if self._policies is None:
            self._policies = await self._declared(scope, receive, send)
            opened = {(one.method, one.path) for one in self._policies if one.role is None}
            self._open = frozenset(one for one in opened if self._required_role(*one) is None)
            if self._credentials is None:
                log.info("no keys: whoever is on this machine may everything; `atom keys make` makes some")
        if self._credentials is None or scope["type"] == "lifespan":
            scope[_PRINCIPAL] = ANYBODY
            await self.app(scope, receive, send)
            return
        method, path = scope.get("method", SOCKET), get_route_path(scope)
        if (method, path) in self._open or (required := self._required_role(method, path)) is None:
            await self.app(scope, receive, send)
            return
        asking, credentials = HTTPConnection(scope), self._credentials
        known = self._principal(asking, credentials) or self._unknown(asking)
        if isinstance(known, Response):
            await self._refuse(known, scope, receive, send)
        elif not known.role.may(required):
            detail = f"{known.name} is {known.role}; this needs {required}"
            await self._refuse(problem(403, "Not permitted", detail, path), scope, receive, send)
        else:
            scope[_PRINCIPAL], scope[_CURRENT] = known, lambda: self._principal(asking, credentials)
            with contextlib.suppress(_RevokedError, ClientDisconnect):
                await self.app(scope, *_while_known(asking, required, receive, send))

    async def _declared(self, scope: Scope, receive: Receive, send: Send) -> tuple[RoutePolicy, ...]:
        app: FastAPI = scope["app"]
        try:
            return route_policies(app.routes)
        except NotDeclaredError as error:
            if scope["type"] == "lifespan":
                await receive()
                await send({"type": "lifespan.startup.failed", "message": str(error)})
            raise

    def _required_role(self, method: str, path: str) -> Role | None:
        """Of the first route that matches, as the router takes it; one that matches but for its method counts last."""
        assert self._policies is not None
        partly: RoutePolicy | None = None
        for policy in self._policies:
            if (method == SOCKET) != (policy.method == SOCKET) and policy.method != ANY:
                continue
            if policy.pattern.match(path):
                if policy.method in (method, ANY):
                    return policy.role
                partly = partly or policy
        return partly.role if partly is not None else Role.VIEWER

    def _principal(self, asking: HTTPConnection, credentials: CredentialStore) -> Principal | None:
        key = _key_of(asking)
        if key is not None:
            return credentials.by_key(key)
        return self._authenticate_session(asking, credentials) if self._authenticate_session is not None else None

    def _unknown(self, asking: HTTPConnection) -> Response:
        url, key = asking.url, _key_of(asking)
        page = asking.scope["type"] == "http" and "text/html" in asking.headers.get("accept", "")
        if key is None and page and self._log_in_at is not None and asking.scope["method"] == "GET":
            return RedirectResponse("../" * (get_route_path(asking.scope).count("/") - 1) + self._log_in_at, 303)
        if key is not None and not self._failures.hit(asking):
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


def _while_known(asking: HTTPConnection, required: Role, receive: Receive, send: Send) -> tuple[Receive, Send]:
    """A socket or a stream ends with the key or the cookie it was opened with: at its next word, or within `LOOK_S`."""
    looked_s = time.monotonic()

    def known() -> bool:
        principal = current_principal(asking)
        return principal is not None and principal.role.may(required)

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
