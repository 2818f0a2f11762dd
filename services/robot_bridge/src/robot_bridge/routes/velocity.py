"""Velocities: leases on the wheels, one by one over HTTP or as a stream over a WebSocket."""

import asyncio
import contextlib

from fastapi import APIRouter, WebSocket, WebSocketDisconnect
from pydantic import ValidationError

from contracts.causes import Refusal
from contracts.robot import VelocityReply, VelocityRequest
from mesh.access import Role, requires_role
from mesh.errors import ConflictError, UnavailableError
from mesh.tracing import TracedRoute, current_span
from robot_bridge.bridge import Bridge
from robot_bridge.motion.arbiter import NO_COMMAND, ArbitratedCommand, Request
from robot_bridge.motion.first_twist import add_twist
from robot_bridge.motion.words import causes_in_words, refusal_in_words
from robot_bridge.routes.deps import BridgeDep

router = APIRouter(tags=["motion"], route_class=TracedRoute)

TICK_WAIT_S = 0.5
WAITING_MAX = 200
"""Replies owed to one teleoperation client; one that sends faster than it reads is cut off."""
NOT_NOW = frozenset({Refusal.STOPPED, Refusal.OLD_EPOCH, Refusal.BASE_BUSY})
"""Refusals that are conflicts with the robot's state (409); the others are about the request (accepted: false)."""


@router.post("/velocity")
@requires_role(Role.OPERATOR)
async def velocity(request: VelocityRequest, bridge: BridgeDep) -> VelocityReply:
    """Takes a lease on the wheels; answers after the next tick with what was really sent, and why it differs."""
    refusal = bridge.wheels.request(_lease(request))
    if refusal is None:
        return await _told(request, bridge, bridge.clock.now_s())
    if refusal in NOT_NOW:
        raise ConflictError(refusal_in_words(refusal, bridge.emergency_stop.state), code=refusal)
    return _refused(refusal, bridge)


@router.websocket("/velocity")
@requires_role(Role.OPERATOR)
async def teleoperate(socket: WebSocket, bridge: BridgeDep) -> None:
    """VelocityRequest in, VelocityReply out, each as JSON, in order. What was asked for here ends with the connection.

    A request takes effect when it arrives, however many replies wait for their tick: a client that sends faster than
    the wheels tick does not drive by what it wanted a while ago.
    """
    await socket.accept()
    sources: set[str] = set()
    owed: asyncio.Queue[tuple[VelocityRequest, float] | VelocityReply] = asyncio.Queue(WAITING_MAX)
    replying = asyncio.create_task(_reply(socket, bridge, owed), name="teleoperation-replies")
    try:
        while not owed.full():
            owed.put_nowait(_take(await socket.receive_text(), bridge, sources))
        await socket.close(1008, "too many requests are waiting for their reply")
    except (WebSocketDisconnect, KeyError):  # KeyError: a binary message where text belongs
        pass
    finally:
        for source in sources:
            bridge.wheels.drop(source)
        replying.cancel()
        await asyncio.gather(replying, return_exceptions=True)


def _take(text: str, bridge: Bridge, sources: set[str]) -> tuple[VelocityRequest, float] | VelocityReply:
    """The request and when it was taken, or the reply that says why it was not."""
    try:
        request = VelocityRequest.model_validate_json(text)
        sources.add(request.source)
        refusal = bridge.wheels.request(_lease(request))
    except ValidationError as error:
        return _refused(Refusal.MALFORMED, bridge, f"malformed: {_first(error)}")
    except ConflictError as error:
        return _refused(Refusal(error.code), bridge, error.detail)
    return (request, bridge.clock.now_s()) if refusal is None else _refused(refusal, bridge)


async def _reply(
    socket: WebSocket, bridge: Bridge, owed: "asyncio.Queue[tuple[VelocityRequest, float] | VelocityReply]"
) -> None:
    with contextlib.suppress(WebSocketDisconnect, RuntimeError):  # it has gone away meanwhile; the reader sees it too
        while True:
            taken = await owed.get()
            if isinstance(taken, VelocityReply):
                reply = taken
            else:
                try:
                    reply = await _told(taken[0], bridge, taken[1])
                except UnavailableError as error:
                    reply = _refused(Refusal(error.code), bridge, error.detail)
            await socket.send_text(reply.model_dump_json())


async def _told(request: VelocityRequest, bridge: Bridge, taken_s: float) -> VelocityReply:
    """What the first tick after `taken_s` sent: one before that may not have known of the lease.

    Raises `UnavailableError` when there is none.
    """
    tick = await bridge.wheels.commanded.wait_for(lambda choice: choice.received_s >= taken_s, TICK_WAIT_S)
    if tick is None:
        raise UnavailableError("rclpy", "the motion loop does not tick", code=Refusal.NO_TICK)
    add_twist(current_span(), tick, source=request.source)
    choice = tick.value
    causes = choice.kinds if choice.source == request.source else ()
    return VelocityReply(
        accepted=True, sent=choice.twist, causes=causes, reason=_why(request, choice), source=choice.source
    )


def _why(request: VelocityRequest, choice: ArbitratedCommand) -> str:
    if choice.source == request.source:
        return causes_in_words(choice.causes)
    return f"{choice.source} has the wheels" if choice.source != NO_COMMAND.source else "it has ended"


def _refused(refusal: Refusal, bridge: Bridge, text: str = "") -> VelocityReply:
    choice = bridge.wheels.commanded.value or NO_COMMAND
    why = text or refusal_in_words(refusal, bridge.emergency_stop.state)
    return VelocityReply(accepted=False, sent=choice.twist, refusal=refusal, reason=why, source=choice.source)


def _lease(request: VelocityRequest) -> Request:
    return Request(
        source=request.source,
        priority=request.priority,
        linear_x=request.twist.linear_x,
        angular_z=request.twist.angular_z,
        duration_s=request.duration_s,
        epoch=request.epoch,
        allow_reverse=request.allow_reverse,
        stamp_s=request.stamp_s,
        session_id=request.session_id,
    )


def _first(error: ValidationError) -> str:
    first = error.errors()[0]
    return f"{'.'.join(str(part) for part in first['loc'])}: {first['msg']}"
