"""What is needed of a database system, and how its troubles are named."""

import sqlite3
from collections.abc import Generator
from contextlib import contextmanager
from typing import Protocol

from sqlalchemy import Engine
from sqlalchemy.exc import DBAPIError
from sqlalchemy.exc import TimeoutError as PoolTimeoutError

from mesh.errors import UnavailableError

CHECK_S = 0.3
"""A check waits so long for a lock."""


class Database(Protocol):
    """Every method blocks, and raises `UnavailableError` when the database cannot be had."""

    name: str

    def prepare(self, *, patience_s: float) -> None:
        """Afterwards it is there and has our tables; waits no longer than `patience_s` for a lock."""
        ...

    def writer(self) -> Engine:
        """One connection, whose transactions exclude every other writer, in this process or another."""
        ...

    def reader(self, connections: int) -> Engine: ...

    def check_writable(self) -> None:
        """Within half a second."""
        ...

    def after_forgetting(self, writer: Engine) -> None:
        """What was deleted is no longer in the files either, as far as the system allows."""
        ...

    def size_bytes(self, reader: Engine) -> int | None: ...


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
