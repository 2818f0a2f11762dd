"""A mission is of the trace of the command it came from, from the first word to its ending, and says which."""

from collections.abc import Iterator

import pytest
from opentelemetry.trace import StatusCode

from contracts.mission import Mission, MissionState, Outcome
from contracts.topics import MISSION_EVENTS, MISSION_TARGET
from coordinator.core.mission import Mission as CoreMission
from coordinator.core.rules import Rules
from coordinator.execution.mission_trace import MissionTrace
from support.coordinator_mesh import OpenMesh
from support.coordinator_world import Thing
from support.spans import Spans, id_of, parent_of, recorded_spans, trace_of

RED = Thing("bottle", "red", 3.5, 2.5)
OTHERS = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01"


@pytest.fixture
def spans() -> Iterator[Spans]:
    with recorded_spans() as spans:
        yield spans


async def test_a_mission_is_one_span_with_its_states_inside_and_names_its_trace(
    open_mesh: OpenMesh, spans: Spans
) -> None:
    async with open_mesh(RED) as mesh:
        mission = await mesh.until_over((await mesh.post_mission()).id)
    command, whole = spans.one("command"), spans.one("mission")
    states = [one for one in spans.all() if one.name in set(MissionState)]
    assert {trace_of(one) for one in (command, whole, *states)} == {mission.trace_id}
    assert {parent_of(one) for one in states} == {id_of(whole)}
    assert parent_of(whole) == id_of(command)
    assert {"SCANNING", "DEPTH_CHECK", "APPROACHING"} <= {one.name for one in states}
    assert whole.attributes is not None
    assert (whole.attributes["mission.id"], whole.attributes["mission.outcome"]) == (mission.id, "found")


@pytest.mark.parametrize(
    ("outcome", "fault"),
    [(one, one in {Outcome.ABORTED, Outcome.INTERRUPTED}) for one in Outcome],
)
def test_a_mission_that_could_not_go_on_failed_and_one_that_found_nothing_or_was_cancelled_did_not(
    spans: Spans, outcome: Outcome, fault: bool
) -> None:
    trace = MissionTrace()
    mission = CoreMission(Rules(), id="m-1", outcome=outcome)
    trace.begin("m-1", "find the cup")
    trace.leave(mission, now_s=2.0)
    assert (spans.one("mission").status.status_code is StatusCode.ERROR) is fault


async def test_a_mission_that_waited_is_of_its_own_commands_trace(open_mesh: OpenMesh, spans: Spans) -> None:
    async with open_mesh(RED) as mesh:
        first, second = await mesh.post_mission(), await mesh.post_mission("find the blue cup")
        assert second.queue_position == 0
        assert second.trace_id not in {"", first.trace_id}
        await mesh.until_over(first.id)
        await mesh.until_state(MissionState.SCANNING)
        assert (await mesh.mission(second.id)).trace_id == second.trace_id


async def test_what_is_told_of_a_mission_is_told_in_its_trace(open_mesh: OpenMesh, spans: Spans) -> None:
    async with open_mesh(RED) as mesh:
        mission = await mesh.until_over((await mesh.post_mission()).id)
    for topic in (MISSION_TARGET, MISSION_EVENTS):
        assert any(mission.trace_id in parent for parent in mesh.bus.said_in(topic))


async def test_a_command_that_brings_a_trace_goes_on_with_it(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        body, brought = {"command": "find the red bottle"}, {"traceparent": OTHERS}
        answer = await mesh.client.post("/missions", json=body, headers=brought)
        assert answer.json()["trace_id"] == "0af7651916cd43dd8448eb211c80319c"


async def test_a_mission_has_an_id_where_nobody_records(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        mission = await mesh.until_over((await mesh.post_mission()).id)
    assert len(mission.trace_id) == 32


def test_a_stored_mission_of_before_there_were_traces_still_opens() -> None:
    stored = '{"id":"m1","command":"find the cup","state":"DONE","outcome":"found","started_s":1.0}'
    assert Mission.model_validate_json(stored).trace_id == ""
