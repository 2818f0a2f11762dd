"""The arm: where it is, and what moves it. A robot without one says so."""

from fastapi import APIRouter
from starlette.requests import Request as HttpRequest

from contracts.arm import (
    ArmEnd,
    ArmHomeRequest,
    ArmReply,
    ArmState,
    ArmStopReply,
    ArmTrajectoryRequest,
    GripperReply,
    GripperRequest,
)
from mesh.access import Role, requires_role
from mesh.tracing import TracedRoute
from robot_bridge.routes.deps import BridgeDep, while_connected

router = APIRouter(prefix="/arm", tags=["arm"], route_class=TracedRoute)


@router.get("")
@requires_role(Role.VIEWER)
async def read(bridge: BridgeDep) -> ArmState:
    """Its joints, what they may do and where they are; `fitted: false` on a robot without an arm."""
    return bridge.arm.state()


@router.post("/trajectory")
@requires_role(Role.OPERATOR)
async def trajectory(request: ArmTrajectoryRequest, http: HttpRequest, bridge: BridgeDep) -> ArmReply:
    """Moves the joints through the points; answers at the end. Ends with the connection, its session, or a stop.

    422 with a `code` where a joint would leave its range or be too fast, at a point or between two, and 409 while one
    moves: it is checked from rest. Nothing is begun then.
    """
    return await while_connected(http, bridge.arm.follow(request))


@router.post("/home")
@requires_role(Role.OPERATOR)
async def home(request: ArmHomeRequest, http: HttpRequest, bridge: BridgeDep) -> ArmReply:
    """Folds the arm; the way there is straight in joint space, and nothing is looked at on it."""
    return await while_connected(http, bridge.arm.home(request))


@router.post("/gripper")
@requires_role(Role.OPERATOR)
async def gripper(request: GripperRequest, http: HttpRequest, bridge: BridgeDep) -> GripperReply:
    """Opens or closes the jaw; `stalled` where it is held up before it is there: it holds something, or is blocked."""
    return await while_connected(http, bridge.arm.grip(request))


@router.post("/stop")
@requires_role(Role.OPERATOR)
async def stop(bridge: BridgeDep) -> ArmStopReply:
    """Ends what the arm does, whoever asked for it; it stays where it is. The wheels go on, and nothing is latched."""
    return ArmStopReply(ended=bridge.arm.stop(ArmEnd.CANCELED))
