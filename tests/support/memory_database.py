"""Stores over a file, for tests."""

from pathlib import Path

from memory.adapters.store import SqlStore
from memory.settings import Settings


def opened(path: Path, **settings: float) -> SqlStore:
    return SqlStore.from_settings(Settings(database_url=f"sqlite:///{path}", **settings))
