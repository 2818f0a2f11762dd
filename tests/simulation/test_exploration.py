"""An unknown home explored for a short while, by the real shell over the real robot_bridge in a simulated home."""

from typing import Any

import pytest

from bench.explore.play import played

HOME = 7101
pytestmark = pytest.mark.timeout(900)  # a minute on an idle machine


@pytest.fixture(scope="module", params=["sensible", "hostile"])
def record(request: pytest.FixtureRequest) -> dict[str, Any]:
    return played(HOME, request.param, seed=1, duration_s=25.0)


def test_it_sees_much_of_the_home_touches_nothing_and_ends_at_home(record: dict[str, Any]) -> None:
    assert record["died"] == []
    assert record["end"] == "time_up"
    assert record["from_home_m"] < 0.6
    assert record["collisions"] == 0
    assert record["seen"] > 0.4
    assert record["metres"] > 1.0


def test_each_action_was_written_once_and_each_call_counted(record: dict[str, Any]) -> None:
    assert record["actions"] == record["written"] > 0
    assert record["calls"] == sum(record["calls_by_reason"].values()) > 1
    assert record["tokens"] > 0
