"""How often a client may be wrong, and that counting it stays small."""

import pytest
from starlette.requests import HTTPConnection

from mesh.access.rate_limit import MINUTE_S, FailureRateLimit


class Time:
    now_s = 100.0

    def __call__(self) -> float:
        return self.now_s


def by(address: str) -> HTTPConnection:
    return HTTPConnection({"type": "http", "client": (address, 4711), "headers": []})


def test_a_client_may_be_wrong_so_often_a_minute() -> None:
    time = Time()
    limit = FailureRateLimit(2, now_s=time)
    assert [limit.hit(by("10.0.0.1")) for _ in range(3)] == [True, True, False]
    assert limit.hit(by("10.0.0.2"))
    time.now_s += MINUTE_S
    assert [limit.hit(by("10.0.0.1")) for _ in range(3)] == [True, True, False]


def test_the_minute_moves_with_each_wrong_one_and_a_refused_one_does_not_prolong_it() -> None:
    time = Time()
    limit = FailureRateLimit(2, now_s=time)
    assert limit.hit(by("10.0.0.1"))
    time.now_s += MINUTE_S / 2
    assert [limit.hit(by("10.0.0.1")) for _ in range(3)] == [True, False, False]
    time.now_s += MINUTE_S / 2
    assert [limit.hit(by("10.0.0.1")) for _ in range(2)] == [True, False]


@pytest.mark.parametrize(
    ("one", "other"),
    [("2001:db8:0:1::1", "2001:db8:0:1:ffff::2"), ("::ffff:10.0.0.1", "10.0.0.1"), ("fe80::1%eth0", "fe80::2%eth0")],
)
def test_addresses_that_one_machine_has_at_will_count_as_one(one: str, other: str) -> None:
    limit = FailureRateLimit(1)
    assert limit.hit(by(one))
    assert not limit.hit(by(other))


@pytest.mark.parametrize(
    ("one", "other"),
    [("2001:db8:0:1::1", "2001:db8:0:2::1"), ("::ffff:10.0.0.1", "::ffff:10.0.0.2"), ("testclient", "other")],
)
def test_another_network_is_another_client(one: str, other: str) -> None:
    limit = FailureRateLimit(1)
    assert limit.hit(by(one))
    assert limit.hit(by(other))


def test_one_that_was_right_is_taken_back() -> None:
    limit = FailureRateLimit(2)
    assert [limit.hit(by("10.0.0.1")) for _ in range(2)] == [True, True]
    limit.take_back(by("10.0.0.1"))
    limit.take_back(by("10.0.0.2"))
    assert [limit.hit(by("10.0.0.1")) for _ in range(2)] == [True, False]


def test_who_was_wrong_longest_ago_is_forgotten_where_there_are_too_many() -> None:
    limit = FailureRateLimit(1, clients_max=2)
    assert [limit.hit(by(f"10.0.0.{one}")) for one in (1, 2, 1)] == [True, True, False]
    assert limit.hit(by("10.0.0.3"))
    assert [limit.hit(by(f"10.0.0.{one}")) for one in (1, 3, 2)] == [False, False, True]
