"""Talking to another service: one client each, timeouts everywhere, problems become named errors."""

import time
from typing import Any, TypeVar, cast
from urllib.parse import quote

import httpx
import stamina
from opentelemetry.trace import SpanKind
from pydantic import SecretStr, TypeAdapter, ValidationError

from contracts.base import Message
from contracts.problem import Dependency, DependencyState, Readiness
from mesh.errors import ServiceTimeoutError, UnavailableError, UpstreamError
from mesh.metrics import CALLS
from mesh.tracing import Tracer, failed, traceparent

M = TypeVar("M", bound=Message)

TRACER = Tracer(__name__)
_DOTS = {".": "%2E", "..": "%2E%2E"}
"""Not quoted, they would climb."""
REFUSED_WAIT_S = 10.0
"""So long a service whose key is refused reads nothing more: it would not be told more, and fill the other's log."""


def bearer(key: SecretStr | None) -> dict[str, str]:
    """The header that says who asks, for HTTP and for a socket's handshake."""
    return {"Authorization": f"Bearer {key.get_secret_value()}"} if key is not None else {}


def path_of(*segments: str) -> str:
    """'/missions/a%2Fb/events': what stands in an address and may have come from anywhere stays one segment of it."""
    return "".join(f"/{_DOTS.get(one) or quote(one, safe='')}" for one in segments)


