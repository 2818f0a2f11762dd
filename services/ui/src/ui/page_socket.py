"""What a stranger may send on the page's own socket."""

import contextlib
import traceback
from typing import Final

import structlog
from starlette.types import ASGIApp, Receive, Scope, Send

log = structlog.get_logger()

SOCKET_PATH: Final = "_nicegui_ws/"
DECODERS: Final = ("engineio", "socketio")


class PageSocketErrors:
    """ASGI middleware: what is no engine.io packet ends NiceGUI's socket with 1003 (its decoder raises ValueError)."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "websocket" or SOCKET_PATH not in scope["path"]:
            await self.app(scope, receive, send)
            return
        try:
            await self.app(scope, receive, send)
        except ValueError as error:
            if not _of_a_decoder(error):
                raise
            log.info("the page's socket was sent what is no packet", error=str(error)[:80])
            with contextlib.suppress(RuntimeError, OSError):  # it may be closed already
                await send({"type": "websocket.close", "code": 1003})


def _of_a_decoder(error: ValueError) -> bool:
    """Raised by what reads the packets, and not by what is behind them: a mistake of ours stays one."""
    *_, (frame, _) = traceback.walk_tb(error.__traceback__)
    return str(frame.f_globals.get("__name__", "")).partition(".")[0] in DECODERS
