"""Spans as lines of JSON in a file, for `make trace`: what is recorded without a collector."""

import json
import logging
from collections.abc import Sequence
from logging.handlers import RotatingFileHandler
from pathlib import Path
from typing import Any

from opentelemetry.sdk.trace import ReadableSpan
from opentelemetry.sdk.trace.export import SpanExporter, SpanExportResult
from opentelemetry.trace import format_span_id, format_trace_id

FILE_BYTES_MAX = 20_000_000


class SpanFile(SpanExporter):
    """The file is begun anew when it is full; the one before it is kept beside it."""

    def __init__(self, path: Path) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        self._file = RotatingFileHandler(path, maxBytes=FILE_BYTES_MAX, backupCount=1, encoding="utf-8")

    def export(self, spans: Sequence[ReadableSpan]) -> SpanExportResult:
        for span in spans:
            self._file.emit(logging.makeLogRecord({"msg": json.dumps(line_of(span))}))
        return SpanExportResult.SUCCESS

    def shutdown(self) -> None:
        self._file.close()


def line_of(span: ReadableSpan) -> dict[str, Any]:
    """Times in ns since the epoch. `module` began the span; one of the mesh's plumbing is of its parent's service."""
    own, scope = span.get_span_context(), span.instrumentation_scope
    return {
        "trace_id": format_trace_id(own.trace_id) if own is not None else "",
        "span_id": format_span_id(own.span_id) if own is not None else "",
        "parent_id": format_span_id(span.parent.span_id) if span.parent is not None else "",
        "service": span.resource.attributes.get("service.name", ""),
        "module": scope.name if scope is not None else "",
        "name": span.name,
        "start_ns": span.start_time,
        "end_ns": span.end_time,
        "failed": "" if span.status.is_ok or span.status.is_unset else (span.status.description or "failed"),
        "attributes": dict(span.attributes or {}),
        "events": [
            {"name": event.name, "stamp_ns": event.timestamp, "attributes": dict(event.attributes or {})}
            for event in span.events
        ],
    }
