"""An app behind a real uvicorn on a free port, for tests that need sockets."""

import asyncio
import contextlib
from collections.abc import AsyncIterator
from typing import Any, Literal

import uvicorn

from mesh.server import DrainingServer, RequestLimitsProtocol, WebSocketLimitsProtocol
from support.redis_server import free_port
from support.waiting import until


@contextlib.asynccontextmanager
async def served(app: Any, *, lifespan: Literal["auto", "off"] = "auto") -> AsyncIterator[str]:
    """Yields its base URL once it answers. `lifespan` off: somebody else keeps that of this ASGI app."""
    port = free_port()
    config = uvicorn.Config(
        app,
        host="127.0.0.1",
        port=port,
        http=RequestLimitsProtocol,
        ws=WebSocketLimitsProtocol,
        log_level="warning",
        lifespan=lifespan,
        timeout_graceful_shutdown=1,
    )
    server = DrainingServer(config, app)
    server.capture_signals = contextlib.nullcontext  # type: ignore[method-assign]  # the test runner keeps its own
    running = asyncio.create_task(server.serve())
    try:
        await until(lambda: server.started or running.done())
        yield f"http://127.0.0.1:{port}"
    finally:
        server.should_exit = True
        await running
