"""What a history's records hold: parts of recordings packed and unpacked, and all of it read before it is believed."""

import sqlite3
import zlib
from collections.abc import Iterator, Sequence
from contextlib import closing
from pathlib import Path

import structlog
from sqlalchemy import Connection, func, select

from contracts.mission import Mission, MissionEvent
from coordinator.adapters.tables import EVENTS, events, missions, numbering, recordings
from store.troubles import naming_the_database

log = structlog.get_logger()

PART_BYTES_MAX = 16_000_000
PART_LINES_MAX = 100_000
"""Of a recording's part, unpacked: what one flush writes of it, or less. A line takes far more memory than its text."""


EVENT_ID_MAX = 2**53 - 2**32
"""What JSON's readers keep exactly, and room for what follows."""


def everything(connection: Connection) -> None:
    """A `store.backup.Reads`: raises `ValueError` for what could not be told anybody."""
    rows = connection.execution_options(yield_per=1000)
    for row in rows.execute(select(missions.c.id, missions.c.record)):
        if Mission.model_validate_json(row.record).id != row.id:
            raise ValueError(f"mission {row.id[:64]!r} is recorded under another name")
    for row in rows.execute(select(events.c.id, events.c.line)):
        if MissionEvent.model_validate_json(row.line).id != row.id:
            raise ValueError(f"event {row.id} is recorded under another number")
    if next_event_id(connection) > EVENT_ID_MAX:
        raise ValueError("its events are numbered higher than any of ours")
    for row in rows.execute(select(recordings.c.lines)):
        unpacked(row.lines)


def next_event_id(connection: Connection) -> int:
    """Higher than that of every event that is there, or was before a restore took it away."""
    newest = connection.execute(select(func.max(events.c.id))).scalar()
    given = connection.execute(select(numbering.c.next).where(numbering.c.name == EVENTS)).scalar()
    return max(0 if newest is None else newest + 1, given or 0)


def number_on(path: Path, next_id: int) -> None:
    """In the history at `path` no event gets a lower id than `next_id`. Blocks. Raises `UnavailableError`."""
    with naming_the_database(), closing(sqlite3.connect(path)) as connection, connection:
        connection.execute(
            "INSERT INTO numbering (name, next) VALUES (?, ?) ON CONFLICT (name) DO UPDATE SET next = max(next, ?)",
            (EVENTS, next_id, next_id),
        )


def parts(lines: Sequence[str]) -> Iterator[bytes]:
    """Each within the bounds of a part; a line that is longer than all of one is left out."""
    part: list[bytes] = []
    size_bytes = 0
    for line in lines:
        data = line.encode()
        if len(data) > PART_BYTES_MAX:
            log.error("a line of a recording is too long to be kept", size_bytes=len(data))
            continue
        if part and (size_bytes + len(data) + 1 > PART_BYTES_MAX or len(part) == PART_LINES_MAX):
            yield b"\n".join(part)
            part, size_bytes = [], 0
        part.append(data)
        size_bytes += len(data) + 1
    if part:
        yield b"\n".join(part)


def unpacked(part: bytes) -> str:
    """Lines, of a number that can be split. Raises `ValueError`."""
    unpacker = zlib.decompressobj()
    try:
        text = unpacker.decompress(part, PART_BYTES_MAX + 1)
    except zlib.error as error:
        raise ValueError(f"a recording cannot be unpacked: {error}") from error
    if len(text) > PART_BYTES_MAX or text.count(b"\n") >= PART_LINES_MAX:
        raise ValueError("a part of a recording is larger than any of ours")
    if not unpacker.eof:
        raise ValueError("a recording cannot be unpacked: it is cut off")
    return text.decode()
