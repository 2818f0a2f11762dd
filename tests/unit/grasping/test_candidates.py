"""Where the jaw may stand round a thing: geometry that holds for every thing."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contracts.manipulation import GraspKind
from grasping.candidates import (
    BACK_M,
    BESIDE_M,
    FLOOR_M,
    LIFT_M,
    OPEN_MORE_M_MIN,
    SQUARE_RAD,
    GraspCandidate,
    candidates_for,
    fits_any,
)
from grasping.hands import SO101_HAND as HAND
from grasping.things import MeasuredThing, grasp_kind_of

PLACES = st.tuples(st.floats(0.2, 0.5), st.floats(-0.2, 0.2))
SIZES = st.tuples(st.floats(0.02, 0.09), st.floats(0.02, 0.09), st.floats(0.03, 0.3))


def thing_at(
    x: float, y: float, size: tuple[float, float, float], *, yaw: float = 0.0, round_: bool = True
) -> MeasuredThing:
    return MeasuredThing(x, y, size[2] / 2, *size, yaw_rad=yaw, round=round_)


def all_of(thing: MeasuredThing, kind: GraspKind) -> list[GraspCandidate]:
    return list(candidates_for(thing, kind, HAND, 0.0))


@settings(max_examples=150, deadline=None)
@given(PLACES, SIZES, st.floats(-3.0, 3.0), st.booleans(), st.sampled_from(GraspKind))
def test_the_hand_stands_round_the_thing(
    place: tuple[float, float], size: tuple[float, float, float], yaw: float, round_: bool, kind: GraspKind
) -> None:
    thing = thing_at(*place, size, yaw=yaw, round_=round_)
    for one in all_of(thing, kind):
        rotation = one.tip.rotation
        assert np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-9)
        assert np.linalg.det(rotation) == pytest.approx(1.0)
        across = float((thing.centre - one.tip.at) @ one.tip.opens)
        assert across - one.width_m / 2 - HAND.face_m == pytest.approx(BESIDE_M, abs=2e-3), "the still jaw is beside it"
        assert one.gap_m >= one.width_m + BESIDE_M + OPEN_MORE_M_MIN, "and the other one clear of it"
        assert one.width_m <= HAND.grip_m_max


@settings(max_examples=100, deadline=None)
@given(PLACES, SIZES, st.sampled_from(GraspKind))
def test_the_fingertips_stay_off_the_floor(
    place: tuple[float, float], size: tuple[float, float, float], kind: GraspKind
) -> None:
    for one in all_of(thing_at(*place, size), kind):
        lowest_m = one.tip.at[2] - HAND.beyond_tip_m * math.sin(one.tip.pitch_rad)
        assert lowest_m >= FLOOR_M - 1e-9


@settings(max_examples=50, deadline=None)
@given(PLACES, SIZES, st.sampled_from(GraspKind))
def test_the_arm_stays_in_its_plane(
    place: tuple[float, float], size: tuple[float, float, float], kind: GraspKind
) -> None:
    """The hand points away from the first joint's axis: with five joints it cannot point elsewhere."""
    for one in all_of(thing_at(*place, size), kind):
        level = one.tip.approach[:2]
        away = one.tip.at[:2] - (HAND.pan_from_foot_m, 0.0)
        cross = level[0] * away[1] - level[1] * away[0]
        assert abs(cross) < 1e-3 * np.linalg.norm(away)


def test_it_comes_straight_in_and_goes_straight_up() -> None:
    one = all_of(thing_at(0.3, 0.0, (0.06, 0.06, 0.2)), GraspKind.SIDE)[0]
    assert np.allclose(one.before.at + BACK_M * one.tip.approach, one.tip.at)
    assert np.allclose(one.raised.at - one.tip.at, (0.0, 0.0, LIFT_M))


def test_what_is_too_wide_has_no_candidate_unless_it_is_narrow_the_other_way() -> None:
    wide = thing_at(0.3, 0.0, (0.12, 0.12, 0.05))
    assert not fits_any(wide, HAND)
    assert all_of(wide, GraspKind.TOP) == []
    book = thing_at(0.3, 0.0, (0.15, 0.03, 0.05), round_=False)
    assert fits_any(book, HAND)
    assert all_of(book, GraspKind.TOP)
    assert all(one.width_m < 0.07 for one in all_of(book, GraspKind.TOP))


@pytest.mark.parametrize("yaw", [0.0, 0.4, 0.8, 1.2, 2.9])
def test_a_box_is_taken_by_its_sides_and_straight_down_square_to_them(yaw: float) -> None:
    box = thing_at(0.3, 0.05, (0.06, 0.04, 0.05), yaw=yaw, round_=False)
    found = all_of(box, GraspKind.TOP)
    straight = [one for one in found if one.tip.pitch_rad > 1.5]
    assert sorted({round(one.width_m, 6) for one in straight}) == [0.04, 0.06]
    for one in found:
        off = math.remainder(math.atan2(one.tip.opens[1], one.tip.opens[0]) - yaw, math.pi / 2)
        assert abs(off) <= SQUARE_RAD + 1e-9


@pytest.mark.parametrize(
    ("label", "height_m", "kind"),
    [
        ("bottle", 0.2, GraspKind.SIDE), ("cup", 0.07, GraspKind.SIDE), ("apple", 0.07, GraspKind.TOP),
        ("teddy bear", 0.3, GraspKind.SIDE), ("scissors", 0.02, GraspKind.TOP),
    ],
)  # fmt: skip
def test_what_holds_something_is_taken_from_the_side_and_what_is_low_from_above(
    label: str, height_m: float, kind: GraspKind
) -> None:
    assert grasp_kind_of(label, height_m) is kind


@pytest.mark.parametrize("size", [(0.0, 0.1, 0.1), (0.1, math.nan, 0.1), (0.1, 0.1, math.inf)])
def test_what_is_no_thing_is_refused(size: tuple[float, float, float]) -> None:
    with pytest.raises(ValueError, match="a thing has"):
        MeasuredThing(0.3, 0.0, 0.1, *size)
