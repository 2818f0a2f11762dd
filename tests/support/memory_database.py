"""Stores over a file or a server, for tests."""

from pathlib import Path
from typing import Any

from memory.adapters.store import SqlStore
from memory.settings import Settings


def opened(path: Path, **settings: Any) -> SqlStore:
    return SqlStore.from_settings(Settings(database_url=f"sqlite:///{path}", **settings))


def opened_at(url: str, **settings: Any) -> SqlStore:
    return SqlStore.from_settings(Settings(database_url=url, **settings))
