"""What the base does by itself: dock, undock, celebrate."""

import asyncio
from typing import Annotated

from fastapi import APIRouter, Query
from starlette.requests import Request

from contracts.robot import MotionReply
from mesh.errors import ConflictError
from robot_bridge.bridge import Bridge
from robot_bridge.celebration import RETRIGGER_S, SUCCESS
from robot_bridge.navigator import refuse_while_navigating
from robot_bridge.routes.deps import BridgeDep, while_connected

router = APIRouter(tags=["base"])

SessionId = Annotated[str | None, Query(max_length=64, description="refused when this session has ended")]


@router.post("/dock")
async def dock(request: Request, bridge: BridgeDep, session_id: SessionId = None) -> MotionReply:
    """The base drives onto its dock; answers when it is there or has given up. `moved` is always 0."""
    return await while_connected(request, _base_drives(bridge, session_id, docking=True))


@router.post("/undock")
async def undock(request: Request, bridge: BridgeDep, session_id: SessionId = None) -> MotionReply:
    """The base backs off its dock and turns round."""
    return await while_connected(request, _base_drives(bridge, session_id, docking=False))


@router.post("/celebrate")
async def celebrate(bridge: BridgeDep) -> MotionReply:
    """Six notes and a green spin of the lights (requirement A16); 409 within 4 s of the last time."""
    now_s = bridge.clock.now_s()
    if bridge.celebrated_s is not None and now_s - bridge.celebrated_s < RETRIGGER_S:
        raise ConflictError(f"it celebrated {now_s - bridge.celebrated_s:.1f} s ago")
    bridge.celebrated_s = now_s
    bridge.robot.celebrate(SUCCESS)
    return MotionReply(completed=True, moved=0.0)


async def _base_drives(bridge: Bridge, session_id: str | None, *, docking: bool) -> MotionReply:
    wheels = bridge.wheels
    wheels.check(wheels.stop_state.epoch, session_id)
    refuse_while_navigating(bridge.navigator, "docking" if docking else "undocking")
    wheels.set_base_busy(True)
    epoch = wheels.stop_state.epoch
    try:
        async with asyncio.timeout(bridge.settings.dock_timeout_s):
            done = await (bridge.robot.dock() if docking else bridge.robot.undock())
    except TimeoutError:
        return MotionReply(completed=False, moved=0.0, reason="timeout")
    finally:
        wheels.set_base_busy(False)
    if wheels.stop_state.epoch != epoch:
        return MotionReply(completed=False, moved=0.0, reason="emergency stop")
    return MotionReply(completed=done, moved=0.0, reason="" if done else "the base gave up (is the dock in sight?)")
