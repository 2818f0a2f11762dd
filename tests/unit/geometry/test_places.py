"""Whether two maps are of one place, by what stands in them."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.map_likeness import changed, rewritten
from contracts.geometry import Pose2D
from geometry.grids import OccupancyGrid, decode, encode
from geometry.places import Verdict, content_id, same_place, sketch_of
from geometry.poses import compose
from support.homes import home

HOMES = [home(seed) for seed in range(6)]
HOME = HOMES[0]
SKETCH = sketch_of(HOME)
ORIGIN = Pose2D(x=0.0, y=0.0, yaw=0.0)
CHANGED = dict(changed(HOME))


def test_different_homes_in_one_frame_are_different_places() -> None:
    sketches = [sketch_of(home) for home in HOMES]
    verdicts = {same_place(a, b).verdict for a, b in itertools.permutations(sketches, 2)}
    assert verdicts == {Verdict.OTHER}


@pytest.mark.parametrize("how", list(CHANGED))
def test_a_home_mapped_again_or_lived_in_is_one_place(how: str) -> None:
    other = sketch_of(CHANGED[how])
    assert same_place(SKETCH, other).is_one_place
    assert same_place(other, SKETCH).is_one_place


def test_a_map_that_grows_says_so_and_the_old_one_is_still_of_the_same_place() -> None:
    begun = sketch_of(CHANGED["half seen"])
    assert same_place(begun, SKETCH).verdict is Verdict.GROWN
    assert same_place(SKETCH, begun).verdict is Verdict.SAME


@pytest.mark.parametrize(
    "frame", [Pose2D(x=1.5, y=0.0, yaw=0.0), Pose2D(x=0.0, y=0.0, yaw=math.pi / 2), Pose2D(x=-60.0, y=-60.0, yaw=0.0)]
)
def test_the_same_rooms_in_another_frame_are_another_place(frame: Pose2D) -> None:
    """What is remembered in the one frame means nothing in the other."""
    moved = OccupancyGrid(HOME.cells, HOME.resolution_m, compose(frame, HOME.origin))
    assert same_place(SKETCH, sketch_of(moved)).verdict is Verdict.OTHER


@pytest.mark.parametrize("pad", [0, 1, 7])
def test_a_map_saved_and_cut_anew_has_the_same_id(pad: int) -> None:
    cells = np.pad(HOME.cells, pad, constant_values=-1)
    corner = Pose2D(x=-pad * HOME.resolution_m, y=-pad * HOME.resolution_m, yaw=0.0)
    again = decode(encode(OccupancyGrid(cells, HOME.resolution_m, corner)))
    assert content_id(sketch_of(again)) == content_id(SKETCH)


def test_another_map_has_another_id() -> None:
    assert len({content_id(sketch_of(home)) for home in HOMES}) == len(HOMES)


def test_maps_without_walls_are_one_place_only_where_they_know_the_same() -> None:
    hall = OccupancyGrid(np.zeros((160, 200), np.int8), 0.05, ORIGIN)
    other = OccupancyGrid(np.zeros((100, 120), np.int8), 0.05, ORIGIN)
    far = OccupancyGrid(np.zeros((100, 120), np.int8), 0.05, Pose2D(x=-9_000.0, y=9_000.0, yaw=0.0))
    assert same_place(sketch_of(hall), sketch_of(rewritten(hall, 0.3, 0.05))).verdict is Verdict.SAME
    assert same_place(sketch_of(hall), sketch_of(other)).verdict is Verdict.OTHER
    assert same_place(sketch_of(hall), sketch_of(far)).verdict is Verdict.OTHER


def test_a_map_of_nothing_is_the_same_as_no_other() -> None:
    nothing = sketch_of(OccupancyGrid(np.full((5, 5), -1, np.int8), 0.05, ORIGIN))
    assert same_place(SKETCH, nothing).verdict is Verdict.OTHER
    assert same_place(nothing, SKETCH).verdict is Verdict.OTHER
    assert same_place(nothing, nothing).verdict is Verdict.OTHER


@settings(max_examples=20)
@given(st.sampled_from(HOMES), st.floats(-math.pi, math.pi), st.sampled_from([0.03, 0.05, 0.08]))
def test_how_a_map_is_written_down_makes_no_difference(home: OccupancyGrid, yaw: float, resolution_m: float) -> None:
    assert same_place(sketch_of(home), sketch_of(rewritten(home, yaw, resolution_m))).agreement > 0.9
