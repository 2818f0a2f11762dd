"""A run of training is over when its steps or its minutes are."""

import pytest

from sim.training.length import Length


def test_without_minutes_only_the_steps_count() -> None:
    assert Length(200).spent(50, 1e6) == pytest.approx(0.25)
    assert Length(200).spent(200, 0.0) == 1.0


def test_minutes_that_run_out_first_end_it() -> None:
    length = Length(1_000_000, 30.0)
    assert length.spent(10, 900.0) == pytest.approx(0.5)
    assert length.spent(10, 5000.0) == 1.0


def test_steps_that_run_out_first_end_it_before_its_minutes() -> None:
    assert Length(100, 30.0).spent(75, 60.0) == pytest.approx(0.75)


def test_the_steps_of_a_run_that_goes_on_end_with_its_minutes() -> None:
    clock = iter([100.0, 100.0, 130.0, 160.0])
    assert list(Length(1000, 1.0).steps_from(7, lambda: next(clock))) == [(7, 0.007), (8, 0.5)]


def test_a_run_without_minutes_does_every_step() -> None:
    assert [step for step, _ in Length(5).steps_from(2)] == [2, 3, 4]
