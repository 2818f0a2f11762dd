"""What the robot is at, and the map it is in."""

import asyncio
from typing import Annotated

import numpy as np
from fastapi import APIRouter, Query
from fastapi.responses import Response

from contracts.description import RobotDescription
from contracts.laser import LaserScan
from contracts.obstacles import Obstacles
from contracts.robot import KnownMap, Map, RobotState, SameHomeRequest
from geometry.grids import encode
from mesh.access import Role, requires_role
from mesh.tracing import TracedRoute
from robot_bridge.navigation import maps
from robot_bridge.routes.deps import BridgeDep

router = APIRouter(tags=["state"], route_class=TracedRoute)


@router.get("/state")
@requires_role(Role.VIEWER)
async def state(bridge: BridgeDep) -> RobotState:
    return bridge.state()


@router.get("/description")
@requires_role(Role.VIEWER)
async def description(bridge: BridgeDep) -> RobotDescription:
    """Its body: footprint, top speeds, camera. 503 until the camera's camera_info and transform have come."""
    return bridge.description()


@router.get("/scan")
@requires_role(Role.VIEWER)
async def scan(bridge: BridgeDep, points_max: Annotated[int, Query(ge=1, le=2000)] = 360) -> LaserScan:
    """The newest laser scan, for drawing. 503 while the laser is silent."""
    newest = bridge.scan()
    points = newest.points_m[np.isfinite(newest.points_m).all(axis=1)]
    points = points[:: max(1, -(-len(points) // points_max))]
    return LaserScan(
        stamp_s=newest.stamp_s,
        pose=bridge.robot.senses.poses.at(newest.stamp_s),
        points_m=tuple((round(float(x), 3), round(float(y), 3)) for x, y in points),
    )


@router.get("/obstacles")
@requires_role(Role.VIEWER)
async def obstacles(bridge: BridgeDep) -> Obstacles:
    """What stands round the robot by the newest scan (requirement C4). 503 while the laser is silent."""
    return bridge.obstacles()


@router.get("/map")
@requires_role(Role.VIEWER)
async def the_map(bridge: BridgeDep) -> Map:
    """The newest map, and which home it is of."""
    grid = maps.known(bridge.robot.senses)
    home = await bridge.maps.name(grid)
    return (await asyncio.to_thread(encode, grid)).model_copy(update={"home": home})


@router.get("/maps")
@requires_role(Role.VIEWER)
async def known_maps(bridge: BridgeDep) -> tuple[KnownMap, ...]:
    """Every home it ever had a map of, the last one first."""
    return bridge.maps.known()


@router.post("/map/same-home")
@requires_role(Role.OPERATOR)
async def same_home(body: SameHomeRequest, bridge: BridgeDep) -> KnownMap:
    """'This is the same home': what belongs to that map belongs to the map of now. 409 where their walls do not fit."""
    return await bridge.maps.same_home(body.id)


@router.get("/map.png", response_class=Response, responses={200: {"content": {"image/png": {}}}})
@requires_role(Role.VIEWER)
async def picture(bridge: BridgeDep) -> Response:
    """One pixel a cell, north up, grey as ROS map files are."""
    return Response(await asyncio.to_thread(maps.png, maps.known(bridge.robot.senses)), media_type="image/png")
