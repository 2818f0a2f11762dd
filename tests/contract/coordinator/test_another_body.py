"""A wider robot that turns slower and has its camera higher up and further ahead: settings of robot_bridge alone."""

from pathlib import Path

import pytest

from contracts.description import RobotDescription
from contracts.geometry import Pose2D
from contracts.mission import CoveragePlan, Outcome
from contracts.topics import ROBOT_DESCRIPTION
from coordinator.core import recording
from coordinator.core.actions import Rotate
from memory.frames import Camera, project
from support import coordinator_world, fake_robot
from support.bridge_behaviour import running
from support.coordinator_mesh import Mesh, OpenMesh
from support.coordinator_world import Thing
from support.described import DESCRIPTION
from support.toy_robot import ToyRobot

RED = Thing("bottle", "red", 3.5, 2.5)
RADIUS_M, SPEED_M_S, TURN_RAD_S, AHEAD_M, UP_M = 0.45, 0.5, 0.8, 0.15, 0.6


@pytest.fixture
async def body(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> RobotDescription:
    """As a bridge tells it that was given another robot."""
    monkeypatch.setattr(fake_robot, "CAMERA_X_M", AHEAD_M)
    monkeypatch.setattr(fake_robot, "CAMERA_Z_M", UP_M)
    monkeypatch.setattr(fake_robot, "FX", 245.4)  # as the world's eyes see
    monkeypatch.setattr(coordinator_world, "CAMERA_M", AHEAD_M)
    toy = ToyRobot()
    settings = {"footprint_radius_m": RADIUS_M, "speed_m_s_max": SPEED_M_S, "turn_rad_s_max": TURN_RAD_S}
    async with running(tmp_path, toy, fake_robot.FakeRobot(toy), **settings) as rig:
        return RobotDescription.model_validate((await rig.client.get("/description")).json())


async def room_at_scan_points(mesh: Mesh) -> list[bool]:
    plan = CoveragePlan.model_validate_json((await mesh.client.get("/coverage")).content)
    return [mesh.world.is_free(one.x, one.y, RADIUS_M) for one in plan.points]


async def test_a_mission_goes_by_the_body_the_bridge_tells(open_mesh: OpenMesh, body: RobotDescription) -> None:
    async with open_mesh(RED) as mesh:
        assert not all(await room_at_scan_points(mesh))
        await mesh.bus.publish(ROBOT_DESCRIPTION, body)
        await mesh.clock.advance(0.3)
        assert all(await room_at_scan_points(mesh))
        mission = await mesh.until_over((await mesh.post_mission()).id)
        assert mission.outcome is Outcome.FOUND
        taken = recording.read((await mesh.client.get(f"/missions/{mission.id}/recording")).text.splitlines())
    rules = taken.header.rules
    assert (rules.camera_forward_m, rules.camera_hfov_rad) == pytest.approx((AHEAD_M, body.camera.hfov_rad))
    turns = [one for step in taken.steps for one in step.actions if isinstance(one, Rotate)]
    assert max(one.speed_rad_s for one in turns) == TURN_RAD_S


async def test_a_search_waits_for_a_description(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED, described=False) as mesh:
        answer = await mesh.client.post("/missions", json={"command": "find the red bottle"})
        assert (answer.status_code, (await mesh.client.get("/ready")).status_code) == (503, 503)
        assert "described its robot" in answer.json()["detail"]


def test_memory_looks_from_where_the_camera_is(body: RobotDescription) -> None:
    here, cup = Pose2D(x=0.0, y=0.0, yaw=0.0), (2.0, 0.0, UP_M)
    seen, before = (project(cup, here, Camera.on(one), (250, 250)) for one in (body, DESCRIPTION))
    assert seen is not None
    assert before is not None
    assert (seen.v, seen.distance_m) == pytest.approx((125.0, 2.0 - AHEAD_M))
    assert before.v < 100.0


async def test_the_way_to_the_dock_needs_no_description_and_one_that_comes_meanwhile_counts_afterwards(
    open_mesh: OpenMesh, body: RobotDescription
) -> None:
    async with open_mesh(RED, described=False) as mesh:
        docking = await mesh.post_mission("go to the dock")
        await mesh.bus.publish(ROBOT_DESCRIPTION, body)
        ended = await mesh.until_over(docking.id)
        assert ended.outcome is Outcome.DOCKED
        docked = recording.read((await mesh.client.get(f"/missions/{docking.id}/recording")).text.splitlines())
        assert docked.header.rules.camera_hfov_rad == 0.0
        search = await mesh.post_mission()
        taken = recording.read((await mesh.client.get(f"/missions/{search.id}/recording")).text.splitlines())
    assert taken.header.rules.camera_hfov_rad == body.camera.hfov_rad
