"""Services of the world die and begin anew: the robot stands at once, and nothing resumes by itself."""

import asyncio
import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from bench.world.clock import TOOK_S, run_simulated
from bench.world.faults import Faults
from bench.world.mesh import Mesh, MeshSettings, open_mesh
from bench.world.troubles import RobotTroubles
from bench.world.wire import open_socket
from contracts.geometry import Pose2D, Twist2D
from contracts.mission import Mission, Outcome
from contracts.robot import VelocityRequest
from inference.perception.models import Loaded
from inference.settings import Settings as InferenceSettings
from mesh.errors import MeshError
from sim.home import Home
from sim.world import World
from sim.world.tour import tour_stops

HOME = 7000
STILL_M = 0.02
BASE_STOPS_S = 1.0
"""The base's own watchdog, and what the wheels take to stand."""


@pytest.fixture(scope="module")
def home() -> Home:
    return Home.generate(HOME)


@pytest.fixture
def world(home: Home) -> Iterator[World]:
    with World(home) as plan:
        x, y = tour_stops(plan.grid, plan.scene.dock)[0]
    with World(home, seed=1, start=Pose2D(x=x, y=y, yaw=0.0)) as one:
        yield one


@pytest.fixture
def settings(tmp_path: Path) -> MeshSettings:
    return MeshSettings(tmp_path, inference=InferenceSettings())


async def turned_by_hand(mesh: Mesh, pushes: int) -> None:
    async with open_socket(mesh.bridge, "ws://service/velocity") as stick:
        for _ in range(pushes):
            lease = VelocityRequest(twist=Twist2D(angular_z=0.8), source="a person", epoch=0)
            await stick.send(lease.model_dump_json())
            assert json.loads(await stick.recv())["accepted"]
            await asyncio.sleep(0.1)


def yaw_and_place(world: World) -> tuple[float, float, float]:
    return world.truth.pose.yaw, world.truth.pose.x, world.truth.pose.y


def test_a_bridge_that_dies_leaves_a_robot_that_stands_and_comes_back(world: World, settings: MeshSettings) -> None:
    async def main() -> None:
        async with open_mesh(world, world.grid, Loaded(), settings) as mesh:
            await asyncio.sleep(3.0)
            turning = asyncio.create_task(turned_by_hand(mesh, 100))
            await asyncio.sleep(1.0)
            assert abs(world.truth.twist.angular_z) > 0.3
            await mesh.processes["robot_bridge"].die()
            await asyncio.sleep(BASE_STOPS_S)
            before = yaw_and_place(world)
            await asyncio.sleep(2.0)
            assert yaw_and_place(world) == pytest.approx(before, abs=STILL_M)
            with pytest.raises(OSError, match="closed"):
                await turning
            with pytest.raises(MeshError):
                await mesh.client(mesh.bridge).call("GET", "/description")
            await mesh.processes["robot_bridge"].begin()
            await asyncio.sleep(3.0)
            await turned_by_hand(mesh, 10)
            assert abs(yaw_and_place(world)[0] - before[0]) > 0.3
            assert mesh.died == []

    run_simulated(main, took_s=TOOK_S)


def test_a_coordinator_that_dies_in_a_mission_leaves_it_interrupted(world: World, settings: MeshSettings) -> None:
    async def main() -> Mission:
        async with open_mesh(world, world.grid, Loaded(), settings) as mesh:
            await asyncio.sleep(3.0)
            begun = await mesh.missions.start("find the red bottle")
            assert isinstance(begun, Mission)
            await asyncio.sleep(3.0)
            await mesh.processes["coordinator"].die()
            await asyncio.sleep(BASE_STOPS_S)
            before = yaw_and_place(world)
            await asyncio.sleep(2.0)
            await mesh.processes["coordinator"].begin()
            await asyncio.sleep(5.0)
            assert yaw_and_place(world) == pytest.approx(before, abs=STILL_M)
            return await mesh.missions.get(begun.id)

    assert run_simulated(main, took_s=TOOK_S).outcome is Outcome.INTERRUPTED


def test_nav2_may_say_it_is_there_when_it_is_not(world: World, settings: MeshSettings) -> None:
    troubles = RobotTroubles(Faults(goal_false_success=1.0), seed=1, begins_s=0.0)

    async def main() -> float:
        async with open_mesh(world, world.grid, Loaded(), settings, troubles=troubles) as mesh:
            await asyncio.sleep(3.0)
            here = mesh.robot.believed_pose
            goal = max(
                (Pose2D(x=x, y=y, yaw=0.0) for x, y in tour_stops(world.grid, world.scene.dock)),
                key=lambda one: (one.x - here.x) ** 2 + (one.y - here.y) ** 2,
            )
            accepted = await mesh.robot.navigate(goal, lambda _: None)
            assert accepted is not None
            end = await accepted.end()
            assert (end.status.value, end.error_code) == ("SUCCEEDED", 0)
            there = world.truth.pose
            return ((there.x - goal.x) ** 2 + (there.y - goal.y) ** 2) ** 0.5

    assert run_simulated(main, took_s=TOOK_S) > 0.5
