"""HTTP beside the page: the live picture, the map picture, and STOP."""

from typing import Annotated, Any, Final

from fastapi import APIRouter, Depends, Query
from fastapi.responses import Response
from starlette.requests import HTTPConnection, Request

from contracts.robot import EmergencyStopReply
from ui.desk import Desk

router = APIRouter()

HOW: Final = {"escape": "Esc pressed on the page"}
PNG_RESPONSE: dict[int | str, dict[str, Any]] = {200: {"content": {"image/png": {}}}}
JPEG_RESPONSE: dict[int | str, dict[str, Any]] = {
    200: {"description": "the newest annotated frame, its stamp in X-Stamp-S", "content": {"image/jpeg": {}}},
    204: {"description": "nothing newer came within wait_s"},
}


def get_desk(connection: HTTPConnection) -> Desk:
    desk: Desk = connection.state.desk
    return desk


DeskDep = Annotated[Desk, Depends(get_desk)]


@router.post("/stop", tags=["emergency stop"])
async def stop(request: Request, desk: DeskDep) -> EmergencyStopReply:
    """Stops the robot at once; nothing in the request can make it fail. 503 when robot_bridge cannot be reached."""
    reason = HOW.get(request.query_params.get("how", ""), "STOP pressed on the page")
    return await desk.emergency_stop(reason=reason, by=operator(request))


@router.get("/live/frame", tags=["live"], responses=JPEG_RESPONSE, response_class=Response)
async def frame(
    desk: DeskDep,
    after: Annotated[float | None, Query(description="stamp of the frame already seen", allow_inf_nan=False)] = None,
    wait_s: Annotated[float, Query(ge=0.0, le=10.0)] = 5.0,
) -> Response:
    """Long-poll: the newest annotated frame, once it is another than the one taken at `after`."""
    found = await desk.eyes.annotated(after_s=after, wait_s=wait_s)
    if found is None:
        return Response(status_code=204)
    headers = {"X-Stamp-S": f"{found.stamp_s:.6f}", "Cache-Control": "no-store"}
    return Response(found.jpeg, media_type="image/jpeg", headers=headers)


@router.get("/live/map.png", tags=["live"], responses=PNG_RESPONSE, response_class=Response)
async def map_png(desk: DeskDep, v: Annotated[str, Query(max_length=40)] = "") -> Response:
    """The known part of the map, one pixel a cell; the page asks for it once a version (`?v=`)."""
    picture = await desk.map_picture()
    lasting = "private, max-age=86400" if v == picture.version else "no-cache"
    headers = {"ETag": f'"{picture.version}"', "Cache-Control": lasting}
    return Response(picture.png, media_type="image/png", headers=headers)


def operator(connection: HTTPConnection | None) -> str:
    """Who asks, for the record of a stop."""
    client = connection.client if connection is not None else None
    return f"ui {client.host}" if client is not None else "ui"
