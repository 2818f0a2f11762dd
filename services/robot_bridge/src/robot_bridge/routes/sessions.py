"""Sessions: what is bound to one ends with it."""

import asyncio
import contextlib
from typing import Annotated

from fastapi import APIRouter, Query, WebSocket
from starlette.websockets import WebSocketDisconnect

from mesh.errors import TooManyError
from robot_bridge.bridge import Bridge
from robot_bridge.routes.deps import BridgeDep

router = APIRouter(tags=["sessions"])


@router.websocket("/session")
async def session(
    socket: WebSocket, bridge: BridgeDep, source: Annotated[str, Query(min_length=1, max_length=40)] = "unknown"
) -> None:
    """Sends {"session_id": ...}; then wants to hear anything at all within every session timeout (beat at 10 Hz)."""
    await socket.accept()
    try:
        session_id = bridge.sessions.open(source, bridge.clock.now_s())
    except TooManyError as error:
        await socket.close(1013, error.detail)
        return
    try:
        await socket.send_json({"session_id": session_id})
        await _listen(socket, bridge, session_id)
    finally:
        bridge.end_session(session_id)


async def _listen(socket: WebSocket, bridge: Bridge, session_id: str) -> None:
    """Until it closes or falls silent; the robot's thread judges the silence, whatever asyncio is busy with."""
    listening = asyncio.ensure_future(_beat(socket, bridge, session_id))
    try:
        while not listening.done():
            await asyncio.wait({listening}, timeout=bridge.settings.session_timeout_s)
            if not bridge.sessions.is_open(session_id):
                break
    finally:
        was_open = not listening.done()
        listening.cancel()
        await asyncio.gather(listening, return_exceptions=True)
    if was_open:
        with contextlib.suppress(RuntimeError, WebSocketDisconnect):
            await socket.close(1008, "the session fell silent")


async def _beat(socket: WebSocket, bridge: Bridge, session_id: str) -> None:
    while True:
        message = await socket.receive()
        if message["type"] == "websocket.disconnect" or not bridge.sessions.beat(session_id, bridge.clock.now_s()):
            return
