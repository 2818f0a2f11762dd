"""Settings that cannot work are refused before anything starts."""

import pytest
from pydantic import ValidationError

from memory.settings import Settings


@pytest.mark.parametrize(
    "url", ["sqlite:///memory.db", "sqlite+aiosqlite://", "sqlite+aiosqlite:///:memory:", "postgresql://localhost/atom"]
)
def test_a_database_that_is_no_sqlite_file_is_refused(url: str) -> None:
    with pytest.raises(ValidationError, match="must name a file"):
        Settings(database_url=url)


def test_settings_come_from_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MEMORY_EXCLUDED_LABELS", '["person", "cat"]')
    monkeypatch.setenv("MEMORY_PORT", "20003")
    assert Settings().excluded_labels == ("person", "cat")
    assert Settings().port == 20003
