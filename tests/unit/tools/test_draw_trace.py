"""A mission's spans as a picture in letters and in colours."""

import json
from pathlib import Path
from typing import Any

import draw_trace
import pytest

HEAD = {"trace_id": "t1", "failed": "", "attributes": {}, "events": []}
TWIST = {
    "name": "twist",
    "stamp_ns": 4_000_000_000,
    "attributes": {"source": "rotate", "linear_x": 0.0, "angular_z": 0.8},
}


def line(span_id: str, parent_id: str, module: str, name: str, start_s: float, end_s: float, **more: Any) -> str:
    about = {"span_id": span_id, "parent_id": parent_id, "service": "mesh", "module": module, "name": name}
    return json.dumps(HEAD | about | {"start_ns": int(start_s * 1e9), "end_ns": int(end_s * 1e9)} | more)


MISSION = {"mission.id": "abc123", "mission.command": "find the cup", "mission.outcome": "found"}
LINES = [
    line("a", "", "coordinator.commands", "command", 0.0, 1.0),
    line("b", "a", "coordinator.execution", "mission", 1.0, 9.0, attributes=MISSION),
    line("c", "b", "mesh.http", "POST to robot_bridge", 2.0, 6.0),
    line("d", "c", "robot_bridge.routes.motion", "POST /rotate", 3.0, 5.0, events=[TWIST]),
    line("e", "b", "mesh.http", "POST to robot_bridge", 6.0, 8.0),
    line("f", "e", "robot_bridge.routes.motion", "POST /rotate", 6.5, 7.5),
    line("g", "b", "mesh.http", "GET to memory", 8.0, 8.5, failed="not reachable"),
    line("z", "", "coordinator.commands", "command", 0.0, 1.0, trace_id="another"),
]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "coordinator.jsonl").write_text("\n".join(LINES[:3]) + "\n", encoding="utf-8")
    (tmp_path / "robot_bridge.jsonl.1").write_text("\n".join(LINES[3:]) + "\n", encoding="utf-8")
    return tmp_path


def test_the_spans_of_a_mission_come_from_every_services_file(folder: Path) -> None:
    whole, spans = draw_trace.of_mission(draw_trace.spans_in(folder), "abc")
    assert (whole.span_id, len(spans)) == ("b", 7)


def test_a_mission_that_was_not_recorded_is_named(folder: Path) -> None:
    with pytest.raises(draw_trace.NoSuchTraceError, match="no mission 'xyz' among 8 spans"):
        draw_trace.of_mission(draw_trace.spans_in(folder), "xyz")


def test_a_sister_mission_of_the_same_command_is_left_out(folder: Path) -> None:
    sister = MISSION | {"mission.id": "def456"}
    lines = [
        line("s", "a", "coordinator.execution", "mission", 9.0, 12.0, attributes=sister),
        line("t", "s", "robot_bridge.routes.motion", "POST /rotate", 10.0, 11.0),
    ]
    (folder / "later.jsonl").write_text("\n".join(lines) + "\n", encoding="utf-8")
    drawn = {name: draw_trace.of_mission(draw_trace.spans_in(folder), name)[1] for name in ("abc", "def")}
    assert sorted(one.span_id for one in drawn["abc"]) == ["a", "b", "c", "d", "e", "f", "g"]
    assert sorted(one.span_id for one in drawn["def"]) == ["a", "s", "t"]


def test_a_line_that_is_being_written_is_left_out(folder: Path) -> None:
    with (folder / "coordinator.jsonl").open("a", encoding="utf-8") as file:
        file.write(LINES[0][: len(LINES[0]) // 2])
    assert len(draw_trace.spans_in(folder)) == len(LINES)


def test_a_call_and_its_handling_are_one_line_and_what_is_done_again_is_the_same_line(folder: Path) -> None:
    _, spans = draw_trace.of_mission(draw_trace.spans_in(folder), "")
    rows = draw_trace.rows_of(spans)
    assert [(row.service, row.label) for row in rows] == [
        ("coordinator", "command"),
        ("coordinator", "  mission"),
        ("robot_bridge", "    POST /rotate x2"),
        ("coordinator", "    GET to memory"),
    ]


def test_the_text_shows_when_the_wheels_turned_and_what_failed(folder: Path) -> None:
    whole, spans = draw_trace.of_mission(draw_trace.spans_in(folder), "")
    text = draw_trace.told(whole, draw_trace.rows_of(spans))
    assert "'find the cup': found after 8.0 s; trace t1" in text
    assert "the wheels turned 4.000 s after the first word: 0.00 m/s, 0.80 rad/s for POST /rotate (rotate)" in text
    assert "x" in text.partition("GET to memory")[2].partition("|")[2].partition("|")[0]


def test_the_picture_is_written(folder: Path, tmp_path: Path) -> None:
    whole, spans = draw_trace.of_mission(draw_trace.spans_in(folder), "")
    draw_trace.draw(whole, draw_trace.rows_of(spans), tmp_path / "pictures" / "abc.png")
    assert (tmp_path / "pictures" / "abc.png").read_bytes().startswith(b"\x89PNG")
