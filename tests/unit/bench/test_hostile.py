"""What `bench.hostile` counts as a fault."""

import json
from pathlib import Path

import pytest

from bench.hostile import POSTS, Tally, too_late_a_frame
from bench.hostility.drawing import Request
from demo.stack import Ports, Stack

NOW_S = 1000.0


@pytest.mark.parametrize(
    ("body", "meant"),
    [
        (b'{"after_stamp_s": 1001.0}', True),
        (b'{"after_stamp_s": 999.0}', False),
        (b'{"after_stamp_s": null}', False),
        (b'{"after_stamp_s": "late"}', False),
        (b"{}", False),
        (b"[]", False),
        (b"\xff", False),
    ],
)
def test_a_timeout_of_validate_is_meant_only_where_a_later_frame_was_asked_for(body: bytes, meant: bool) -> None:
    request = Request("POST", "/validate", body=body)
    assert too_late_a_frame("inference", request, "504", now_s=NOW_S) is meant


def test_no_other_timeout_is_meant() -> None:
    body = json.dumps({"after_stamp_s": 2 * NOW_S}).encode()
    assert not too_late_a_frame("inference", Request("POST", "/detect", body=body), "504", now_s=NOW_S)
    assert not too_late_a_frame("memory", Request("POST", "/validate", body=body), "504", now_s=NOW_S)
    assert not too_late_a_frame("inference", Request("POST", "/validate", body=body), "500", now_s=NOW_S)


def test_a_timeout_is_a_fault_unless_it_is_meant() -> None:
    tally = Tally(10, 1.0)
    tally.take("inference", "POST /validate", "504", meant=True)
    assert not tally.failed
    tally.take("inference", "POST /validate", "504")
    assert tally.failed.total() == 1


def test_every_service_of_a_mesh_with_speech_is_sent_bodies(tmp_path: Path) -> None:
    stack = Stack(Ports(), tmp_path, tmp_path / "home.json", 1, speech=True)
    assert POSTS.keys() == stack.calls.keys()
