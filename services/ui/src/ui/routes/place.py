"""A click on the map: go there, look there."""

from fastapi import APIRouter
from pydantic import Field

from contracts.base import Message
from mesh.access import Role, requires_role
from mesh.errors import UnprocessableError
from ui.operator_actions import ActionResult
from ui.routes.deps import ActionsDep, DeskDep

router = APIRouter(prefix="/place", tags=["place"])


class Click(Message):
    """A point of the map's picture."""

    x_px: float = Field(ge=0.0, le=10_000.0)
    y_px: float = Field(ge=0.0, le=10_000.0)
    version: str = Field(max_length=40, description="of the picture that was clicked on")


@router.post("/go")
@requires_role(Role.OPERATOR)
async def go(click: Click, desk: DeskDep, actions: ActionsDep) -> ActionResult:
    """Drives there. A refusal is an answer: `ok` is false and `text` says why."""
    return await actions.go(*await _metres(click, desk))


@router.post("/look")
@requires_role(Role.OPERATOR)
async def look(click: Click, desk: DeskDep, actions: ActionsDep) -> ActionResult:
    """Turns to look there; answers when it does."""
    return await actions.look(*await _metres(click, desk))


@router.post("/halt")
@requires_role(Role.OPERATOR)
async def halt(actions: ActionsDep) -> ActionResult:
    """Gives up the drive or turn asked for here."""
    return await actions.halt()


async def _metres(click: Click, desk: DeskDep) -> tuple[float, float]:
    picture = await desk.map_picture()
    if click.version != picture.version:
        raise UnprocessableError("the map has changed since: click again")
    if click.x_px > picture.frame.width_px or click.y_px > picture.frame.height_px:
        raise UnprocessableError("that is not on the map")
    return picture.frame.to_map(click.x_px, click.y_px)
