"""What every service's FastAPI app has in common: problems, health, readiness, metrics, middleware."""

import asyncio
from collections.abc import AsyncGenerator, Awaitable, Callable, Collection, Mapping, Sequence
from contextlib import asynccontextmanager
from typing import Any, cast

import prometheus_client
from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import Response
from fastapi_offline import FastAPIOffline
from starlette.exceptions import HTTPException
from starlette.requests import HTTPConnection
from starlette.routing import Mount

from contracts.problem import Dependency, Health, Readiness
from mesh.access import AuthorizationMiddleware, Role, public, requires_role
from mesh.access.document import with_roles
from mesh.access.middleware import SessionAuthenticator
from mesh.errors import MeshError, TooManyError
from mesh.metrics import tell_ready
from mesh.middleware import BodyLimit, SameOrigin, Unbuffered
from mesh.problems import problem
from mesh.settings import ServiceSettings
from mesh.tracing import flush

Readies = Callable[[Request], Awaitable[Sequence[Dependency]]]
Measures = Callable[[Request], Awaitable[None]]

PROBLEM_RESPONSES: dict[int | str, dict[str, Any]] = {
    "4XX": {"description": "what was wrong with the request", "content": {"application/problem+json": {}}},
    "5XX": {"description": "which dependency failed", "content": {"application/problem+json": {}}},
}


def make_app(
    service: str,
    *,
    lifespan: Callable[[FastAPI], Any],
    dependencies: Readies,
    settings: ServiceSettings | None = None,
    authenticate_session: SessionAuthenticator | None = None,
    log_in_at: str | None = None,
    measure: Measures | None = None,
    body_bytes_max: int = 1_000_000,
    body_bytes_max_at: Mapping[str, int | None] | None = None,
    open_to_pages: Collection[str] = (),
    description: str = "",
) -> FastAPI:
    """A FastAPI app with the common routes, `/docs` from its own disk. `dependencies` is asked on `GET /ready` and
    `GET /metrics`, for which `measure` sets the service's own gauges.

    `body_bytes_max_at` names paths with a limit of their own; none = the route bounds what it reads of it itself.
    What web pages of another origin ask for is refused, but at the paths `open_to_pages`; see `SameOrigin`. Of its
    `settings` it takes who may (no settings: anybody may); `authenticate_session` and `log_in_at` are as
    `AuthorizationMiddleware` has them.
    """

    @asynccontextmanager
    async def whole_life(app: FastAPI) -> AsyncGenerator[Any]:
        async with lifespan(app) as state:
            yield state
        await asyncio.to_thread(flush)

    app = FastAPIOffline(
        redoc_url=None,
        title=f"atom {service}",
        description=description,
        version="0.1.0",
        lifespan=whole_life,
        responses=PROBLEM_RESPONSES,
        telemetry={"tracing": False, "metrics": False, "logs": False},  # a router asks for it: mesh.tracing.TracedRoute
    )
    app.openapi = with_roles(app)
    for docs in app.routes:  # what stands in docs/api anyway, and a page to try it with a key
        public(docs.app if isinstance(docs, Mount) else cast(Any, docs).endpoint)
    credentials = settings.credential_store() if settings is not None else None
    app.state.credentials = credentials
    app.state.ending = False
    app.add_middleware(
        AuthorizationMiddleware, credentials=credentials, authenticate_session=authenticate_session, log_in_at=log_in_at
    )
    app.add_middleware(Unbuffered)
    allowed = settings.origins_allowed if settings is not None else ()
    app.add_middleware(SameOrigin, allowed=allowed, open_paths=open_to_pages)
    app.add_middleware(BodyLimit, bytes_max=body_bytes_max, bytes_max_at=body_bytes_max_at or {})
    app.add_exception_handler(MeshError, _mesh_problem)
    app.add_exception_handler(RequestValidationError, _validation_problem)
    app.add_exception_handler(HTTPException, _http_problem)
    app.add_exception_handler(Exception, _unexpected_problem)

    @app.get("/health", tags=["operations"])
    @public
    async def health() -> Health:  # pyright: ignore[reportUnusedFunction]
        """The process answers."""
        return Health(service=service)

    @app.get("/ready", tags=["operations"], responses={503: {"model": Readiness}})
    @public
    async def ready(request: Request, response: Response) -> Readiness:  # pyright: ignore[reportUnusedFunction]
        """Its data is flowing; each dependency is named."""
        found = tuple(await dependencies(request))
        readiness = Readiness(ready=all(d.ok for d in found), service=service, dependencies=found)
        response.status_code = 200 if readiness.ready else 503
        return readiness

    @app.get("/metrics", tags=["operations"], include_in_schema=False)
    @requires_role(Role.VIEWER)
    async def metrics(request: Request) -> Response:  # pyright: ignore[reportUnusedFunction]
        tell_ready(service, await dependencies(request))
        if measure is not None:
            await measure(request)
        return Response(prometheus_client.generate_latest(), media_type=prometheus_client.CONTENT_TYPE_LATEST)

    return app


def is_ending(connection: HTTPConnection) -> bool:
    """Whether the process has been told to stop (`mesh.server`): what is cut off from then on nobody has cancelled."""
    return bool(connection.app.state.ending)


async def _mesh_problem(request: Request, error: Exception) -> Response:
    assert isinstance(error, MeshError)
    response = problem(error.status, error.title, error.detail, request.url.path, code=error.code)
    if isinstance(error, TooManyError):
        response.headers["Retry-After"] = "1"
    return response


async def _validation_problem(request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    detail = "; ".join(f"{'.'.join(str(part) for part in e['loc'])}: {e['msg']}" for e in error.errors()[:10])
    return problem(422, "Malformed request", detail, request.url.path)


async def _http_problem(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    response = problem(error.status_code, str(error.detail), "", request.url.path)
    response.headers.update(error.headers or {})
    return response


async def _unexpected_problem(request: Request, error: Exception) -> Response:
    return problem(500, "Internal error", type(error).__name__, request.url.path)
