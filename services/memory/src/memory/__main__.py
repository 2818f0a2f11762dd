"""`python -m memory` runs the service with settings from the environment."""

from memory.app import create_app
from memory.settings import Settings
from mesh.logging import configure_logging
from mesh.server import serve
from mesh.tracing import configure_tracing


def main() -> None:
    configure_logging("memory")
    configure_tracing("memory")
    settings = Settings.read()
    serve(create_app(settings), host=settings.host, port=settings.port)


if __name__ == "__main__":
    main()
