"""Settings that cannot work are refused before anything starts."""

import pytest
from pydantic import ValidationError

from memory.settings import Settings


@pytest.mark.parametrize(
    "url", ["sqlite://", "sqlite:///", "sqlite:///:memory:", "sqlite:///a.db?mode=ro", "mysql://localhost/atom"]
)
def test_a_database_that_is_neither_a_file_nor_a_postgresql_server_is_refused(url: str) -> None:
    with pytest.raises(ValidationError, match="must name a file"):
        Settings(database_url=url)


def test_a_server_is_named_by_its_url() -> None:
    assert Settings(database_url="postgresql://atom@db:5432/atom").database_url.endswith("/atom")


def test_settings_come_from_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MEMORY_EXCLUDED_LABELS", '["person", "cat"]')
    monkeypatch.setenv("MEMORY_PORT", "20003")
    assert Settings().excluded_labels == ("person", "cat")
    assert Settings().port == 20003
