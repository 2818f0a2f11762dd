"""Closed-loop motions: turning and driving on odometry, and their tuning."""

from fastapi import APIRouter
from starlette.requests import Request as HttpRequest

from contracts.causes import Refusal
from contracts.motion import DriveReply, DriveRequest, EndedMotion, MotionEnd, MotionGains, RotateReply, RotateRequest
from mesh.access import Role, requires_role
from mesh.errors import ConflictError, UnprocessableError
from mesh.tracing import TracedRoute
from robot_bridge.motion.motions import DriveOnHeading, Spin
from robot_bridge.navigation.goal_executor import refuse_while_navigating
from robot_bridge.routes.deps import BridgeDep, while_connected

router = APIRouter(tags=["motion"], route_class=TracedRoute)


@router.post("/rotate")
@requires_role(Role.OPERATOR)
async def rotate(request: RotateRequest, http: HttpRequest, bridge: BridgeDep) -> RotateReply:
    """Turns by an angle on odometry; answers when it is done or given up. Ends with the connection."""
    refuse_while_navigating(bridge.goals, "turning")
    _refuse_faster(request.speed_rad_s, bridge.settings.turn_rad_s_max, "rad/s")
    motion = Spin(request.angle_rad, speed_rad_s=request.speed_rad_s, timeout_s=request.timeout_s, tuning=bridge.tuning)
    moving = bridge.move(motion, name="rotate", epoch=request.epoch, session_id=request.session_id)
    return await while_connected(http, moving)


@router.post("/drive")
@requires_role(Role.OPERATOR)
async def drive(request: DriveRequest, http: HttpRequest, bridge: BridgeDep) -> DriveReply:
    """Drives a distance on odometry; answers when it is done or given up (an obstacle or a lost connection ends it)."""
    refuse_while_navigating(bridge.goals, "driving")
    _refuse_faster(request.speed_m_s, bridge.settings.speed_m_s_max, "m/s")
    if request.distance_m < 0.0 and not request.allow_reverse:
        raise ConflictError("driving backwards needs allow_reverse", code=Refusal.NO_REVERSE)
    motion = DriveOnHeading(
        request.distance_m,
        speed_m_s=request.speed_m_s,
        timeout_s=request.timeout_s,
        allow_reverse=request.allow_reverse,
        tuning=bridge.tuning,
    )
    moving = bridge.move(motion, name="drive", epoch=request.epoch, session_id=request.session_id)
    return await while_connected(http, moving)


@router.delete("/motion")
@requires_role(Role.OPERATOR)
async def end_motion(bridge: BridgeDep) -> EndedMotion:
    """Ends the `/rotate` or `/drive` under way, whoever asked for it, or a goal's recovery, and nothing else.

    A goal has its own DELETE, a lease runs out or is replaced by its source, docking ends with its connection; the
    emergency stop ends all of them.
    """
    return bridge.wheels.end_motion(MotionEnd.CANCELED)


@router.get("/motion/gains")
@requires_role(Role.VIEWER)
async def gains(bridge: BridgeDep) -> MotionGains:
    """What closed-loop turning and driving are tuned to."""
    return bridge.tuning.gains


@router.put("/motion/gains")
@requires_role(Role.ADMIN)
async def tune(request: MotionGains, bridge: BridgeDep) -> MotionGains:
    """Acts at once, on the motion under way too; forgotten when the process ends (the settings hold what lasts)."""
    bridge.tuning.gains = request
    return bridge.tuning.gains


def _refuse_faster(wanted: float, most: float, unit: str) -> None:
    if wanted > most:
        text = f"{wanted:g} {unit} is more than this robot's {most:g} {unit}"
        raise UnprocessableError(text, code=Refusal.TOO_FAST)
