"""Goals for Nav2."""

from typing import Annotated

from fastapi import APIRouter, Path

from contracts.robot import Goal, GoalRequest, PathReply, PathRequest
from mesh.access import Role, requires_role
from mesh.tracing import TracedRoute
from robot_bridge.routes.deps import BridgeDep

router = APIRouter(prefix="/navigation", tags=["navigation"], route_class=TracedRoute)

GoalId = Annotated[str, Path(min_length=1, max_length=64)]


@router.post("/goals")
@requires_role(Role.OPERATOR)
async def send(request: GoalRequest, bridge: BridgeDep) -> Goal:
    """Answers once Nav2 has taken (EXECUTING) or refused (REJECTED) the goal; its end is told on robot.navigation."""
    return await bridge.goals.send(request)


@router.get("/goals/{goal_id}")
@requires_role(Role.VIEWER)
async def read(goal_id: GoalId, bridge: BridgeDep) -> Goal:
    return bridge.goals.goal(goal_id)


@router.delete("/goals/{goal_id}")
@requires_role(Role.OPERATOR)
async def cancel(goal_id: GoalId, bridge: BridgeDep) -> Goal:
    """Cancels it; a goal that is over stays as it ended."""
    return await bridge.goals.cancel(goal_id)


@router.post("/path")
@requires_role(Role.VIEWER)
async def path(request: PathRequest, bridge: BridgeDep) -> PathReply:
    """Can the robot get there, and how far is it? Nothing moves."""
    return await bridge.goals.path(request)
