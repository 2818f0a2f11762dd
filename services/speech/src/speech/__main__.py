"""`python -m speech` runs the service with settings from the environment."""

import contextlib
import os
from pathlib import Path

from mesh.logging import configure_logging
from mesh.server import serve
from mesh.tracing import configure_tracing
from speech.app import create_app
from speech.settings import Settings


def give_way(nice: int) -> None:
    """Every thread: on Linux each has a niceness of its own, and libraries begin some while they are imported."""
    for thread in Path("/proc/self/task").iterdir():
        with contextlib.suppress(ProcessLookupError):  # it has ended meanwhile
            os.setpriority(os.PRIO_PROCESS, int(thread.name), os.getpriority(os.PRIO_PROCESS, int(thread.name)) + nice)


def main() -> None:
    configure_logging("speech")
    configure_tracing("speech")
    settings = Settings.read()
    give_way(settings.nice)
    serve(create_app(settings), host=settings.host, port=settings.port)


if __name__ == "__main__":
    main()
