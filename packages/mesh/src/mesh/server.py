"""Runs a service's app under uvicorn, ending cleanly on SIGINT and SIGTERM."""

import uvicorn
from fastapi import FastAPI


def serve(app: FastAPI, *, host: str, port: int) -> None:
    """Blocks until the process is told to stop; open streams get two seconds to end."""
    uvicorn.run(app, host=host, port=port, log_level="warning", access_log=False, timeout_graceful_shutdown=2)
