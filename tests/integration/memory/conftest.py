"""A PostgreSQL server for the whole session; it takes some seconds to start."""

from collections.abc import Iterator

import pytest

from support.postgres_server import running_postgres


@pytest.fixture(scope="session")
def postgres_url() -> Iterator[str]:
    with running_postgres() as url:
        yield url
