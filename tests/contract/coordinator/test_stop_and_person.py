"""Stopping, cancelling, pausing a running mission through the front door."""

import pytest

from contracts.geometry import Pose2D
from contracts.mission import MissionState, Outcome
from support.coordinator_mesh import OpenMesh
from support.coordinator_world import Thing

HIGH = Thing("bottle", "red", 8.5, 6.8, near_limit_m=0.8)
VIEW = Pose2D(x=7.5, y=6.0, yaw=0.7)
ON_THE_WAY = [
    MissionState.MEMORY_NAV,
    MissionState.SCANNING,
    MissionState.CENTERING,
    MissionState.DEPTH_CHECK,
    MissionState.DRIVING_1M,
    MissionState.APPROACHING,
]


@pytest.mark.parametrize("state", ON_THE_WAY)
async def test_an_emergency_stop_aborts_and_nothing_moves_afterwards(open_mesh: OpenMesh, state: MissionState) -> None:
    far = Pose2D(x=6.0, y=5.5, yaw=0.6)
    async with open_mesh(HIGH, views=(far,)) as mesh:
        mission = await mesh.post_mission()
        await mesh.until_state(state, within_s=120.0)
        await mesh.world.latch("a person")
        await mesh.clock.advance(0.2)
        here, moves = mesh.world.pose, list(mesh.world.moves)
        assert (await mesh.client.get("/state")).json()["state"] == "EMERGENCY_STOP"
        assert (await mesh.mission(mission.id)).outcome is Outcome.ABORTED
        refused = await mesh.client.post("/missions", json={"command": "find the red bottle"})
        assert refused.status_code == 409
        await mesh.world.reset()
        await mesh.clock.advance(30.0)
        assert (await mesh.client.get("/state")).json()["state"] == "IDLE"
        assert mesh.world.moves == moves
        assert abs(mesh.world.pose.x - here.x) < 0.2


async def test_cancel_stops_the_robot_and_ends_the_mission(open_mesh: OpenMesh) -> None:
    async with open_mesh(HIGH, views=(VIEW,)) as mesh:
        mission = await mesh.post_mission()
        await mesh.clock.advance(3.0)
        answer = await mesh.client.post(f"/missions/{mission.id}/cancel")
        assert answer.json()["outcome"] == "canceled"
        await mesh.clock.advance(0.3)
        here = mesh.world.pose
        await mesh.clock.advance(5.0)
        assert mesh.world.pose == here
        again = await mesh.client.post(f"/missions/{mission.id}/cancel")
        assert again.status_code == 409


async def test_a_paused_mission_stands_still_and_goes_on_when_resumed(open_mesh: OpenMesh) -> None:
    async with open_mesh(HIGH, views=(VIEW,)) as mesh:
        mission = await mesh.post_mission()
        await mesh.clock.advance(3.0)
        paused = await mesh.client.post(f"/missions/{mission.id}/pause")
        assert paused.json()["paused"] is True
        await mesh.clock.advance(0.3)
        here = mesh.world.pose
        await mesh.clock.advance(20.0)
        assert mesh.world.pose == here
        assert (await mesh.client.post(f"/missions/{mission.id}/pause")).status_code == 409
        resumed = await mesh.client.post(f"/missions/{mission.id}/resume")
        assert resumed.json()["paused"] is False
        assert (await mesh.until_over(mission.id)).outcome is Outcome.FOUND


async def test_a_mission_stands_while_somebody_speaks_and_goes_on_when_nobody_does(open_mesh: OpenMesh) -> None:
    async with open_mesh(HIGH, views=(VIEW,)) as mesh:
        mission = await mesh.post_mission()
        await mesh.clock.advance(3.0)
        listening = await mesh.client.post(f"/missions/{mission.id}/pause", params={"for_s": 20.0})
        assert listening.json()["paused"] is True
        await mesh.clock.advance(0.3)
        here = mesh.world.pose
        await mesh.clock.advance(15.0)
        assert mesh.world.pose == here
        let_go = await mesh.client.post(f"/missions/{mission.id}/pause", params={"for_s": 0.0})
        assert let_go.json()["paused"] is False
        assert (await mesh.until_over(mission.id)).outcome is Outcome.FOUND


async def test_who_only_listens_ends_no_pause_of_a_person(open_mesh: OpenMesh) -> None:
    async with open_mesh(HIGH, views=(VIEW,)) as mesh:
        mission = await mesh.post_mission()
        await mesh.clock.advance(3.0)
        pause = f"/missions/{mission.id}/pause"
        assert (await mesh.client.post(pause, params={"for_s": 5.0})).status_code == 200
        assert (await mesh.client.post(pause)).status_code == 200
        assert (await mesh.client.post(pause, params={"for_s": 0.0})).status_code == 409
        await mesh.clock.advance(20.0)
        assert (await mesh.mission(mission.id)).paused
        assert (await mesh.client.post(pause, params={"for_s": 61.0})).status_code == 422


async def test_only_a_paused_mission_can_be_resumed(open_mesh: OpenMesh) -> None:
    async with open_mesh(HIGH) as mesh:
        mission = await mesh.post_mission()
        assert (await mesh.client.post(f"/missions/{mission.id}/resume")).status_code == 409


async def test_a_cancel_while_a_goal_is_being_sent_cancels_that_goal(open_mesh: OpenMesh) -> None:
    async with open_mesh(HIGH, views=(VIEW,)) as mesh:
        mesh.robot.slow_to_accept_s = 2.0
        mission = await mesh.post_mission()
        await mesh.clock.advance(1.0)
        await mesh.client.post(f"/missions/{mission.id}/cancel")
        await mesh.clock.advance(5.0)
        assert [goal.status.value for goal in mesh.robot.goals.values()] == ["CANCELED"]


async def test_a_goal_whose_acceptance_was_lost_is_ended_with_the_session(open_mesh: OpenMesh) -> None:
    async with open_mesh(HIGH, views=(Pose2D(x=4.0, y=6.0, yaw=0.0),)) as mesh:
        mesh.robot.loses_navigate_reply = True
        mission = await mesh.post_mission()
        await mesh.clock.advance(1.0)
        assert "navigate" in mesh.world.moves
        await mesh.client.post(f"/missions/{mission.id}/cancel")
        await mesh.clock.advance(0.5)
        there = mesh.world.pose
        await mesh.clock.advance(5.0)
        assert mesh.robot.sessions_dropped == 1
        assert mesh.world.pose == there
