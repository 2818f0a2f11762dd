"""Runs the service: `python -m ui`."""

from mesh.logging import configure_logging
from mesh.server import serve
from mesh.tracing import configure_tracing
from ui.app import create_app
from ui.settings import Settings


def main() -> None:
    configure_logging("ui")
    configure_tracing("ui")
    settings = Settings.read()
    serve(create_app(settings), host=settings.host, port=settings.port)


if __name__ == "__main__":
    main()
