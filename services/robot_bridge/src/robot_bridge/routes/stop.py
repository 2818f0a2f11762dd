"""The emergency stop: no key, no body, no other service needed."""

import asyncio
from typing import Annotated

from fastapi import APIRouter, Query
from fastapi.responses import Response
from prometheus_client import Histogram
from starlette.requests import ClientDisconnect, Request

from contracts.robot import EmergencyStop, EmergencyStopEvent, EmergencyStopReply, EmergencyStopRequest
from mesh.access import Role, public, requires_role
from robot_bridge.routes.deps import BridgeDep
from robot_bridge.safety.emergency_stop import HISTORY_MAX

router = APIRouter(tags=["emergency stop"])

STOP_PATH = "/emergency-stop"
STOP_PATHS = (STOP_PATH, f"{STOP_PATH}/")
"""Who types a slash too many means the same."""
FIRST_ZERO = Histogram(
    "robot_bridge_first_zero_seconds",
    "from a stop request's handler to its first zero velocity published",
    buckets=(0.0001, 0.0003, 0.001, 0.003, 0.01, 0.03, 0.1),
)
BODY_WAIT_S = 0.5
BODY_BYTES_MAX = 10_000

_OPTIONAL_BODY = {
    "requestBody": {
        "required": False,
        "content": {"application/json": {"schema": EmergencyStopRequest.model_json_schema()}},
    }
}


@router.post(STOP_PATHS[1], include_in_schema=False)
@router.post(STOP_PATH, openapi_extra=_OPTIONAL_BODY)
@public
async def emergency_stop(request: Request, response: Response, bridge: BridgeDep) -> EmergencyStopReply:
    """Stops the robot and keeps it stopped. Zeros are sent before the body is read: it may only say who and why.

    Whatever the body is (too long, torn, no JSON, never sent), the robot is stopped and the answer is 200.
    """
    state, first_zero_ms = bridge.emergency_stop.stop(reason="", by=_client(request))
    FIRST_ZERO.observe(first_zero_ms / 1000.0)
    asked, was_read = await _asked(request, "requested")
    if not was_read:
        response.headers["Connection"] = "close"  # the rest of the body is not waited for
    state = bridge.emergency_stop.annotate(state.epoch, reason=asked.reason or "requested", by=asked.by)
    return EmergencyStopReply(state=state, first_zero_ms=first_zero_ms)


@router.post("/emergency-stop/reset", openapi_extra=_OPTIONAL_BODY)
@requires_role(Role.OPERATOR)
async def reset(request: Request, bridge: BridgeDep) -> EmergencyStopReply:
    """Permits motion again. Resumes nothing: whatever moved the robot has to ask anew, with the new epoch."""
    asked, _ = await _asked(request, "reset")
    return EmergencyStopReply(state=bridge.emergency_stop.reset(reason=asked.reason, by=asked.by))


@router.post("/halt")
@requires_role(Role.OPERATOR)
async def halt(bridge: BridgeDep) -> EmergencyStop:
    """Ends all motion, whoever asked for it: leases, turns, drives, goals, docking. Nothing latches; the epoch goes up,
    so that what was asked for before is refused from now on.
    """
    return bridge.emergency_stop.halt()


@router.get(STOP_PATH)
@requires_role(Role.VIEWER)
async def read(bridge: BridgeDep) -> EmergencyStop:
    return bridge.emergency_stop.state


@router.get("/emergency-stop/history")
@requires_role(Role.VIEWER)
async def history(
    bridge: BridgeDep, limit: Annotated[int, Query(ge=1, le=HISTORY_MAX)] = 50
) -> list[EmergencyStopEvent]:
    """Who stopped and reset the robot, when and why; newest first, kept over restarts."""
    return bridge.emergency_stop.history.newest(limit)


async def _asked(request: Request, reason: str) -> tuple[EmergencyStopRequest, bool]:
    """What the body says, if it comes soon and can be read; and whether it was read to its end."""
    was_read = False
    try:
        async with asyncio.timeout(BODY_WAIT_S):
            body = await _short_body(request)
        was_read = True
        asked = EmergencyStopRequest.model_validate_json(body) if body.strip() else EmergencyStopRequest(reason=reason)
    except (ValueError, TimeoutError, ClientDisconnect):
        asked = EmergencyStopRequest(reason=f"{reason} (the request's body could not be read)")
    return (asked if asked.by != "unknown" else asked.model_copy(update={"by": _client(request)})), was_read


async def _short_body(request: Request) -> bytes:
    """Raises `ValueError` for one over the limit, without reading on."""
    body = b""
    async for chunk in request.stream():
        body += chunk
        if len(body) > BODY_BYTES_MAX:
            raise ValueError("the body is too long")
    return body


def _client(request: Request) -> str:
    return request.client.host if request.client is not None else "unknown"
