"""A click on a room's name: what it is called from now on."""

from typing import Annotated

from fastapi import APIRouter, Path

from contracts.rooms import NameRoom
from mesh.access import Role, requires_role
from ui.operator_actions import ActionResult
from ui.routes.deps import ActionsDep

router = APIRouter(prefix="/rooms", tags=["rooms"])


@router.put("/{number}/name")
@requires_role(Role.OPERATOR)
async def name(number: Annotated[int, Path(ge=1, le=2**31 - 1)], body: NameRoom, actions: ActionsDep) -> ActionResult:
    """Gives the room that name in memory; '' takes a person's name away. A refusal is an answer: `ok` is false and
    `text` says why."""
    return await actions.name_room(number, body.name)
