"""A PostgreSQL database under the store, for more than one machine."""

from pathlib import Path
from typing import Any, NoReturn

from sqlalchemy import URL, Engine, create_engine, event, text

from contracts.backup import BackupRefusal
from memory.adapters.tables import MIGRATIONS
from mesh.errors import UnprocessableError
from store.backup import Reads
from store.copies import DatabaseCopy, JudgedDatabase
from store.migrations import upgrade
from store.troubles import naming_the_database

WRITERS_LOCK = 0x41544F4D
"""Of PostgreSQL's advisory locks, the one that all writers of ATOM's memory take: one at a time."""
CHECK_MS = 300
USE_ITS_OWN = (
    "memory is kept in PostgreSQL: back it up with `pg_dump --format=custom`, restore it with `pg_restore --clean`"
)


class Postgres:
    """A `store.database.Database`."""

    name = "postgresql"

    def __init__(self, url: URL, *, busy_timeout_s: float) -> None:
        self._url = url.set(drivername="postgresql+psycopg")
        self._busy_timeout_s = busy_timeout_s

    def prepare(self, *, patience_s: float) -> None:
        with naming_the_database():
            engine = self._engine(connections=1, lock_ms=int(patience_s * 1000), locks=True)
            try:
                with engine.begin() as connection:
                    upgrade(connection, MIGRATIONS)
            finally:
                engine.dispose()

    def writer(self) -> Engine:
        return self._engine(connections=1, lock_ms=int(self._busy_timeout_s * 1000), locks=True)

    def reader(self, connections: int) -> Engine:
        return self._engine(connections=connections, lock_ms=int(self._busy_timeout_s * 1000), locks=False)

    def check_writable(self) -> None:
        with naming_the_database():
            engine = self._engine(connections=1, lock_ms=CHECK_MS, locks=True)
            try:
                with engine.connect() as connection:
                    connection.execute(text("UPDATE alembic_version SET version_num = version_num"))
                    connection.rollback()
            finally:
                engine.dispose()

    def after_forgetting(self, writer: Engine) -> None:
        """Deleted rows stay in the server's files until its autovacuum; that is the server's to do."""

    def size_bytes(self, reader: Engine) -> int | None:
        with naming_the_database(), reader.connect() as connection:
            return connection.execute(
                text("SELECT pg_total_relation_size('views') + pg_total_relation_size('things')")
            ).scalar_one()

    def snapshot(self) -> DatabaseCopy:
        self._refuse()

    def place_for_candidate(self) -> Path:
        self._refuse()

    def judged(self, path: Path, reads: Reads) -> JudgedDatabase:
        self._refuse()

    def replace(self, candidate: JudgedDatabase) -> Path:
        self._refuse()

    def _refuse(self) -> NoReturn:
        """A server has a back-up of its own, which knows its users and settings too."""
        raise UnprocessableError(USE_ITS_OWN, code=BackupRefusal.USE_PG_DUMP.value)

    def _engine(self, *, connections: int, lock_ms: int, locks: bool) -> Engine:
        """Every transaction of a locking engine is the only one of its kind."""
        engine = create_engine(
            self._url,
            hide_parameters=True,
            pool_size=connections,
            max_overflow=0,
            pool_timeout=self._busy_timeout_s,
            pool_pre_ping=True,
            connect_args={"connect_timeout": 2, "options": f"-c lock_timeout={lock_ms}"},
        )
        if locks:

            def on_begin(connection: Any) -> None:
                connection.execute(text("SELECT pg_advisory_xact_lock(:key)"), {"key": WRITERS_LOCK})

            event.listen(engine, "begin", on_begin)
        return engine
