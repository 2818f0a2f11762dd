"""Requirement A4 while a person drives: what is seen with depth on the way is remembered at its own place."""

import asyncio
import json
import math
from pathlib import Path

import pytest
from pydantic import TypeAdapter

from bench.world.clock import TOOK_S, run_simulated
from bench.world.mesh import Mesh, MeshSettings, open_mesh
from bench.world.wire import open_socket
from contracts.geometry import Pose2D, Twist2D
from contracts.memory import RememberedObject
from contracts.robot import VelocityRequest
from inference.adapters.loading import loader
from inference.settings import Backend, Settings
from sim.home import Home
from sim.home.catalog import THINGS
from sim.scoring import camera_position, unobstructed
from sim.world import ThingTruth, World
from sim.world.tour import tour_poses
from support.source import ROOT

HOME = 7000
PLACE_ERROR_M = 0.35
STICK_S = 0.1
TURN = 15
"""Pushes of the stick, of `STICK_S` each."""
OBJECTS = TypeAdapter(list[RememberedObject])


def before_a_thing(world: World) -> tuple[Pose2D, ThingTruth]:
    """A place from which a thing is in plain sight, well within the depth camera's reach."""
    things = [one for one in world.truth.things if one.kind in THINGS and THINGS[one.kind].findable]
    for pose in tour_poses(world.grid, world.scene.dock):
        for thing in things:
            away_m = math.hypot(thing.x_m - pose.x, thing.y_m - pose.y)
            bearing = math.remainder(math.atan2(thing.y_m - pose.y, thing.x_m - pose.x) - pose.yaw, math.tau)
            if 0.9 < away_m < 1.5 and abs(bearing) < 0.2 and unobstructed(world, camera_position(pose), thing):
                return pose, thing
    raise LookupError("nothing is in sight in this home")


async def driven(mesh: Mesh, *twists: Twist2D) -> None:
    """As the page's stick: a chain of short leases."""
    async with open_socket(mesh.bridge, "ws://service/velocity") as stick:
        for twist in twists:
            lease = VelocityRequest(twist=twist, source="a person", epoch=0)
            await stick.send(lease.model_dump_json())
            reply = json.loads(await stick.recv())
            assert reply["accepted"], reply
            await asyncio.sleep(STICK_S)


async def objects_after_a_drive(world: World, settings: MeshSettings) -> list[RememberedObject]:
    models = loader(settings.inference)()
    async with open_mesh(world, world.grid, models, settings) as mesh:
        await asyncio.sleep(3.0)
        left, right = Twist2D(angular_z=0.3), Twist2D(angular_z=-0.3)
        await driven(mesh, *[left] * TURN, *[right] * TURN, *[Twist2D(linear_x=0.1)] * TURN)
        await asyncio.sleep(3.0)
        reply = await mesh.client(mesh.memory).call("GET", "/objects", params={"limit": 1000})
        return OBJECTS.validate_json(reply.content)


@pytest.mark.timeout(300)
def test_what_a_person_drives_past_becomes_an_object_at_its_place(tmp_path: Path) -> None:
    inference = Settings(
        detector_path=ROOT / "sim/weights/detector.pt",
        detector_backend=Backend.TORCH,
        clip_path=ROOT / "sim/weights/clip.safetensors",
    )
    home = Home.generate(HOME)
    with World(home) as plan:
        start, thing = before_a_thing(plan)
    settings = MeshSettings(tmp_path, inference=inference)
    with World(home, seed=1, start=start) as world:
        known = run_simulated(lambda: objects_after_a_drive(world, settings), took_s=TOOK_S)
        moved_m = world.truth.path_length_m
    assert moved_m > 0.08
    there = [
        one
        for one in known
        if one.label == thing.kind
        and math.hypot(one.position.x - thing.x_m, one.position.y - thing.y_m) < PLACE_ERROR_M
    ]
    assert there, f"{thing.colour} {thing.kind} is not among {[one.description for one in known]}"
    assert max(one.times_seen for one in there) > 2
