"""HTTP: the catalogue of actions, and doing one of them."""

from typing import Annotated, Any

from fastapi import APIRouter, Depends
from starlette.requests import HTTPConnection, Request
from starlette.responses import Response

from contracts.actions import SPECS, Action, ActionDescription, ActionReply, StopAction, described
from coordinator.commands.action_service import ActionService
from mesh.access import Role, principal_of, public, requires_role
from mesh.tracing import TracedRoute

router = APIRouter(route_class=TracedRoute, tags=["actions"])


async def get_actions(connection: HTTPConnection) -> ActionService:
    actions: ActionService = connection.state.actions
    return actions


ActionsDep = Annotated[ActionService, Depends(get_actions)]
BEGUN: dict[int | str, dict[str, Any]] = {
    200: {"model": ActionReply, "description": "what moves nothing: it is done, and answered"}
}


@router.get("/actions")
@requires_role(Role.VIEWER)
async def catalogue() -> list[ActionDescription]:
    """Everything that can be asked for, each with the JSON schema of its arguments, as models that call tools take it;
    to stop comes first.
    """
    return [described(name) for name in SPECS]


@router.post("/actions", status_code=201, responses=BEGUN)
@requires_role(Role.VIEWER)
async def do(body: Action, request: Request, actions: ActionsDep, response: Response) -> ActionReply:
    """Does one action of the catalogue. What moves the robot is a mission (201): it begins at once, or waits while
    another runs. Questions and orders are answered (200). 403 where the action needs a higher role, 409 while the robot
    is stopped or low on power, 422 for what is not declared, is out of bounds, or names nothing known (`code` says
    which), 429 when the queue is full.
    """
    reply = await actions.do(body, principal_of(request))
    response.status_code = 201 if SPECS[body.action].moves else 200
    return reply


@router.post("/actions/stop")
@public
async def stop(actions: ActionsDep) -> ActionReply:
    """The action `stop`, without a key and without a body: ends every mission and all motion; where robot_bridge does
    not confirm that, its emergency stop is set.
    """
    return await actions.do(StopAction(), None)
