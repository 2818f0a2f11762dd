"""Stores over a file or a server, for tests."""

from pathlib import Path

from memory.adapters.store import SqlStore
from memory.settings import Settings


def opened(path: Path, **settings: float) -> SqlStore:
    return SqlStore.from_settings(Settings(database_url=f"sqlite:///{path}", **settings))


def opened_at(url: str, **settings: float) -> SqlStore:
    return SqlStore.from_settings(Settings(database_url=url, **settings))
