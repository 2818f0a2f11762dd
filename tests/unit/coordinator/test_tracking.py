"""Where a thing is, from many measurements of it."""

import math
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from coordinator.core.tracking import GATE, OUTLIERS_MAX, POSE_SIGMA_M, Track, fused, measured, squared_mahalanobis

BEARINGS = st.floats(-math.pi, math.pi)
DISTANCES = st.floats(0.3, 4.0)
SIGMAS = st.floats(0.005, 0.6)
SHARES = st.floats(-1.5, 1.5)


def seen(bearing_rad: float, distance_m: float, sigma_m: float, off: float = 0.0) -> Track:
    """The thing at (2, 1), measured `off` standard deviations too far away."""
    x, y = 2.0 + off * sigma_m * math.cos(bearing_rad), 1.0 + off * sigma_m * math.sin(bearing_rad)
    return measured(x, y, bearing_rad=bearing_rad, distance_m=distance_m, sigma_m=sigma_m)


SEEN = st.builds(seen, BEARINGS, DISTANCES, SIGMAS, SHARES)


@given(SEEN, st.lists(SEEN, min_size=1, max_size=30))
def test_what_is_known_only_grows_and_the_covariance_stays_one(first: Track, others: list[Track]) -> None:
    track = first
    for other in others:
        before = track
        track = fused(track, other)
        assert track.outliers or track.sigma_m <= before.sigma_m + 1e-9
        assert track.xx > 0.0
        assert track.yy > 0.0
        assert track.xx * track.yy - track.xy**2 > -1e-12
        assert track.sigma_m >= POSE_SIGMA_M


@given(SEEN, SEEN)
def test_the_place_lies_between_two_that_agree_whichever_came_first(one: Track, other: Track) -> None:
    both, turned = fused(one, other), fused(other, one)
    assert (both.hits == 2) == (turned.hits == 2) == (squared_mahalanobis(one, other) <= GATE)
    agreed = both.hits == 2
    assert not agreed or both.place == pytest.approx(turned.place, abs=1e-6)


@given(SEEN, BEARINGS, DISTANCES, SIGMAS)
def test_one_measurement_far_off_moves_nothing(track: Track, bearing_rad: float, away_m: float, sigma_m: float) -> None:
    far = measured(track.x + 30.0, track.y, bearing_rad=bearing_rad, distance_m=away_m, sigma_m=sigma_m)
    assert fused(track, far).place == track.place


def test_several_in_a_row_elsewhere_are_believed() -> None:
    track, elsewhere = seen(0.0, 2.0, 0.1), measured(6.0, 1.0, bearing_rad=0.0, distance_m=4.0, sigma_m=0.1)
    for _ in range(OUTLIERS_MAX):
        track = fused(track, elsewhere)
    assert (track.place, track.hits) == ((6.0, 1.0), 1)


def test_two_that_see_it_from_two_sides_know_it_in_both_directions() -> None:
    both = fused(seen(0.0, 2.0, 0.4), seen(math.pi / 2, 2.0, 0.4))
    assert both.sigma_m < 0.1 < seen(0.0, 2.0, 0.4).sigma_m


@pytest.mark.parametrize("seed", range(5))
def test_the_noise_of_a_drive_up_to_it_is_averaged_away(seed: int) -> None:
    noise = random.Random(seed)
    away_m = [3.0 - 0.06 * k for k in range(40)]
    looks = [seen(0.2, d, 0.012 * d**3.461, noise.gauss(0.0, 1.0)) for d in away_m]
    track = looks[0]
    for look in looks[1:]:
        track = fused(track, look)
    assert math.dist(track.place, (2.0, 1.0)) < 0.05
    assert track.hits >= 36
