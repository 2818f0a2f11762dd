"""What routes ask for."""

import asyncio
from collections.abc import Coroutine
from typing import Annotated, Any, TypeVar

from fastapi import Depends
from starlette.requests import HTTPConnection, Request

from contracts.causes import Refusal
from mesh.errors import ConflictError
from robot_bridge.bridge import Bridge

T = TypeVar("T")


async def get_bridge(connection: HTTPConnection) -> Bridge:
    """Async: FastAPI runs other dependencies in its thread pool, and a stop must not wait for a thread."""
    bridge: Bridge = connection.state.bridge
    return bridge


BridgeDep = Annotated[Bridge, Depends(get_bridge)]


async def while_connected(request: Request, work: Coroutine[Any, Any, T]) -> T:
    """The work's result; cancels it when the client goes away first."""
    working = asyncio.ensure_future(work)
    leaving = asyncio.ensure_future(_gone(request))
    try:
        await asyncio.wait({working, leaving}, return_when=asyncio.FIRST_COMPLETED)
        if not working.done():
            raise ConflictError("the client went away", code=Refusal.CLIENT_LEFT)
        return working.result()
    finally:
        leaving.cancel()
        if not working.done():
            working.cancel()
        await asyncio.gather(working, leaving, return_exceptions=True)


async def _gone(request: Request) -> None:
    while (await request.receive())["type"] != "http.disconnect":
        pass
