"""When does `bench.soak` say that a process grows?"""

from collections.abc import Callable

import pytest

from bench.hostility.holding import Holding
from bench.soak import growth


def samples(held: Callable[[int], Holding], count: int = 30) -> list[tuple[float, dict[str, Holding]]]:
    return [(number * 5.0, {"memory": held(number)}) for number in range(count)]


def test_what_grows_while_it_warms_up_is_flat() -> None:
    assert growth(samples(lambda number: Holding(7, min(number, 10) * 20.0, min(20 + number, 30), 9))) == []


def test_one_large_picture_decides_nothing() -> None:
    assert growth(samples(lambda number: Holding(7, 900.0 if number == 25 else 100.0, 20, 9))) == []


@pytest.mark.parametrize(
    ("held", "said"),
    [
        (lambda number: Holding(7, 100.0 + 2 * number, 20, 9), "memory holds 149 MiB after 129"),
        (lambda number: Holding(7, 100.0, 20 + number, 9), "memory holds 44.5 handles after 34.5"),
        (lambda number: Holding(7, 100.0, 20, 9 + number // 3), "memory holds 17 threads after 14"),
        (lambda number: Holding(7 + number // 20, 100.0, 20, 9), "memory ended or was started anew"),
    ],
)
def test_a_leak_is_named(held: Callable[[int], Holding], said: str) -> None:
    assert [one.partition(" after ")[0] for one in growth(samples(held))] == [said.partition(" after ")[0]]


def test_a_process_that_was_away_once_is_named() -> None:
    some = samples(lambda _: Holding(7, 100.0, 20, 9))
    del some[20][1]["memory"]
    assert growth(some) == ["memory ended or was started anew"]


def test_too_few_samples_are_no_measurement() -> None:
    with pytest.raises(ValueError, match="5 samples"):
        growth(samples(lambda _: Holding(7, 100.0, 20, 9), 5))
