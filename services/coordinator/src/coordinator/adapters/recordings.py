"""Reads one recording out of the mission log's file without opening the log: a running coordinator is not disturbed."""

import sqlite3
import zlib
from contextlib import closing
from pathlib import Path

from mesh.errors import NotFoundError, UnavailableError


def stored_recording(database: Path, mission_id: str) -> list[str]:
    """The lines of a mission's recording; the start of an id will do. Raises `NotFoundError`, `UnavailableError`."""
    try:
        with closing(sqlite3.connect(f"file:{database}?mode=ro", uri=True)) as connection:
            ids = connection.execute(
                "SELECT DISTINCT mission_id FROM recordings WHERE substr(mission_id, 1, ?) = ?",
                (len(mission_id), mission_id),
            ).fetchall()
            if len(ids) != 1:
                raise NotFoundError(f"{len(ids)} recorded missions in {database} begin with '{mission_id}'")
            rows = connection.execute(
                "SELECT lines FROM recordings WHERE mission_id = ? ORDER BY number", ids[0]
            ).fetchall()
    except sqlite3.Error as error:
        raise UnavailableError("database", f"{database}: {error}") from error
    return [line for (lines,) in rows for line in zlib.decompress(lines).decode().splitlines()]
