"""Which command made the wheels turn: each has a span in its caller's trace, with the first velocity sent for it."""

from collections.abc import Iterator
from typing import Any

import pytest
from opentelemetry.sdk.trace.export import SimpleSpanProcessor
from opentelemetry.trace import StatusCode

from contracts.robot import GoalStatus, Priority
from contracts.topics import ROBOT_NAVIGATION
from robot_bridge.navigation import goal_executor
from robot_bridge.safety.emergency_stop import LatchFile
from support.bridge_behaviour import INSIDE, Rig
from support.spans import Spans, recorded_spans, trace_of
from support.waiting import until

TRACE_ID = "0af7651916cd43dd8448eb211c80319c"
BROUGHT = {"traceparent": f"00-{TRACE_ID}-b7ad6b7169203331-01"}


@pytest.fixture
def spans() -> Iterator[Spans]:
    with recorded_spans() as spans:
        yield spans


def twist_of(spans: Spans, name: str) -> dict[str, Any]:
    span = spans.one(name)
    assert trace_of(span) == TRACE_ID
    (event,) = span.events
    return dict(event.attributes or {})


async def test_a_goal_tells_the_first_velocity_that_was_sent_for_it(rig: Rig, spans: Spans) -> None:
    body = {"candidates": [{"pose": INSIDE}], "epoch": 0}
    goal = (await rig.client.post("/navigation/goals", json=body, headers=BROUGHT)).json()["id"]
    await until(lambda: rig.toy.has_driven)
    await rig.client.delete(f"/navigation/goals/{goal}")
    await rig.ended(goal, GoalStatus.CANCELED)
    twist = twist_of(spans, "goal")
    assert (twist["source"], twist["linear_x"] > 0.0) == ("cmd_vel_nav", True)
    told = spans.one("goal").attributes or {}
    assert (told["goal.id"], told["goal.status"]) == (goal, "CANCELED")
    assert all(TRACE_ID in parent for parent in rig.bus.said_in(ROBOT_NAVIGATION))


@pytest.mark.parametrize(
    ("status", "fault"),
    [
        (GoalStatus.SUCCEEDED, False), (GoalStatus.CANCELED, False), (GoalStatus.ABORTED, True),
        (GoalStatus.REJECTED, True), (GoalStatus.TIMED_OUT, True),
    ],
)  # fmt: skip
def test_a_goal_that_could_not_be_reached_failed_and_one_that_was_cancelled_did_not(
    spans: Spans, status: GoalStatus, fault: bool
) -> None:
    goal_executor._record(goal_executor.TRACER.begin("goal"), {"goal.status": status, "goal.cause": "nav2"}, 1.0)
    assert (spans.one("goal").status.status_code is StatusCode.ERROR) is fault


async def test_a_turn_tells_the_first_velocity_that_was_sent_for_it(rig: Rig, spans: Spans) -> None:
    body = {"angle_rad": 0.5, "speed_rad_s": 1.0, "timeout_s": 10.0, "epoch": 0}
    assert (await rig.client.post("/rotate", json=body, headers=BROUGHT)).is_success
    twist = twist_of(spans, "rotate")
    assert (twist["source"], twist["angular_z"] > 0.0) == ("rotate", True)


async def test_a_lease_tells_what_was_sent_for_it(rig: Rig, spans: Spans) -> None:
    body = {"twist": {"linear_x": 0.2}, "source": "test", "epoch": 0, "duration_s": 1.0}
    assert (await rig.client.post("/velocity", json=body, headers=BROUGHT)).is_success
    assert twist_of(spans, "POST /velocity")["source"] == "test"


async def test_a_lease_is_credited_with_no_motion_of_another(rig: Rig, spans: Spans) -> None:
    await rig.velocity(source="before", priority=Priority.EXPLORATION)
    await until(lambda: rig.toy.has_driven)
    body = {"twist": {"linear_x": 0.2}, "source": "test", "epoch": 0, "duration_s": 0.5}
    assert (await rig.client.post("/velocity", json=body, headers=BROUGHT)).json()["source"] == "before"
    assert spans.one("POST /velocity").events == ()


async def test_a_lease_that_stands_still_moved_nothing(rig: Rig, spans: Spans) -> None:
    body = {"twist": {"linear_x": 0.0}, "source": "test", "epoch": 0, "duration_s": 0.5}
    assert (await rig.client.post("/velocity", json=body, headers=BROUGHT)).json()["source"] == "test"
    assert spans.one("POST /velocity").events == ()


async def test_the_emergency_stop_leaves_no_span(rig: Rig, spans: Spans) -> None:
    for path in ("/emergency-stop", "/emergency-stop/reset", "/halt"):
        assert (await rig.client.post(path, headers=BROUGHT)).is_success
    await until(lambda: rig.toy.at_rest)
    assert spans.names() == []


async def test_no_span_is_ended_before_the_stop_is_stored_and_none_fails_it(
    rig: Rig, spans: Spans, monkeypatch: pytest.MonkeyPatch
) -> None:
    goal = (await rig.goal()).json()["id"]
    stored: list[bool] = []

    def fails(*_: Any) -> None:
        stored.append(LatchFile(rig.settings.state_dir).load(now_s=0.0).latched)
        raise RuntimeError("a span processor's own fault")

    monkeypatch.setattr(SimpleSpanProcessor, "on_end", fails)
    assert (await rig.client.post("/emergency-stop")).is_success
    assert await rig.goal_status(goal) is GoalStatus.CANCELED
    await until(lambda: stored == [True])
