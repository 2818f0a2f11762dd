"""What routes and pages ask for."""

from typing import Annotated

from fastapi import Depends
from starlette.requests import HTTPConnection

from contracts.access import Principal
from mesh.access import current_principal, principal_of
from ui.desk import Desk
from ui.operator_actions import OperatorActions
from ui.sessions import PageSessions


def desk_of(connection: HTTPConnection) -> Desk:
    desk: Desk = connection.state.desk
    return desk


def sessions_of(connection: HTTPConnection) -> PageSessions | None:
    """None without keys."""
    sessions: PageSessions | None = connection.state.sessions
    return sessions


async def get_desk(connection: HTTPConnection) -> Desk:
    """Async: FastAPI runs other dependencies in its thread pool, and STOP must not wait for a thread."""
    return desk_of(connection)


async def get_actions(connection: HTTPConnection) -> OperatorActions:
    return OperatorActions(desk_of(connection), lambda: current_principal(connection))


def who_logged_in(connection: HTTPConnection) -> Principal | None:
    """None without keys, when nobody has to."""
    return principal_of(connection) if sessions_of(connection) is not None else None


def operator(connection: HTTPConnection | None) -> str:
    """Who asks, for the record of a stop."""
    client = connection.client if connection is not None else None
    principal = who_logged_in(connection) if connection is not None else None
    name = f" {principal.name}" if principal is not None else ""
    return f"ui{name} {client.host}" if client is not None else f"ui{name}"


DeskDep = Annotated[Desk, Depends(get_desk)]
ActionsDep = Annotated[OperatorActions, Depends(get_actions)]
