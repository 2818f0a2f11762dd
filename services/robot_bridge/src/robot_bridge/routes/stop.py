"""The emergency stop: no key, no body, no other service needed."""

import asyncio

from fastapi import APIRouter
from pydantic import ValidationError
from starlette.requests import Request

from contracts.robot import EmergencyStop, EmergencyStopReply, EmergencyStopRequest
from robot_bridge.routes.deps import BridgeDep

router = APIRouter(tags=["emergency stop"])

BODY_WAIT_S = 0.5

_OPTIONAL_BODY = {
    "requestBody": {
        "required": False,
        "content": {"application/json": {"schema": EmergencyStopRequest.model_json_schema()}},
    }
}


@router.post("/emergency-stop", openapi_extra=_OPTIONAL_BODY)
async def emergency_stop(request: Request, bridge: BridgeDep) -> EmergencyStopReply:
    """Stops the robot and keeps it stopped. Zeros are sent before the body is read: it may only say who and why."""
    state, first_zero_ms = bridge.emergency_stop(reason="requested", by=_client(request))
    asked = await _asked(request, "requested")
    state = bridge.explain_emergency_stop(state.epoch, reason=asked.reason, by=asked.by)
    return EmergencyStopReply(state=state, first_zero_ms=first_zero_ms)


@router.post("/emergency-stop/reset", openapi_extra=_OPTIONAL_BODY)
async def reset(request: Request, bridge: BridgeDep) -> EmergencyStopReply:
    """Permits motion again. Resumes nothing: whatever moved the robot has to ask anew, with the new epoch."""
    asked = await _asked(request, "reset")
    return EmergencyStopReply(state=bridge.reset_emergency_stop(reason=asked.reason, by=asked.by))


@router.get("/emergency-stop")
async def read(bridge: BridgeDep) -> EmergencyStop:
    return bridge.wheels.stop_state


async def _asked(request: Request, reason: str) -> EmergencyStopRequest:
    """What the body says, if it comes soon and can be read."""
    asked = EmergencyStopRequest(reason=reason)
    try:
        async with asyncio.timeout(BODY_WAIT_S):
            body = await request.body()
        if body.strip():
            asked = EmergencyStopRequest.model_validate_json(body)
    except (ValidationError, TimeoutError):
        asked = EmergencyStopRequest(reason=f"{reason} (the request's body could not be read)")
    return asked if asked.by != "unknown" else asked.model_copy(update={"by": _client(request)})


def _client(request: Request) -> str:
    return request.client.host if request.client is not None else "unknown"
