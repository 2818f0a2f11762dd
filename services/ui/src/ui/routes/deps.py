"""What routes and pages ask for."""

from typing import Annotated

from fastapi import Depends
from starlette.requests import HTTPConnection

from ui.desk import Desk
from ui.operator_actions import OperatorActions


def desk_of(connection: HTTPConnection) -> Desk:
    desk: Desk = connection.state.desk
    return desk


async def get_desk(connection: HTTPConnection) -> Desk:
    """Async: FastAPI runs other dependencies in its thread pool, and STOP must not wait for a thread."""
    return desk_of(connection)


async def get_actions(connection: HTTPConnection) -> OperatorActions:
    return OperatorActions(desk_of(connection))


def operator(connection: HTTPConnection | None) -> str:
    """Who asks, for the record of a stop."""
    client = connection.client if connection is not None else None
    return f"ui {client.host}" if client is not None else "ui"


DeskDep = Annotated[Desk, Depends(get_desk)]
ActionsDep = Annotated[OperatorActions, Depends(get_actions)]
