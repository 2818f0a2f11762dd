"""Spans as they are recorded, kept in memory. OpenTelemetry takes one provider a process: it records while asked to."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from opentelemetry import trace
from opentelemetry.context import Context
from opentelemetry.sdk.trace import ReadableSpan, TracerProvider
from opentelemetry.sdk.trace.export import SimpleSpanProcessor
from opentelemetry.sdk.trace.export.in_memory_span_exporter import InMemorySpanExporter
from opentelemetry.sdk.trace.sampling import ALWAYS_OFF, DEFAULT_ON, Sampler, SamplingResult


class Switch(Sampler):
    """As the SDK's own: what follows a trace that is not sampled is not recorded either."""

    def __init__(self) -> None:
        self.on = False

    def should_sample(
        self, parent_context: Context | None, trace_id: int, name: str, *rest: Any, **more: Any
    ) -> SamplingResult:
        return (DEFAULT_ON if self.on else ALWAYS_OFF).should_sample(parent_context, trace_id, name, *rest, **more)

    def get_description(self) -> str:
        return "a switch"


SWITCH, KEPT = Switch(), InMemorySpanExporter()


@contextmanager
def recorded_spans() -> Iterator["Spans"]:
    if not isinstance(trace.get_tracer_provider(), TracerProvider):
        provider = TracerProvider(sampler=SWITCH)
        provider.add_span_processor(SimpleSpanProcessor(KEPT))
        trace.set_tracer_provider(provider)
    KEPT.clear()
    SWITCH.on = True
    try:
        yield Spans()
    finally:
        SWITCH.on = False


class Spans:
    """Those that have ended."""

    def all(self) -> Sequence[ReadableSpan]:
        return KEPT.get_finished_spans()

    def names(self) -> list[str]:
        return [span.name for span in self.all()]

    def one(self, name: str) -> ReadableSpan:
        (found,) = [span for span in self.all() if span.name == name]
        return found


def parent_of(span: ReadableSpan) -> int:
    """The parent's span id; 0 where it begins its trace."""
    return span.parent.span_id if span.parent is not None else 0


def id_of(span: ReadableSpan) -> int:
    own = span.get_span_context()
    assert own is not None
    return own.span_id


def trace_of(span: ReadableSpan) -> str:
    own = span.get_span_context()
    assert own is not None
    return trace.format_trace_id(own.trace_id)
