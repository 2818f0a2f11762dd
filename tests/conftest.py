"""Fixtures every kind of test shares."""

from collections.abc import Iterator

import pytest
from hypothesis import settings

from support.redis_server import running_redis

settings.register_profile("atom", deadline=None)  # a busy machine is no failure: time is measured in bench/
settings.load_profile("atom")


@pytest.fixture(scope="session")
def redis_url() -> Iterator[str]:
    """A real redis-server of this test session's own."""
    with running_redis() as url:
        yield url
