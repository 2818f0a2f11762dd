"""How far, and where."""

from fastapi import APIRouter

from contracts.robot import BoxQuery, DepthReply, LocalizeReply
from robot_bridge.routes.deps import BridgeDep
from robot_bridge.sensing.object_localizer import ObjectLocalizer

router = APIRouter(tags=["measuring"])


@router.post("/depth")
async def depth(query: BoxQuery, bridge: BridgeDep) -> DepthReply:
    """Distance along the optical axis to what the box shows; none, with a reason, where it cannot be measured."""
    return await _measuring(bridge).depth(query)


@router.post("/localize")
async def localize(query: BoxQuery, bridge: BridgeDep) -> LocalizeReply:
    """Where what the box shows is: bearing, horizontal distance, and the point in base_link and map."""
    return await _measuring(bridge).localize(query)


def _measuring(bridge: BridgeDep) -> ObjectLocalizer:
    settings = bridge.settings
    return ObjectLocalizer(bridge.robot.senses, bridge.clock, settings.depth_match_s_max, settings.image_age_s_max)
