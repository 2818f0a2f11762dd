"""What the robot is at, and the map it is in."""

import asyncio

from fastapi import APIRouter
from fastapi.responses import Response

from contracts.robot import Map, RobotState
from mesh.errors import UnavailableError
from robot_bridge import maps
from robot_bridge.routes.deps import BridgeDep
from robot_bridge.senses import Grid

router = APIRouter(tags=["state"])


@router.get("/state")
async def state(bridge: BridgeDep) -> RobotState:
    return bridge.state()


@router.get("/map")
async def the_map(bridge: BridgeDep) -> Map:
    return await asyncio.to_thread(maps.message, _grid(bridge))


@router.get("/map.png", response_class=Response, responses={200: {"content": {"image/png": {}}}})
async def picture(bridge: BridgeDep) -> Response:
    """One pixel a cell, north up, grey as ROS map files are."""
    return Response(await asyncio.to_thread(maps.png, _grid(bridge)), media_type="image/png")


def _grid(bridge: BridgeDep) -> Grid:
    if (grid := bridge.robot.senses.map.value) is None:
        raise UnavailableError("map", "no map has been received")
    return grid
