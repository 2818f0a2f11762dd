"""What a sighting, a miss and time do to a belief."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from contracts.memory import ObjectState
from memory.belief import BELIEF_MAX, BELIEF_MIN, after_miss, after_sighting, aged, detectability, state_of
from memory.class_priors import kind_of

DAY_S = 86_400.0
beliefs = st.floats(BELIEF_MIN, BELIEF_MAX)
chances = st.floats(0.0, 0.95)


@given(beliefs, st.floats(0.0, 1.0))
def test_a_sighting_never_lowers_belief(belief: float, confidence: float) -> None:
    assert belief - 1e-9 <= after_sighting(belief, confidence) <= BELIEF_MAX


@given(beliefs, chances)
def test_a_miss_never_raises_it_and_nothing_is_ever_certain(belief: float, chance: float) -> None:
    after, loss = after_miss(belief, chance)
    assert BELIEF_MIN <= after <= belief + 1e-9
    assert 0.0 < loss <= 1.0


@given(beliefs, st.lists(chances, min_size=20, max_size=40))
def test_one_place_alone_cannot_make_a_sure_thing_lost(belief: float, chances: list[float]) -> None:
    now, loss = BELIEF_MAX, 1.0
    for chance in chances:
        now, loss = after_miss(now, chance, loss)
    assert state_of(now, now, moved=False) is not ObjectState.LOST


def test_two_places_can() -> None:
    now = BELIEF_MAX
    for _ in range(2):
        now, loss = after_miss(now, 0.8)
        now, _ = after_miss(now, 0.8, loss)
    assert state_of(now, now, moved=False) is ObjectState.LOST
    assert state_of(now, now, moved=True) is ObjectState.MOVED


def test_age_wears_a_cup_down_in_days_and_a_couch_in_years_but_never_to_nothing() -> None:
    week_s = 7.0 * DAY_S
    cup, couch = (aged(0.9, week_s, kind_of(label).half_life_s) for label in ("cup", "couch"))
    assert cup == pytest.approx(0.24, abs=0.02)
    assert couch == pytest.approx(0.89, abs=0.02)
    assert aged(0.9, 1000.0 * week_s, kind_of("cup").half_life_s) == pytest.approx(0.18)


def test_a_clock_that_went_back_changes_nothing() -> None:
    assert aged(0.9, -1e9, 60.0) == pytest.approx(0.9)


@pytest.mark.parametrize(
    ("distance_m", "reach", "confidence", "chance"),
    [(0.8, 1.0, 0.9, 0.8), (1.8, 1.0, 0.9, 0.55), (2.65, 1.0, 0.9, 0.05), (4.0, 1.0, 0.9, 0.0), (2.4, 2.0, 0.9, 0.8),
     (0.8, 1.0, 0.3, 0.4)],
)  # fmt: skip
def test_what_is_near_large_or_clear_is_hardly_overlooked(
    distance_m: float, reach: float, confidence: float, chance: float
) -> None:
    assert detectability(distance_m, reach, confidence) == pytest.approx(chance)