class ServiceClient:
    """A typed HTTP client of one service. Reads are retried twice, and wait after a refused key; writes never.

    Raises `UnavailableError` when it is away, `ServiceTimeoutError` past the deadline, `UpstreamError` when it says no
    or answers with something that is not the contract.
    """

    def __init__(
        self,
        service: str,
        base_url: str,
        *,
        key: SecretStr | None = None,
        timeout_s: float = 5.0,
        transport: httpx.AsyncBaseTransport | None = None,
    ) -> None:
        """`key` is the asking service's own (`ServiceSettings.own_key`)."""
        self.service = service
        self.http = httpx.AsyncClient(
            base_url=base_url,
            timeout=httpx.Timeout(timeout_s, connect=1.0),
            transport=transport,
            headers=bearer(key),
            limits=httpx.Limits(max_connections=20, max_keepalive_connections=10),
            trust_env=False,
        )
        self._refused: tuple[int, str] | None = None
        self._refused_s = 0.0

    async def aclose(self) -> None:
        await self.http.aclose()

    async def get(self, path: str, reply: type[M], *, timeout_s: float | None = None, **query: Any) -> M:
        attempts = stamina.retry_context(on=UnavailableError, attempts=3, timeout=None, wait_initial=0.1, wait_max=0.5)
        async for attempt in attempts:
            with attempt:
                return self._parsed(await self.call("GET", path, params=query, timeout_s=timeout_s), reply)
        raise AssertionError("stamina leaves its loop by return or raise")

    async def get_list(self, path: str, item: type[M], **query: Any) -> list[M]:
        response = await self.call("GET", path, params=query)
        try:
            return TypeAdapter(list[item]).validate_json(response.content)  # pyright: ignore[reportInvalidTypeForm, reportUnknownVariableType]
        except ValidationError as error:
            raise self._not_the_contract(error) from error

    async def post(
        self,
        path: str,
        body: Message | bytes | None,
        reply: type[M],
        *,
        timeout_s: float | None = None,
        headers: dict[str, str] | None = None,
    ) -> M:
        return self._parsed(await self.call("POST", path, body=body, timeout_s=timeout_s, headers=headers), reply)

    async def put(self, path: str, body: Message, reply: type[M]) -> M:
        return self._parsed(await self.call("PUT", path, body=body), reply)

    async def delete(self, path: str, reply: type[M]) -> M:
        return self._parsed(await self.call("DELETE", path), reply)

    async def call(
        self,
        method: str,
        path: str,
        *,
        body: Message | bytes | None = None,
        params: dict[str, Any] | None = None,
        timeout_s: float | None = None,
        headers: dict[str, str] | None = None,
    ) -> httpx.Response:
        """The response when it is 2xx; otherwise raises as the class says."""
        if method == "GET" and self._refused is not None and time.monotonic() - self._refused_s < REFUSED_WAIT_S:
            raise UpstreamError(self.service, *self._refused)
        content = body.model_dump_json().encode() if isinstance(body, Message) else body
        kind = "application/json" if isinstance(body, Message) else "application/octet-stream"
        headers = (headers or {}) | ({"content-type": kind} if content is not None else {})
        timeout = httpx.Timeout(timeout_s, connect=1.0) if timeout_s is not None else httpx.USE_CLIENT_DEFAULT
        about = {"http.request.method": method, "url.path": path, "server.address": self.service}
        began_s, status = time.perf_counter(), 0
        with TRACER.part(f"{method} to {self.service}", about, kind=SpanKind.CLIENT) as span:
            try:
                response = await self._sent(
                    method, path, content=content, headers=headers, params=params, timeout=timeout
                )
            except UnavailableError as error:
                failed(span, error.said)
                raise
            else:
                status = response.status_code
                span.set_attribute("http.response.status_code", status)
            finally:
                CALLS.labels(self.service, method, str(status)).observe(time.perf_counter() - began_s)
        if response.is_success:
            return response
        detail, code = _problem(response)
        if response.status_code in {503, 504}:
            raise UnavailableError(self.service, detail, code=code)
        if method == "GET" and response.status_code in {401, 429}:
            self._refused, self._refused_s = (response.status_code, detail), time.monotonic()
        raise UpstreamError(self.service, response.status_code, detail, code=code)

    async def _sent(self, method: str, path: str, *, headers: dict[str, str], **request: Any) -> httpx.Response:
        """Whatever is answered. The trace it belongs to goes along."""
        if parent := traceparent():
            headers = headers | {"traceparent": parent}
        try:
            return await self.http.request(method, path, headers=headers, **request)
        except httpx.ConnectError as error:
            raise UnavailableError(self.service, "not reachable") from error
        except httpx.TimeoutException as error:
            raise ServiceTimeoutError(self.service, f"{method} {path} did not answer in time") from error
        except httpx.TransportError as error:
            raise UnavailableError(self.service, f"connection lost ({type(error).__name__})") from error

    async def dependency(self) -> Dependency:
        """This service as a line of somebody's `/ready`: is it ready itself, and does it warn of something?"""
        try:
            response = await self.http.get("/ready", timeout=1.0)
        except httpx.ReadTimeout as error:
            alive = await self._alive()
            return Dependency.of(self.service, ok=False, detail="not ready in time") if alive else self._away(error)
        except httpx.HTTPError as error:
            return self._away(error)
        if not response.is_success:
            return Dependency.of(self.service, ok=False, detail="not ready")
        warnings = _warnings(response)
        state = DependencyState.WARNING if warnings else DependencyState.READY
        return Dependency(name=self.service, state=state, detail=warnings)

    def _away(self, error: httpx.HTTPError) -> Dependency:
        detail = f"not reachable ({type(error).__name__})"
        return Dependency(name=self.service, state=DependencyState.UNREACHABLE, detail=detail)

    async def _alive(self) -> bool:
        """A `/ready` that is late may be waiting for a dependency of its own that hangs."""
        try:
            return (await self.http.get("/health", timeout=1.0)).is_success
        except httpx.HTTPError:
            return False

    def _parsed(self, response: httpx.Response, reply: type[M]) -> M:
        try:
            return reply.model_validate_json(response.content)
        except ValidationError as error:
            raise self._not_the_contract(error) from error

    def _not_the_contract(self, error: ValidationError) -> UpstreamError:
        return UpstreamError(self.service, 200, f"the answer is not the contract: {error.error_count()} errors")


def _warnings(ready: httpx.Response) -> str:
    """What a `/ready` warns of, in one line."""
    try:
        lines = Readiness.model_validate_json(ready.content).dependencies
    except ValidationError:
        return ""
    return "; ".join(f"{one.name}: {one.detail}" for one in lines if one.state is DependencyState.WARNING)


def _problem(response: httpx.Response) -> tuple[str, str]:
    """(detail, code) of what was answered, whoever answered it: a proxy's page has neither."""
    try:
        body = response.json()
    except ValueError:
        body = None
    fields = cast("dict[str, Any]", body) if isinstance(body, dict) else {}
    detail = fields.get("detail") or fields.get("title") or f"HTTP {response.status_code}"
    return str(detail), str(fields.get("code") or "")
