"""Velocities (leases) and closed-loop motions."""

from fastapi import APIRouter, WebSocket, WebSocketDisconnect
from prometheus_client import Counter
from pydantic import ValidationError
from starlette.requests import Request as HttpRequest

from contracts.geometry import Twist2D
from contracts.robot import DriveRequest, MotionReply, RotateRequest, VelocityReply, VelocityRequest
from mesh.errors import ConflictError, UnavailableError
from robot_bridge.arbiter import Refusal, Request
from robot_bridge.bridge import Bridge
from robot_bridge.motion import Drive, Rotation
from robot_bridge.navigator import refuse_while_navigating
from robot_bridge.routes.deps import BridgeDep, while_connected

router = APIRouter(tags=["motion"])

TICK_WAIT_S = 0.5
REFUSED = Counter("robot_bridge_velocity_refused_total", "velocity requests that never became a lease", ["reason"])
NOT_NOW = frozenset({Refusal.STOPPED, Refusal.OLD_EPOCH, Refusal.BASE_IS_BUSY})
"""Refusals that are conflicts with the robot's state (409); the others are about the request (accepted: false)."""


@router.post("/velocity")
async def velocity(request: VelocityRequest, bridge: BridgeDep) -> VelocityReply:
    """Takes a lease on the wheels; answers after the next tick with what was really sent."""
    reply, refusal = await _velocity(request, bridge)
    if refusal in NOT_NOW:
        raise ConflictError(reply.reason)
    return reply


@router.websocket("/velocity")
async def teleoperate(socket: WebSocket, bridge: BridgeDep) -> None:
    """VelocityRequest in, VelocityReply out, each as JSON. The leases asked for here end with the connection."""
    await socket.accept()
    sources: set[str] = set()
    try:
        while True:
            try:
                request = VelocityRequest.model_validate_json(await socket.receive_text())
                sources.add(request.source)
                reply, _ = await _velocity(request, bridge)
            except ValidationError as error:
                reply = VelocityReply(accepted=False, sent=_sent(bridge), reason=f"malformed: {_first(error)}")
            except (ConflictError, UnavailableError) as error:
                reply = VelocityReply(accepted=False, sent=_sent(bridge), reason=error.detail)
            await socket.send_text(reply.model_dump_json())
    except (WebSocketDisconnect, KeyError):  # KeyError: a binary message where text belongs
        pass
    finally:
        for source in sources:
            bridge.wheels.drop(source)


@router.post("/rotate")
async def rotate(request: RotateRequest, http: HttpRequest, bridge: BridgeDep) -> MotionReply:
    """Turns by an angle on odometry; answers when it is done or given up. Ends with the connection."""
    refuse_while_navigating(bridge.navigator, "turning")
    motion = Rotation(
        request.angle_rad, speed_rad_s=request.speed_rad_s, timeout_s=request.timeout_s, gains=bridge.gains
    )
    moving = bridge.move(motion, name="rotate", epoch=request.epoch, session_id=request.session_id)
    return await while_connected(http, moving)


@router.post("/drive")
async def drive(request: DriveRequest, http: HttpRequest, bridge: BridgeDep) -> MotionReply:
    """Drives a distance on odometry; answers when it is done or given up (an obstacle or a lost connection ends it)."""
    refuse_while_navigating(bridge.navigator, "driving")
    if request.distance_m < 0.0 and not request.allow_reverse:
        raise ConflictError("driving backwards needs allow_reverse")
    motion = Drive(
        request.distance_m,
        speed_m_s=request.speed_m_s,
        timeout_s=request.timeout_s,
        allow_reverse=request.allow_reverse,
        gains=bridge.gains,
    )
    moving = bridge.move(motion, name="drive", epoch=request.epoch, session_id=request.session_id)
    return await while_connected(http, moving)


@router.delete("/motion")
async def end_motion(bridge: BridgeDep) -> MotionReply:
    """Cancels the rotation or drive under way; `completed` tells whether there was one."""
    ended = bridge.wheels.end_motion("cancelled")
    return MotionReply(completed=ended, moved=0.0, reason="cancelled" if ended else "nothing was under way")


async def _velocity(request: VelocityRequest, bridge: Bridge) -> tuple[VelocityReply, Refusal | None]:
    asked_s = bridge.clock.now_s()
    refusal = bridge.wheels.request(
        Request(
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
    )
    if refusal is not None:
        REFUSED.labels(refusal.value).inc()
        return VelocityReply(accepted=False, sent=_sent(bridge), reason=_explain(refusal, bridge)), refusal
    tick = await bridge.wheels.commanded.wait_for(lambda choice: choice.received_s >= asked_s, TICK_WAIT_S)
    if tick is None:
        raise UnavailableError("rclpy", "the motion loop does not tick")
    choice = tick.value
    mine = choice.source == request.source
    reason = choice.reason if mine else f"{choice.source} has the wheels" if choice.source != "none" else "it has ended"
    return VelocityReply(accepted=True, sent=choice.twist, reason=reason), None


def _sent(bridge: Bridge) -> Twist2D:
    choice = bridge.wheels.commanded.value
    return choice.twist if choice is not None else Twist2D()


def _explain(refusal: Refusal, bridge: Bridge) -> str:
    match refusal:
        case Refusal.STOPPED:
            return "the emergency stop is latched"
        case Refusal.OLD_EPOCH:
            return f"the epoch is {bridge.wheels.stop_state.epoch} now"
        case Refusal.BASE_IS_BUSY:
            return "the base is docking or undocking"
        case _:
            return refusal.value


def _first(error: ValidationError) -> str:
    first = error.errors()[0]
    return f"{'.'.join(str(part) for part in first['loc'])}: {first['msg']}"
