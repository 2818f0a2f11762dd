"""`python -m inference` runs the service with settings from the environment."""

from inference.app import create_app
from inference.settings import Settings
from mesh.logging import configure_logging
from mesh.server import serve
from mesh.tracing import configure_tracing


def main() -> None:
    configure_logging("inference")
    configure_tracing("inference")
    settings = Settings.read()
    serve(create_app(settings), host=settings.host, port=settings.port)


if __name__ == "__main__":
    main()
