"""Copies of a database: what a snapshot made, and what was sent to take its place. Data only."""

from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO


@dataclass(frozen=True)
class DatabaseCopy:
    """`file` has no name any more: it is gone once it is closed, also when the process is killed."""

    file: BinaryIO
    size_bytes: int
    revision: str


@dataclass(frozen=True)
class JudgedDatabase:
    """A sound database of ours, brought to the newest schema; `revision` is the one it came with."""

    path: Path
    revision: str
    rows: dict[str, int]
