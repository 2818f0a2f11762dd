"""`python -m speech` runs the service with settings from the environment."""

from mesh.logging import configure_logging
from mesh.server import serve
from mesh.tracing import configure_tracing
from speech.app import create_app
from speech.settings import Settings


def main() -> None:
    configure_logging("speech")
    configure_tracing("speech")
    settings = Settings.read()
    serve(create_app(settings), host=settings.host, port=settings.port)


if __name__ == "__main__":
    main()
