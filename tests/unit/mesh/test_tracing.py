"""A command begins a trace, everything else follows one; the ids travel whether anybody records or not."""

import json
from collections.abc import Iterator
from pathlib import Path
from threading import Event
from unittest.mock import Mock

import pytest
from opentelemetry.trace import NoOpTracer

from mesh import tracing
from mesh.span_file import SpanFile
from mesh.tracing import Tracer, add_trace_id, following, inside, trace_id, trace_id_of, traceparent
from support.spans import Spans, id_of, parent_of, recorded_spans, trace_of

TRACER = Tracer("sample.module")
OTHERS = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01"


@pytest.fixture
def spans() -> Iterator[Spans]:
    with recorded_spans() as spans:
        yield spans


def test_outside_a_trace_nothing_is_recorded_and_nothing_travels(spans: Spans) -> None:
    with TRACER.part("a look round"):
        assert (trace_id(), traceparent()) == ("", "")
    assert spans.names() == []


def test_a_command_begins_a_trace_and_what_is_inside_belongs_to_it(spans: Spans) -> None:
    with TRACER.command("find the cup"):
        within = trace_id()
        with TRACER.part("ask"):
            pass
    command, part = spans.one("find the cup"), spans.one("ask")
    assert {trace_of(command), trace_of(part)} == {within}
    assert (parent_of(command), parent_of(part)) == (0, id_of(command))
    assert trace_id() == ""


def test_a_command_given_inside_a_trace_belongs_to_it(spans: Spans) -> None:
    with following(OTHERS), TRACER.command("find the cup"):
        pass
    assert trace_of(spans.one("find the cup")) == "0af7651916cd43dd8448eb211c80319c"


def test_where_nobody_records_a_command_has_an_id_all_the_same() -> None:
    with TRACER.command("find the cup"):
        first = trace_id()
        with TRACER.part("ask"):
            assert trace_id() == first
            assert traceparent().startswith(f"00-{first}-")
    with TRACER.command("find the cup"):
        assert trace_id() not in {"", first}


def test_a_trace_that_began_where_nobody_records_is_recorded_further_down(
    spans: Spans, monkeypatch: pytest.MonkeyPatch
) -> None:
    elsewhere = Tracer("sample.elsewhere")
    monkeypatch.setattr(elsewhere, "_tracer", NoOpTracer())
    with elsewhere.command("find the cup"):
        brought = traceparent()
    with following(brought), TRACER.part("ask"):
        pass
    assert trace_of(spans.one("ask")) == trace_id_of(brought)


@pytest.mark.parametrize("malformed", ["", "00-abc", "00-" + 32 * "0" + "-" + 16 * "0" + "-01", "ff" + OTHERS[2:]])
def test_what_is_no_traceparent_is_followed_nowhere(malformed: str) -> None:
    with following(OTHERS), following(malformed):
        assert trace_id() == ""


def test_an_open_span_is_ended_by_whoever_began_it(spans: Spans) -> None:
    span = TRACER.begin("a drive")
    with inside(span), TRACER.part("its first metre"):
        pass
    assert spans.names() == ["its first metre"]
    span.end()
    assert parent_of(spans.one("its first metre")) == id_of(spans.one("a drive"))


def test_a_log_line_says_in_which_trace_it_was_written() -> None:
    assert add_trace_id(None, "info", {"event": "resting"}) == {"event": "resting"}
    with following(OTHERS):
        assert add_trace_id(None, "info", {})["trace_id"] == "0af7651916cd43dd8448eb211c80319c"


def test_a_span_is_a_line_of_a_file(spans: Spans, tmp_path: Path) -> None:
    with following(OTHERS), TRACER.part("drive", {"metres": 1.5}) as span:
        span.add_event("first twist", {"linear_x": 0.2})
        tracing.failed(span, "an obstacle")
    file = tmp_path / "new" / "sample.jsonl"
    writer = SpanFile(file)
    writer.export(spans.all())
    writer.shutdown()
    (line,) = [json.loads(one) for one in file.read_text().splitlines()]
    assert line["trace_id"] == "0af7651916cd43dd8448eb211c80319c"
    assert (line["parent_id"], line["module"], line["name"]) == ("b7ad6b7169203331", "sample.module", "drive")
    assert (line["attributes"], line["failed"]) == ({"metres": 1.5}, "an obstacle")
    assert line["events"][0]["attributes"] == {"linear_x": 0.2}
    assert line["start_ns"] <= line["events"][0]["stamp_ns"] <= line["end_ns"]


def test_a_folder_that_cannot_be_written_keeps_no_service_from_starting(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("no folder")
    monkeypatch.setenv("ATOM_TRACES", str(tmp_path / "file"))
    before = tracing.trace.get_tracer_provider()
    tracing.configure_tracing("sample")
    assert tracing.trace.get_tracer_provider() is before


def test_the_end_does_not_wait_for_a_collector_that_never_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    answered, over, given_up = Event(), Event(), []

    def force_flush(_: int) -> None:
        given_up.append(not answered.wait(3.0))
        over.set()

    monkeypatch.setattr(tracing, "EXPORT_S_MAX", 0.05)
    monkeypatch.setattr(tracing.trace, "get_tracer_provider", lambda: Mock(force_flush=force_flush))
    tracing.flush()
    answered.set()
    assert over.wait(3.0)
    assert given_up == [False]
