"""Each service slow, down, wrong or restarting: a named wait, a way round it, or an honest ending; never a hang."""

import pytest

from contracts.geometry import Pose2D
from contracts.mission import MissionState, Outcome
from contracts.topics import VISION_DETECTIONS
from contracts.vision import Detection, Detections
from support.coordinator_mesh import Mesh, OpenMesh
from support.coordinator_world import Thing

RED = Thing("bottle", "red", 3.5, 2.5)
FAR = Pose2D(x=7.5, y=6.0, yaw=0.7)
LATEST_S = 130.0
"""The mission's own limit and a little: whatever happens, it is over by then."""

CALLS = ["map", "navigate", "rotate", "drive"]


async def said(mesh: Mesh, mission_id: str) -> str:
    return "\n".join(event.text for event in await mesh.timeline(mission_id))


@pytest.mark.parametrize("call", ["rotate", "drive"])
async def test_a_bridge_that_never_answers_one_kind_of_call_ends_in_time_and_is_named(
    open_mesh: OpenMesh, call: str
) -> None:
    async with open_mesh(RED, views=(FAR,), mission_timeout_s=100.0) as mesh:
        mesh.robot.hangs = {call}
        mission = await mesh.until_over((await mesh.post_mission()).id, within_s=LATEST_S)
        assert mission.outcome is not None
        assert mission.report is not None
        assert mission.report.text
        here = mesh.world.pose
        await mesh.clock.advance(10.0)
        assert mesh.world.pose == here


async def test_boxes_that_nobody_measures_end_it_in_time_and_robot_bridge_is_named(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED, views=(FAR,), mission_timeout_s=100.0) as mesh:
        mesh.world.unmeasured = 1_000_000
        mission = await mesh.until_over((await mesh.post_mission()).id, within_s=LATEST_S)
        assert mission.outcome is Outcome.ABORTED
        assert "robot_bridge" in mission.reason
        assert "no answer within 0.3 s" in await said(mesh, mission.id)


@pytest.mark.parametrize("call", ["map", "navigate"])
async def test_a_bridge_that_fails_one_kind_of_call_ends_in_time_with_the_cause(open_mesh: OpenMesh, call: str) -> None:
    async with open_mesh(RED, views=(FAR,), mission_timeout_s=100.0) as mesh:
        mesh.robot.fail_next = {call: 10_000}
        mission = await mesh.until_over((await mesh.post_mission()).id, within_s=LATEST_S)
        assert mission.outcome is not None
        assert mission.outcome is not Outcome.ABORTED or "robot_bridge" in mission.reason


async def test_a_bridge_that_restarts_in_the_middle_is_waited_for_by_name(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED, views=(FAR,)) as mesh:
        mission = await mesh.post_mission()
        await mesh.clock.advance(5.0)
        mesh.robot.fail_next = dict.fromkeys(CALLS, 2)
        mesh.robot.lose_goals()
        await mesh.clock.advance(3.0)
        assert "robot_bridge" in (await mesh.client.get("/state")).json()[
            "waiting_for"
        ] or "robot_bridge" in await said(mesh, mission.id)
        assert (await mesh.until_over(mission.id)).outcome is Outcome.FOUND


async def test_a_silent_bus_aborts_within_its_limit_and_stops(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED, views=(FAR,)) as mesh:
        mission = await mesh.post_mission()
        await mesh.clock.advance(3.0)
        mesh.silence()
        ended = await mesh.until_over(mission.id, within_s=30.0)
        assert ended.outcome is Outcome.ABORTED
        assert "robot_bridge or Redis is down" in ended.reason


async def test_a_robot_that_loses_its_place_for_long_aborts_and_says_so(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        mission = await mesh.post_mission()
        await mesh.clock.advance(1.0)
        mesh.world.lost = True
        ended = await mesh.until_over(mission.id, within_s=120.0)
        assert ended.outcome is Outcome.ABORTED
        assert "has not known its position on the map" in ended.reason


async def test_a_memory_that_is_away_costs_its_hints_and_nothing_more(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED, views=(FAR,)) as mesh:
        mesh.memory.away = True
        mission = await mesh.until_over((await mesh.post_mission()).id)
        assert mission.outcome is Outcome.FOUND
        assert "memory is away" in await said(mesh, mission.id)


async def test_inference_that_cannot_read_a_command_is_503_and_starts_nothing(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        mesh.inference.reads = False
        answer = await mesh.client.post("/missions", json={"command": "find the red bottle"})
        assert answer.status_code == 503
        assert "inference" in answer.json()["detail"]
        assert (await mesh.client.get("/missions")).json() == []


async def test_frames_of_another_time_are_not_believed(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        mission = await mesh.post_mission()
        for seconds in (-100.0, 100.0):
            await mesh.bus.publish(VISION_DETECTIONS, lie(mesh.clock.now_s() + seconds))
            await mesh.clock.settle()
        assert (await mesh.client.get("/state")).json()["state"] == MissionState.SCANNING.value
        assert "possible match" not in await said(mesh, mission.id)


async def test_an_arrival_elsewhere_is_no_arrival(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED, views=(FAR,)) as mesh:
        mesh.robot.arrives_nowhere = 2
        mission = await mesh.until_over((await mesh.post_mission()).id)
        assert "said it arrived, but stands" in await said(mesh, mission.id)
        assert mission.outcome is Outcome.FOUND


def lie(stamp_s: float) -> Detections:
    seen = Detection(label="bottle", confidence=0.95, bbox_xyxy=(150.0, 100.0, 170.0, 140.0), colour="red")
    return Detections(stamp_s=stamp_s, image_width_px=320, image_height_px=240, detections=(seen,))
