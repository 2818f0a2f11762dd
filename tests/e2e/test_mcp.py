"""The official MCP client against the running mesh: it moves the robot, is told of it, cancels and stops."""

import asyncio
import math
from collections.abc import Iterator

import pytest
from mcp import Client, types

from contracts.actions import ActionName
from contracts.geometry import Point3D, Pose2D
from contracts.memory import Observation, ObservationBatch
from contracts.mission import Outcome
from contracts.robot import Map
from geometry.grids import decode
from sim.home import Home
from support.mesh_run import MeshRun

MISSION_S = 240.0
VIEW_M = 1.2


@pytest.fixture(autouse=True)
def at_rest(mesh: MeshRun) -> Iterator[None]:
    mesh.rested()
    yield
    mesh.rested()


def a_view_of(mesh: MeshRun, x: float, y: float) -> Pose2D:
    """A pose on the free floor with nothing between it and the place."""
    grid = decode(Map.model_validate(mesh.get("robot_bridge", "/map")))

    def free(at_x: float, at_y: float) -> bool:
        cell = grid.cell(at_x, at_y)
        return cell is not None and bool(grid.free[cell])

    def clear(angle: float) -> bool:
        c, s = math.cos(angle), math.sin(angle)
        sides = ((along, side) for along in (0.4, 0.6, 0.8, 1.0, VIEW_M, VIEW_M + 0.3) for side in (-0.3, 0.0, 0.3))
        return all(free(x + along * c - side * s, y + along * s + side * c) for along, side in sides)

    angle = next(angle for k in range(32) if clear(angle := k * math.tau / 32))
    return Pose2D(
        x=x + VIEW_M * math.cos(angle), y=y + VIEW_M * math.sin(angle), yaw=math.remainder(angle + math.pi, math.tau)
    )


def remembers_the_bottle(mesh: MeshRun) -> None:
    """Memory knows it, as after a tour: this test is about the way a client is told, not about a search."""
    (bottle,) = (one for one in Home.load(mesh.stack.home).things if (one.kind, one.colour) == ("bottle", "red"))
    view = a_view_of(mesh, bottle.x_m, bottle.y_m)
    told = Observation(
        label="bottle",
        colour="red",
        confidence=0.8,
        pose=view,
        stamp_s=mesh.simulated_s(),
        position=Point3D(x=bottle.x_m, y=bottle.y_m, z=bottle.z_m + 0.1),
        sigma_m=0.1,
    )
    batch = ObservationBatch(observations=(told,)).model_dump(mode="json")
    mesh.post("memory", "/observations", batch).raise_for_status()


def outcome(result: types.CallToolResult) -> str:
    assert isinstance(result.structured_content, dict), result
    return str(result.structured_content["mission"]["outcome"])


def canceled(mesh: MeshRun) -> bool:
    return bool(mesh.get("coordinator", "/missions")[0]["outcome"] == Outcome.CANCELED)


@pytest.mark.timeout(300)
async def test_a_client_finds_a_bottle_and_is_told_on_the_way(mesh: MeshRun) -> None:
    told: list[str] = []
    remembers_the_bottle(mesh)

    async def on_progress(progress: float, total: float | None, message: str | None) -> None:
        del progress, total
        told.append(message or "")

    async with Client(mesh.url("coordinator", "/mcp"), read_timeout_seconds=MISSION_S) as client:
        assert [one.name for one in (await client.list_tools()).tools] == [name.value for name in ActionName]
        result = await client.call_tool("find", {"thing": "red bottle"}, progress_callback=on_progress)
        assert outcome(result) == Outcome.FOUND
        assert len(told) > 3
        picture = (await client.read_resource("atom://camera")).contents[0]
        assert isinstance(picture, types.BlobResourceContents)
        assert picture.mime_type == "image/jpeg"


@pytest.mark.timeout(300)
async def test_a_cancelled_call_and_a_stop_bring_the_robot_to_rest(mesh: MeshRun) -> None:
    async with Client(mesh.url("coordinator", "/mcp"), read_timeout_seconds=MISSION_S) as client:
        await client.list_tools()
        exploring = asyncio.ensure_future(client.call_tool("explore"))
        await asyncio.to_thread(mesh.until, lambda: not mesh.still(), timeout_s=60.0, what="a robot that moves")
        exploring.cancel()
        await asyncio.to_thread(mesh.until, lambda: canceled(mesh), timeout_s=30.0, what="a cancelled mission")
        await asyncio.to_thread(mesh.until, mesh.still, timeout_s=30.0, what="a robot at rest")
        again = asyncio.ensure_future(client.call_tool("explore"))
        await asyncio.to_thread(mesh.until, lambda: not mesh.still(), timeout_s=60.0, what="a robot that moves")
        stopped = await client.call_tool("stop")
        assert isinstance(stopped.structured_content, dict)
        assert stopped.structured_content["heard"]["still"] is True
        assert outcome(await again) == Outcome.CANCELED
        await asyncio.to_thread(mesh.stays_at_rest_for, 2.0)
