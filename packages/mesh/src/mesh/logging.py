"""Structured logs on stderr: readable on a terminal, JSON lines where `ATOM_LOG_JSON=1`."""

import logging
import os
import sys

import structlog

from mesh.tracing import add_trace_id


def configure_logging(service: str, *, level: str = "INFO") -> None:
    """Sets up structlog and the standard library's root logger for one process."""
    as_json = os.environ.get("ATOM_LOG_JSON", "0") == "1"
    logging.basicConfig(stream=sys.stderr, level=level, format=f"%(levelname)s {service} %(name)s: %(message)s")
    for noisy in ("httpx", "httpcore", "uvicorn.access"):
        logging.getLogger(noisy).setLevel(logging.WARNING)
    structlog.configure(
        processors=[
            structlog.contextvars.merge_contextvars,
            add_trace_id,
            structlog.processors.add_log_level,
            structlog.processors.TimeStamper(fmt="iso"),
            structlog.processors.format_exc_info,
            structlog.processors.JSONRenderer() if as_json else structlog.dev.ConsoleRenderer(colors=False),
        ],
        wrapper_class=structlog.make_filtering_bound_logger(logging.getLevelNamesMapping()[level]),
        logger_factory=structlog.PrintLoggerFactory(sys.stderr),
    )
    structlog.contextvars.bind_contextvars(service=service)
