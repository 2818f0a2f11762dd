"""Settings that cannot work are refused before anything starts."""

from pathlib import Path

import pytest
from pydantic import ValidationError

from coordinator.settings import Settings


@pytest.mark.parametrize(
    ("url", "file"),
    [
        ("sqlite+aiosqlite:///coordinator.db", "coordinator.db"),
        ("sqlite+aiosqlite:////data/home #1.db", "/data/home #1.db"),
        ("sqlite:////data/home 100%.db", "/data/home 100%.db"),
        ("sqlite+aiosqlite:////data/h\u00e4user \u00fc.db", "/data/h\u00e4user \u00fc.db"),
        ("sqlite+aiosqlite:////data/home%3F.db", "/data/home?.db"),
    ],
)
def test_a_database_is_the_file_it_names(url: str, file: str) -> None:
    assert Settings(database_url=url).database_file == Path(file)


@pytest.mark.parametrize(
    "url",
    [
        "sqlite+aiosqlite:///home?.db",
        "sqlite+aiosqlite://",
        "sqlite+aiosqlite:///",
        "sqlite+aiosqlite:///:memory:",
        "sqlite+aiosqlite://data/coordinator.db",
        "postgresql://atom@db/atom",
        "coordinator.db",
    ],
)
def test_a_database_that_is_no_file_is_refused_instead_of_another_one_being_opened(url: str) -> None:
    with pytest.raises(ValidationError, match="must name a file"):
        Settings(database_url=url)
