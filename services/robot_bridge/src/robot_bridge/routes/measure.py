"""How far, and where."""

from fastapi import APIRouter

from contracts.measuring import LocalizeReply, LocalizeRequest
from contracts.robot import BoxQuery, DepthReply
from mesh.access import Role, requires_role
from mesh.tracing import TracedRoute
from robot_bridge.routes.deps import BridgeDep

router = APIRouter(tags=["measuring"], route_class=TracedRoute)


@router.post("/depth")
@requires_role(Role.VIEWER)
async def depth(query: BoxQuery, bridge: BridgeDep) -> DepthReply:
    """Distance along the optical axis to what the box shows; none, with a reason, where it cannot be measured."""
    return await bridge.measuring.depth(query)


@router.post("/localize")
@requires_role(Role.VIEWER)
async def localize(request: LocalizeRequest, bridge: BridgeDep) -> LocalizeReply:
    """Where the things in the boxes of a picture are: bearing, distance, the point in base_link and map, or why not."""
    return await bridge.measuring.localize(request)
