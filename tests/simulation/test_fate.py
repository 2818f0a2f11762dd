"""What befalls a mission in the world of the whole mesh: it happens, and motion where none may be is told."""

import asyncio
import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from bench.world.clock import TOOK_S, run_simulated
from bench.world.fate import Fate
from bench.world.faults import Faults, Outage
from bench.world.line import Line
from bench.world.mesh import Mesh, MeshSettings, open_mesh
from bench.world.wire import open_socket
from contracts.geometry import Pose2D, Twist2D
from contracts.mission import EndCause, Mission, Outcome
from contracts.robot import VelocityRequest
from inference.perception.models import Loaded
from sim.home import Home
from sim.world import World
from sim.world.tour import tour_stops

HOME = 7000


@pytest.fixture
def world() -> Iterator[World]:
    home = Home.generate(HOME)
    with World(home) as plan:
        x, y = tour_stops(plan.grid, plan.scene.dock)[0]
    with World(home, seed=1, start=Pose2D(x=x, y=y, yaw=0.0)) as one:
        yield one


async def driven_by_hand(mesh: Mesh, pushes: int) -> None:
    async with open_socket(mesh.bridge, "ws://service/velocity") as stick:
        for _ in range(pushes):
            lease = VelocityRequest(twist=Twist2D(linear_x=0.1), source="a person", epoch=0)
            await stick.send(lease.model_dump_json())
            json.loads(await stick.recv())
            await asyncio.sleep(0.1)


def befallen(world: World, disk: Path, faults: Faults, *, pushes: int = 0) -> tuple[Mission, list[str]]:
    """A mission 15 s on, and what was wrong with how the robot moved."""

    async def main() -> tuple[Mission, list[str]]:
        async with open_mesh(world, world.grid, Loaded(), MeshSettings(disk), line=Line(faults, 1)) as mesh:
            await asyncio.sleep(3.0)
            begun = await mesh.missions.start("find the red bottle")
            assert isinstance(begun, Mission)
            fate = Fate(mesh, begun.id, asyncio.get_running_loop().time(), 1)
            async with fate.at_work():
                await asyncio.sleep(10.0)
                await driven_by_hand(mesh, pushes)
                await asyncio.sleep(5.0)
                assert mesh.died == []
                return await mesh.missions.get(begun.id), fate.problems

    return run_simulated(main, took_s=TOOK_S)


def test_a_stop_that_is_pressed_ends_the_mission_though_the_bridge_was_down(world: World, tmp_path: Path) -> None:
    faults = Faults(stop_s=2.0, reset_s=6.0, outages=(Outage("robot_bridge", 1.0, 3.0),))
    mission, problems = befallen(world, tmp_path, faults)
    assert problems == []
    assert mission.outcome is Outcome.ABORTED
    assert mission.report is not None
    assert mission.report.ended_by is EndCause.STOPPED


def test_motion_after_the_mission_is_over_is_told(world: World, tmp_path: Path) -> None:
    mission, problems = befallen(world, tmp_path, Faults(cancel_s=2.0), pushes=15)
    assert mission.outcome is Outcome.CANCELED
    assert problems
    assert all("after it should stand" in one for one in problems)
