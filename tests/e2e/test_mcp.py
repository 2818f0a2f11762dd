"""The official MCP client against the running mesh: it moves the robot, is told of it, cancels and stops."""

import asyncio
from collections.abc import Iterator

import pytest
from mcp import Client, types

from contracts.actions import ActionName
from contracts.mission import Outcome
from support.mesh_run import MeshRun

MISSION_S = 600.0


@pytest.fixture(autouse=True)
def at_rest(mesh: MeshRun) -> Iterator[None]:
    mesh.rested()
    yield
    mesh.rested()


def outcome(result: types.CallToolResult) -> str:
    assert isinstance(result.structured_content, dict), result
    return str(result.structured_content["mission"]["outcome"])


def canceled(mesh: MeshRun) -> bool:
    return bool(mesh.get("coordinator", "/missions")[0]["outcome"] == Outcome.CANCELED)


@pytest.mark.timeout(900)
async def test_a_client_finds_a_bottle_and_is_told_on_the_way(mesh: MeshRun) -> None:
    told: list[str] = []

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
