"""Fixtures every kind of test shares."""

from collections.abc import Iterator

import pytest

from support.redis_server import running_redis


@pytest.fixture(scope="session")
def redis_url() -> Iterator[str]:
    """A real redis-server of this test session's own."""
    with running_redis() as url:
        yield url
