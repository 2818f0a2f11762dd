"""Runs a service's app under uvicorn, ending cleanly on SIGINT and SIGTERM."""

from typing import Any

import uvicorn
from fastapi import FastAPI


def serve(app: FastAPI, *, host: str, port: int) -> None:
    """Blocks until the process is told to stop; open streams get two seconds to end. `host`: several, with commas."""
    hosts: Any = host.split(",")  # uvicorn's type says one; asyncio's create_server, which it hands it to, takes more
    uvicorn.run(app, host=hosts, port=port, log_level="warning", access_log=False, timeout_graceful_shutdown=2)
