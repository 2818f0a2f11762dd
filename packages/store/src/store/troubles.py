"""How a database's troubles are named."""

import sqlite3
from collections.abc import Generator
from contextlib import contextmanager

from sqlalchemy.exc import DBAPIError
from sqlalchemy.exc import TimeoutError as PoolTimeoutError

from mesh.errors import UnavailableError


@contextmanager
def naming_the_database() -> Generator[None]:
    """Translates whatever the file system or the database says into `UnavailableError`."""
    try:
        yield
    except DBAPIError as error:
        raise UnavailableError("database", _first_line(error.orig)) from error
    except PoolTimeoutError as error:
        raise UnavailableError("database", "busy: too many wait for it") from error
    except (sqlite3.Error, OSError) as error:
        raise UnavailableError("database", str(error)) from error


def _first_line(error: object) -> str:
    """PostgreSQL's further lines may quote what was to be written."""
    return next(iter(str(error).splitlines()), type(error).__name__)
