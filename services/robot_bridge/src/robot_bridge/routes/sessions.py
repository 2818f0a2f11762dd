"""Sessions: what is bound to one ends with it."""

import asyncio
import contextlib
from typing import Annotated

import structlog
from fastapi import APIRouter, Query, WebSocket
from starlette.websockets import WebSocketDisconnect

from mesh.access import Role, requires_role
from mesh.errors import TooManyError
from robot_bridge.bridge import Bridge
from robot_bridge.routes.deps import BridgeDep

log = structlog.get_logger()

router = APIRouter(tags=["sessions"])


@router.websocket("/session")
@requires_role(Role.SERVICE)
async def session(
    socket: WebSocket, bridge: BridgeDep, source: Annotated[str, Query(min_length=1, max_length=40)] = "unknown"
) -> None:
    """Sends {"session_id": ...}; then wants to hear anything at all within every session timeout (beat at 10 Hz)."""
    await socket.accept()
    try:
        session_id = bridge.sessions.open(bridge.clock.now_s())
    except TooManyError as error:
        await socket.close(1013, error.detail)
        return
    try:
        await socket.send_json({"session_id": session_id})
        if not await _closes(socket, bridge, session_id):
            log.warning("a session fell silent", source=source)
    finally:
        bridge.end_session(session_id)


async def _closes(socket: WebSocket, bridge: Bridge, session_id: str) -> bool:
    """True when it has closed, false when it fell silent: the robot's thread judges that, however busy asyncio is."""
    listening = asyncio.ensure_future(_beat(socket, bridge, session_id))
    try:
        while not listening.done():
            await asyncio.wait({listening}, timeout=bridge.settings.session_timeout_s)
            if not bridge.sessions.is_open(session_id):
                break
    finally:
        silent = not bridge.sessions.is_open(session_id)
        listening.cancel()
        await asyncio.gather(listening, return_exceptions=True)
    if silent:
        with contextlib.suppress(RuntimeError, WebSocketDisconnect):
            await socket.close(1008, "the session fell silent")
    return not silent


async def _beat(socket: WebSocket, bridge: Bridge, session_id: str) -> None:
    while True:
        message = await socket.receive()
        if message["type"] == "websocket.disconnect" or not bridge.sessions.beat(session_id, bridge.clock.now_s()):
            return
