"""What is needed of a database system."""

from pathlib import Path
from typing import Protocol

from sqlalchemy import Engine

from store.backup import Reads
from store.copies import DatabaseCopy, JudgedDatabase

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

    def snapshot(self) -> DatabaseCopy:
        """Its content at one moment, as an SQLite file; like what follows it raises `UnprocessableError` where the
        database is no file."""
        ...

    def place_for_candidate(self) -> Path:
        """A file beside it, of a name that nothing else has; nothing of it is left from before."""
        ...

    def judged(self, path: Path, reads: Reads) -> JudgedDatabase:
        """The file there, believed and migrated; `UnprocessableError` says what is wrong with it."""
        ...

    def replace(self, candidate: JudgedDatabase) -> Path:
        """All or nothing; while nothing else of this process writes. Returns what keeps the content from before."""
        ...
