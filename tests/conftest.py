"""Fixtures every kind of test shares."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from support.redis_server import running_redis

settings.register_profile("atom", deadline=None)  # a busy machine is no failure: time is measured in bench/
settings.load_profile("atom")

TESTS = Path(__file__).parent
LONGEST_FIRST = ("simulation", "integration", "contract", "unit", "architecture", "e2e")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Order the tests for two workers, which take a file at a time: the long ones begin."""
    items.sort(key=lambda item: LONGEST_FIRST.index(item.path.relative_to(TESTS).parts[0]))


@pytest.fixture(scope="session")
def redis_url() -> Iterator[str]:
    """A real redis-server of this test session's own."""
    with running_redis() as url:
        yield url
