"""STOP: straight to robot_bridge."""

from typing import Final

from fastapi import APIRouter
from starlette.requests import Request

from contracts.robot import EmergencyStopReply
from ui.routes.deps import ActsDep, operator

router = APIRouter(tags=["emergency stop"])

HOW: Final = {"escape": "Esc pressed on the page"}


@router.post("/stop")
async def stop(request: Request, acts: ActsDep) -> EmergencyStopReply:
    """Stops the robot at once; nothing in the request can make it fail. 503 when robot_bridge cannot be reached."""
    reason = HOW.get(request.query_params.get("how", ""), "STOP pressed on the page")
    return await acts.emergency_stop(reason=reason, by=operator(request))
