"""A search as the robot is delivered: by belief, driven up to at once; stopped, failed and told honestly as ever."""

import pytest

from contracts.geometry import Pose2D
from contracts.mission import EndCause, MissionState, Outcome
from coordinator.settings import Settings
from support.coordinator_mesh import OpenMesh
from support.coordinator_world import Thing
from support.mission_script import AS_DELIVERED

RED = Thing("bottle", "red", 3.5, 2.5)
FAR = Thing("bottle", "red", 8.5, 6.8)
SEEN_FROM = Pose2D(x=7.5, y=6.0, yaw=0.7)


def test_what_is_delivered_is_one_belief_the_direct_approach_and_evidence() -> None:
    told = Settings().model_dump(mode="json", include=set(AS_DELIVERED))
    assert told == {
        "coverage_rule": "belief", "approach_rule": "direct", "validation_rule": "evidence", "approach_speed_m_s": 0.2,
    }  # fmt: skip


async def test_it_is_found_and_each_place_was_chosen_by_belief(open_mesh: OpenMesh) -> None:
    async with open_mesh(FAR, views=(SEEN_FROM,), **AS_DELIVERED) as mesh:
        mission = await mesh.until_over((await mesh.post_mission()).id)
        assert mission.outcome is Outcome.FOUND
        assert mesh.away_m(FAR) <= 0.5
        said = [event.text for event in await mesh.timeline(mission.id)]
        assert any("that it is here" in text for text in said)


async def test_nothing_is_said_to_be_missing_from_a_place_that_was_not_looked_at(open_mesh: OpenMesh) -> None:
    async with open_mesh(FAR, **AS_DELIVERED) as mesh:
        mission = await mesh.until_over((await mesh.post_mission()).id)
        said = [event.text for event in await mesh.timeline(mission.id)]
        first_look = next(k for k, text in enumerate(said) if text.startswith("there: looking"))
        assert not any("nothing found" in text for text in said[:first_look])


async def test_what_is_not_there_is_not_found_with_the_share_and_how_sure_it_is(open_mesh: OpenMesh) -> None:
    async with open_mesh(**AS_DELIVERED) as mesh:
        mission = await mesh.until_over((await mesh.post_mission()).id)
        assert mission.outcome is Outcome.NOT_FOUND
        assert "sure that it is not here" in mission.reason
        assert mission.report is not None
        assert mission.report.looked_share is not None


@pytest.mark.parametrize("state", [MissionState.MOVING_TO_SCAN, MissionState.SCANNING, MissionState.APPROACHING])
async def test_an_emergency_stop_aborts_and_nothing_moves_afterwards(open_mesh: OpenMesh, state: MissionState) -> None:
    async with open_mesh(FAR, **AS_DELIVERED) as mesh:
        mission = await mesh.post_mission()
        await mesh.until_state(state, within_s=120.0)
        await mesh.world.latch("a person")
        await mesh.clock.advance(0.2)
        here, moves = mesh.world.pose, list(mesh.world.moves)
        assert (await mesh.mission(mission.id)).outcome is Outcome.ABORTED
        await mesh.world.reset()
        await mesh.clock.advance(30.0)
        assert (await mesh.client.get("/state")).json()["state"] == "IDLE"
        assert mesh.world.moves == moves
        assert abs(mesh.world.pose.x - here.x) < 0.2


async def test_a_cancel_in_mid_drive_ends_the_goal_and_the_robot_stands(open_mesh: OpenMesh) -> None:
    async with open_mesh(FAR, **AS_DELIVERED) as mesh:
        mission = await mesh.post_mission()
        await mesh.until_state(MissionState.APPROACHING, within_s=120.0)
        await mesh.client.post(f"/missions/{mission.id}/cancel")
        await mesh.clock.advance(0.5)
        here = mesh.world.pose
        await mesh.clock.advance(5.0)
        assert mesh.world.pose == here
        assert all(goal.status.value != "EXECUTING" for goal in mesh.robot.goals.values())


@pytest.mark.parametrize("call", ["map", "navigate"])
async def test_a_bridge_that_stays_away_aborts_it_with_the_cause(open_mesh: OpenMesh, call: str) -> None:
    async with open_mesh(**AS_DELIVERED, mission_timeout_s=100.0) as mesh:
        mesh.robot.fail_next = {call: 10_000}
        mission = await mesh.until_over((await mesh.post_mission()).id, within_s=130.0)
        assert mission.outcome is Outcome.ABORTED
        assert mission.report is not None
        assert mission.report.ended_by in {EndCause.SERVICE, EndCause.NAVIGATION}


async def test_a_memory_that_is_away_costs_its_hints_and_nothing_more(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED, views=(SEEN_FROM,), **AS_DELIVERED) as mesh:
        mesh.memory.away = True
        assert (await mesh.until_over((await mesh.post_mission()).id)).outcome is Outcome.FOUND
