"""Pictures: one, newer than the last (long-poll), or all of them (MJPEG)."""

from typing import Annotated

from fastapi import APIRouter, Query
from fastapi.responses import Response, StreamingResponse

from mesh.access import Role, requires_role
from mesh.errors import TooManyError, UnavailableError
from mesh.tracing import TracedRoute
from robot_bridge.routes.deps import BridgeDep
from robot_bridge.sensing.camera import BOUNDARY

router = APIRouter(prefix="/camera", tags=["camera"], route_class=TracedRoute)


@router.get(
    "/frame",
    response_class=Response,
    responses={200: {"content": {"image/jpeg": {}}}, 204: {"description": "no newer frame within wait_s"}},
)
@requires_role(Role.VIEWER)
async def frame(
    bridge: BridgeDep,
    after: Annotated[float | None, Query(ge=0.0, allow_inf_nan=False, description="X-Stamp-S of the last one")] = None,
    wait_s: Annotated[float, Query(ge=0.0, le=10.0)] = 0.0,
) -> Response:
    """The newest frame as JPEG. Headers: X-Stamp-S, X-Width, X-Height, and X-Pose ("x,y,yaw" of base_link in map when
    the frame was taken; absent while the robot is not localised). 503 when the camera is silent."""
    picture = await bridge.camera.picture(after_s=after, wait_s=wait_s)
    senses = bridge.robot.senses
    age_s = senses.rgb.age_s(bridge.clock.now_s())
    if age_s is None or age_s > bridge.settings.image_age_s_max:
        raise UnavailableError("rgb", senses.reception.why_none("rgb", "the camera is silent"))
    if picture is None:
        return Response(status_code=204)
    headers = {
        "X-Stamp-S": f"{picture.stamp_s:.6f}",
        "X-Width": str(picture.width_px),
        "X-Height": str(picture.height_px),
        "Cache-Control": "no-store",
    }
    pose = senses.poses.at(picture.stamp_s)
    if pose is not None:
        headers["X-Pose"] = f"{pose.x:.4f},{pose.y:.4f},{pose.yaw:.5f}"
    return Response(picture.jpeg, media_type="image/jpeg", headers=headers)


@router.get(
    "/stream", response_class=StreamingResponse, responses={200: {"content": {"multipart/x-mixed-replace": {}}}}
)
@requires_role(Role.VIEWER)
async def stream(bridge: BridgeDep) -> StreamingResponse:
    """MJPEG for as long as the viewer stays."""
    if bridge.camera.viewers >= bridge.settings.stream_viewers_max:
        raise TooManyError(f"{bridge.settings.stream_viewers_max} viewers are watching")
    senses = bridge.robot.senses
    if senses.rgb.newest is None:
        raise UnavailableError("rgb", senses.reception.why_none("rgb", "no frame has been received"))
    return StreamingResponse(
        bridge.camera.stream(),
        media_type=f"multipart/x-mixed-replace; boundary={BOUNDARY}",
        headers={"Cache-Control": "no-store"},
    )
