"""One trace from a person's words to the wheels: W3C trace context over HTTP and the bus, whoever records it or nobody.

A command begins a trace, everything else only follows one: what the services do at rest belongs to none. Spans are
recorded where `ATOM_TRACES` names a folder or `OTEL_EXPORTER_OTLP_ENDPOINT` a collector; elsewhere only ids travel.
"""

import os
import secrets
import threading
from collections.abc import Awaitable, Callable, Coroutine, Generator, Mapping, MutableMapping
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any

import structlog
from fastapi import Request, Response
from fastapi.exceptions import RequestValidationError
from fastapi.routing import APIRoute
from opentelemetry import context, trace
from opentelemetry.context import Context
from opentelemetry.trace import NonRecordingSpan, Span, SpanContext, SpanKind, StatusCode, TraceFlags
from opentelemetry.trace.propagation.tracecontext import TraceContextTextMapPropagator
from starlette.exceptions import HTTPException

from mesh.errors import MeshError

log = structlog.get_logger()

NO_SPAN: Span = trace.INVALID_SPAN
EXPORT_S_MAX = 2.0
"""A collector that does not answer holds up the end of a process for no longer."""

Attributes = Mapping[str, str | int | float | bool]

_W3C = TraceContextTextMapPropagator()


def configure_tracing(service: str) -> None:
    """Records this process's spans where the environment names a place for them. Once a process."""
    folder = os.environ.get("ATOM_TRACES", "")
    collector = os.environ.get("OTEL_EXPORTER_OTLP_TRACES_ENDPOINT") or os.environ.get("OTEL_EXPORTER_OTLP_ENDPOINT")
    if not folder and not collector:
        return
    from opentelemetry.sdk.resources import Resource
    from opentelemetry.sdk.trace import TracerProvider
    from opentelemetry.sdk.trace.export import BatchSpanProcessor, SpanExporter

    exporters: list[SpanExporter] = []
    if folder:
        from mesh.span_file import SpanFile

        try:
            exporters.append(SpanFile(Path(folder) / f"{service}.jsonl"))
        except OSError as error:
            log.warning("no spans are written to the folder of ATOM_TRACES", error=str(error))
    if collector:
        from opentelemetry.exporter.otlp.proto.http.trace_exporter import OTLPSpanExporter

        exporters.append(OTLPSpanExporter(timeout=EXPORT_S_MAX))
    if not exporters:
        return
    provider = TracerProvider(resource=Resource.create({"service.name": service}), shutdown_on_exit=False)
    for exporter in exporters:
        provider.add_span_processor(BatchSpanProcessor(exporter))
    trace.set_tracer_provider(provider)


def flush() -> None:
    """Blocks until what was recorded is written, or can not be, or the time for it is up. The SDK heeds no time."""
    if (write := getattr(trace.get_tracer_provider(), "force_flush", None)) is not None:
        writing = threading.Thread(target=write, args=(int(EXPORT_S_MAX * 1000),), name="flush-spans", daemon=True)
        writing.start()
        writing.join(EXPORT_S_MAX)


class Tracer:
    """Spans of one module: `TRACER = Tracer(__name__)`. The package the module is of names the service."""

    def __init__(self, module: str) -> None:
        self._tracer = trace.get_tracer(module)

    def begin(self, name: str, attributes: Attributes | None = None) -> Span:
        """An open span of the current trace, which whoever began it ends; where there is none, a trace begins."""
        span = self._tracer.start_span(name, attributes=attributes)
        return span if span.get_span_context().is_valid else NonRecordingSpan(_new())

    @contextmanager
    def command(self, name: str, attributes: Attributes | None = None) -> Generator[Span]:
        """As `begin`; everything inside belongs to it."""
        span = self.begin(name, attributes)
        try:
            with inside(span):
                yield span
        finally:
            span.end()

    @contextmanager
    def part(
        self, name: str, attributes: Attributes | None = None, *, kind: SpanKind = SpanKind.INTERNAL
    ) -> Generator[Span]:
        """A span of the current trace; where there is none, none begins."""
        if not trace.get_current_span().get_span_context().is_valid:
            yield NO_SPAN
            return
        with self._tracer.start_as_current_span(
            name, kind=kind, attributes=attributes, record_exception=False, set_status_on_exception=False
        ) as span:
            yield span


def inside(span: Span) -> AbstractContextManager[Span]:
    """What runs in the block belongs to the span, which stays open."""
    return trace.use_span(span, record_exception=False, set_status_on_exception=False)


def current_span() -> Span:
    return trace.get_current_span()


def failed(span: Span, why: str) -> None:
    span.set_status(StatusCode.ERROR, why)


def traceparent() -> str:
    """Of the current span, as W3C writes it; '' where there is none."""
    carrier: dict[str, str] = {}
    _W3C.inject(carrier)
    return carrier.get("traceparent", "")


def trace_id() -> str:
    """Of the current trace, 32 hexadecimal digits; '' where there is none."""
    here = trace.get_current_span().get_span_context()
    return trace.format_trace_id(here.trace_id) if here.is_valid else ""


def trace_id_of(parent: str) -> str:
    """Of a traceparent; '' for ''."""
    return parent[3:35]


@contextmanager
def following(parent: str) -> Generator[None]:
    """What runs in the block belongs to the trace of this traceparent; to none where it is '' or malformed."""
    token = context.attach(_W3C.extract({"traceparent": parent}, Context()))
    try:
        yield
    finally:
        context.detach(token)


def add_trace_id(_: Any, __: str, line: MutableMapping[str, Any]) -> MutableMapping[str, Any]:
    """A processor of structlog: a line that is logged inside a trace says which."""
    if here := trace_id():
        line["trace_id"] = here
    return line


class TracedRoute(APIRoute):
    """`APIRouter(route_class=TracedRoute)`: a request that brings a trace is handled inside it.

    A router that does not ask for it is handled without a step of this: so is the emergency stop's.
    """

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        handle, tracer = super().get_route_handler(), Tracer(self.endpoint.__module__)

        async def traced(request: Request) -> Response:
            parent = request.headers.get("traceparent", "")
            if not parent:
                return await handle(request)
            about = {"http.request.method": request.method, "http.route": self.path_format}
            with (
                following(parent),
                tracer.part(f"{request.method} {self.path_format}", about, kind=SpanKind.SERVER) as span,
            ):
                return await _answered(handle(request), span)

        return traced


async def _answered(answer: Awaitable[Response], span: Span) -> Response:
    try:
        response = await answer
    except Exception as error:
        status = _status_of(error)
        span.set_attribute("http.response.status_code", status)
        if status >= 500:
            failed(span, str(error))
        raise
    span.set_attribute("http.response.status_code", response.status_code)
    return response


def _status_of(error: Exception) -> int:
    """As `mesh.app` will answer it."""
    match error:
        case MeshError():
            return error.status
        case HTTPException():
            return error.status_code
        case RequestValidationError():
            return 422
        case _:
            return 500


def _new() -> SpanContext:
    """Sampled: who records further down does, though nobody does here."""
    sampled = TraceFlags(TraceFlags.SAMPLED)
    return SpanContext(secrets.randbits(128) or 1, secrets.randbits(64) or 1, is_remote=False, trace_flags=sampled)
