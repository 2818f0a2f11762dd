"""Runs the service: `python -m coordinator`."""

from coordinator.app import create_app
from coordinator.settings import Settings
from mesh.logging import configure_logging
from mesh.server import serve
from mesh.tracing import configure_tracing


def main() -> None:
    configure_logging("coordinator")
    configure_tracing("coordinator")
    settings = Settings.read()
    serve(create_app(settings), host=settings.host, port=settings.port)


if __name__ == "__main__":
    main()
