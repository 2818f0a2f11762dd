"""What moves on the page: the browser asks for the next when the last is drawn, and never while hidden."""

import json

from fastapi import APIRouter, WebSocket, WebSocketDisconnect

from mesh.access import Role, requires_role
from ui.desk import Desk
from ui.routes.deps import desk_of

router = APIRouter(prefix="/live")

FRAME_WAIT_S = 2.0
SCENE_WAIT_S = 2.0
BELIEF = "belief"
"""Of the map's parts the one that a page asks for; the others are sent to every page."""


@router.websocket("/camera")
@requires_role(Role.VIEWER)
async def camera(socket: WebSocket) -> None:
    """Any text in; out, one binary message: length (4 bytes, big-endian), JSON (boxes, status line), JPEG.

    Where no new picture comes, a text instead: {"trouble": why}.
    """
    desk = desk_of(socket)
    await socket.accept()
    after_s: float | None = None
    try:
        while True:
            await socket.receive_text()
            shown = await desk.frames.other_than(after_s, wait_s=FRAME_WAIT_S)
            if shown is None:
                await socket.send_text(json.dumps({"trouble": desk.frames.trouble}))
                continue
            after_s = shown.stamp_s
            await socket.send_bytes(shown.packed)
    except (WebSocketDisconnect, KeyError, RuntimeError):  # KeyError: binary in; RuntimeError: it closed under a send
        return


@router.websocket("/scene")
@requires_role(Role.VIEWER)
async def marks(socket: WebSocket) -> None:
    """Any text in, with the word `belief` in it where that part is shown too; out, JSON of the map's parts that changed
    since the last message, or {} when none did in time.
    """
    desk = desk_of(socket)
    await socket.accept()
    sent: dict[str, int] = {}
    try:
        while True:
            with_belief = BELIEF in (await socket.receive_text()).split()
            until_s = desk.clock.now_s() + SCENE_WAIT_S
            while not (changed := _changed(desk, sent, with_belief=with_belief)) and desk.clock.now_s() < until_s:
                await desk.clock.sleep(desk.settings.scene_period_s)
            await socket.send_text(f"{{{','.join(changed)}}}")
            await desk.clock.sleep(desk.settings.scene_period_s)
    except (WebSocketDisconnect, KeyError, RuntimeError):
        return


def _changed(desk: Desk, sent: dict[str, int], *, with_belief: bool) -> list[str]:
    """The parts whose version is not the one sent, as JSON members; notes them as sent."""
    if desk.picture is None:
        return []
    desk.refresh_scan()
    if with_belief:
        desk.refresh_belief()
    changed: list[str] = []
    for name, part in desk.map_layers.newest(desk.picture, desk.facts, desk.clock.now_s()).items():
        if sent.get(name) != part.version and (with_belief or name != BELIEF):
            sent[name] = part.version
            changed.append(f'"{name}":{part.text}')
    return changed
