"""What the base does by itself: dock, undock, celebrate."""

from typing import Annotated

from fastapi import APIRouter, Query
from starlette.requests import Request

from contracts.causes import Refusal
from contracts.motion import BaseEnd, BaseReply
from mesh.access import Role, requires_role
from mesh.errors import ConflictError
from mesh.tracing import TracedRoute
from robot_bridge.ports import Celebration, Note
from robot_bridge.routes.deps import BridgeDep, while_connected

router = APIRouter(tags=["base"], route_class=TracedRoute)

SessionId = Annotated[str | None, Query(max_length=64, description="ends with this session, see WS /session")]


SUCCESS = Celebration(
    notes=(Note(262, 0.3), Note(330, 0.3), Note(392, 0.3), Note(523, 0.4), Note(659, 0.4), Note(784, 0.6)),
    led_rgb=(0, 255, 0),
    led_animation_type=2,  # irobot_create_msgs LedAnimation.SPIN_LIGHTS
    led_duration_s=3.0,
)
RETRIGGER_S = 4.0
"""A second celebration within this time is refused."""


@router.post("/dock")
@requires_role(Role.OPERATOR)
async def dock(request: Request, bridge: BridgeDep, session_id: SessionId = None) -> BaseReply:
    """In front of the dock with Nav2, then onto it by the base itself; answers when it is there or has given up.

    409 with the reason where it cannot begin.
    """
    return await while_connected(request, bridge.docking.dock(session_id))


@router.post("/undock")
@requires_role(Role.OPERATOR)
async def undock(request: Request, bridge: BridgeDep, session_id: SessionId = None) -> BaseReply:
    """The base backs off its dock and turns round; 409 where it is not docked."""
    return await while_connected(request, bridge.docking.undock(session_id))


@router.post("/celebrate")
@requires_role(Role.OPERATOR)
async def celebrate(bridge: BridgeDep) -> BaseReply:
    """Six notes and a green spin of the lights (requirement A16); 409 within 4 s of the last time."""
    now_s = bridge.clock.now_s()
    if bridge.celebrated_s is not None and now_s - bridge.celebrated_s < RETRIGGER_S:
        raise ConflictError(f"it celebrated {now_s - bridge.celebrated_s:.1f} s ago", code=Refusal.CELEBRATED)
    bridge.celebrated_s = now_s
    bridge.robot.celebrate(SUCCESS)
    return BaseReply(end=BaseEnd.COMPLETED)
