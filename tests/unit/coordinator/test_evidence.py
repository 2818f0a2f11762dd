"""All looks at one thing: in any order, within bounds, and a repeated look says little new."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from contracts.vision import Verdict, Vote
from coordinator.core.evidence import LOOK_LOG_ODDS_MAX, Judgement, fused, said_by


def look(log_odds: float, side_rad: float = 0.0, distance_m: float = 1.0) -> Judgement:
    return Judgement((0.0, 0.0), (distance_m * math.cos(side_rad), distance_m * math.sin(side_rad)), log_odds)


LOOKS = st.lists(
    st.builds(
        look,
        st.floats(-LOOK_LOG_ODDS_MAX, LOOK_LOG_ODDS_MAX),
        st.floats(-math.pi, math.pi),
        st.floats(0.3, 3.0),
    ),
    min_size=1,
    max_size=12,
)


@given(looks=LOOKS, data=st.data())
def test_the_order_of_the_looks_makes_no_difference(looks: list[Judgement], data: st.DataObject) -> None:
    shuffled = data.draw(st.permutations(looks))
    assert fused(shuffled) == pytest.approx(fused(looks))


@given(looks=LOOKS)
def test_no_number_of_looks_says_more_than_as_many_independent_ones_nor_the_contrary_of_all(
    looks: list[Judgement],
) -> None:
    assert min(0.0, math.fsum(min(0.0, one.log_odds) for one in looks)) <= fused(looks) + 1e-9
    assert fused(looks) <= math.fsum(max(0.0, one.log_odds) for one in looks) + 1e-9


@given(log_odds=st.floats(-3, 3), times=st.integers(1, 30))
def test_the_same_look_many_times_is_one_look(log_odds: float, times: int) -> None:
    assert fused([look(log_odds)] * times) == pytest.approx(log_odds)


@given(log_odds=st.floats(0.1, 3), side_rad=st.floats(1.5, 3.1))
def test_a_look_from_another_side_adds_but_not_as_much_as_the_first(log_odds: float, side_rad: float) -> None:
    assert log_odds < fused([look(log_odds), look(log_odds, side_rad)]) < 2 * log_odds


@given(many=st.integers(4, 9))
def test_one_picture_does_not_overturn_many_from_other_sides(many: int) -> None:
    sides = [look(1.5, k * math.tau / (many + 1)) for k in range(many)]
    assert fused([*sides, look(-LOOK_LOG_ODDS_MAX, many * math.tau / (many + 1))]) > 0.0


def test_a_votes_measured_log_odds_count_and_an_unmeasured_yes_and_no_cancel_out() -> None:
    yes, no = (Vote(voter="clip", verdict=verdict) for verdict in (Verdict.YES, Verdict.NO))
    assert said_by((yes, no, Vote(voter="vlm", verdict=Verdict.ABSTAIN))) == 0.0
    assert said_by((yes.model_copy(update={"log_odds": 2.5}), yes)) == LOOK_LOG_ODDS_MAX
    assert said_by((no.model_copy(update={"log_odds": -0.4}), yes)) == pytest.approx(0.6)
