"""STOP: straight to robot_bridge; and whether it would arrive."""

from typing import Any, Final

from fastapi import APIRouter
from fastapi.responses import HTMLResponse, Response
from pydantic import Field
from starlette.requests import Request

from contracts.base import Message
from contracts.robot import EmergencyStopReply
from mesh.access import public
from mesh.errors import MeshError
from ui import plain
from ui.operator_actions import in_words
from ui.routes.deps import ActionsDep, DeskDep, operator

router = APIRouter(tags=["emergency stop"])

STOP_PATHS: Final = ("/stop", "/stop/")
"""Who types a slash too many means the same."""
HOW: Final = {"escape": "Esc pressed on the page", "form": "STOP pressed on the page, without its script"}
PAGE: Final[dict[int | str, dict[str, Any]]] = {200: {"content": {"text/html": {}}}}
NOW: Final = {"Cache-Control": "no-store"}


class WouldStop(Message):
    """A stop would arrive. Anybody may ask, so who stopped the robot and why is not told."""

    latched: bool | None = Field(description="the robot is stopped; none = the bridge does not tell the page")


@router.get("/stop")
@public
async def would_stop(desk: DeskDep, response: Response) -> WouldStop:
    """Whether the robot is stopped, asked over the way a stop takes. 503 while a stop would not reach it."""
    response.headers.update(NOW)
    return WouldStop(latched=await desk.stop_probe.ask())


@router.post(STOP_PATHS[1], response_model=EmergencyStopReply, include_in_schema=False)
@router.post(STOP_PATHS[0], response_model=EmergencyStopReply, responses=PAGE)
@public
async def stop(request: Request, desk: DeskDep, actions: ActionsDep) -> EmergencyStopReply | Response:
    """Stops the robot at once; nothing in the request can make it fail. 503 when robot_bridge cannot be reached.

    A browser's plain form (`Accept: text/html`) is answered with a page that says which.
    """
    reason = HOW.get(request.query_params.get("how", ""), "STOP pressed on the page")
    try:
        reply = await actions.emergency_stop(reason=reason, by=operator(request))
    except MeshError as error:
        if not _wants_page(request):
            raise
        otherwise = plain.remedy(desk.settings.robot_bridge_url)
        return HTMLResponse(plain.not_stopped(in_words(error), otherwise), 503, headers=NOW)
    return HTMLResponse(plain.stopped(reply), headers=NOW) if _wants_page(request) else reply


def _wants_page(request: Request) -> bool:
    return "text/html" in request.headers.get("accept", "")
