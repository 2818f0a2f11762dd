"""Postures made a trajectory, and ways between postures that touch nothing."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contracts.arm import POINT_APART_S_MIN, POINTS_MAX
from grasping.candidates import TipPose
from grasping.planning import Joints, way_between
from grasping.things import MeasuredThing
from grasping.timing import timed

POSTURES = st.lists(st.tuples(*[st.floats(-1.5, 1.5)] * 5), min_size=2, max_size=6)


@settings(max_examples=100, deadline=None)
@given(POSTURES, st.floats(0.2, 2.0))
def test_no_joint_is_faster_than_it_may_and_it_ends_where_it_is_to(path: list[Joints], speed_rad_s: float) -> None:
    knots = timed(tuple(path), speed_rad_s)
    times = np.array([0.0, *(time_s for time_s, _ in knots)])
    joints = np.array([path[0], *(each for _, each in knots)])
    speeds = np.abs(np.diff(joints, axis=0)) / np.diff(times)[:, None]
    assert speeds.max() <= speed_rad_s * 1.01
    assert joints[-1] == pytest.approx(np.array(path[-1]))
    assert np.diff(times).min() > POINT_APART_S_MIN
    assert len(knots) <= POINTS_MAX


def test_it_begins_and_ends_slowly() -> None:
    knots = timed(((0.0,) * 5, (1.0,) * 5), 0.5)
    steps = np.diff([0.0, *(joints[0] for _, joints in knots)])
    assert steps[0] < 0.1 * steps.max()
    assert steps[-1] < 0.1 * steps.max()


@pytest.mark.parametrize(("path", "speed"), [(((0.0,) * 5,), 1.0), (((0.0,) * 5, (1.0,) * 5), 0.0)])
def test_no_way_and_no_speed_are_refused(path: tuple[Joints, ...], speed: float) -> None:
    with pytest.raises(ValueError, match="a way has two postures"):
        timed(path, speed)


class Wall:
    """An arm whose first joint must not pass 0.5 rad while its second is low."""

    def solve(self, pose: TipPose, start: Joints) -> Joints | None:
        return start

    def touches(self, joints: Joints, jaw_rad: float, thing: MeasuredThing | None) -> tuple[str, ...]:
        return ("wall",) if abs(joints[0] - 0.5) < 0.2 and joints[1] < 1.0 else ()

    def margin(self, joints: Joints) -> float:
        return 1.0


def test_a_way_goes_round_what_is_in_it_or_there_is_none() -> None:
    begin, end, above = (0.0, 0.0), (1.0, 0.0), (0.5, 4.0)
    assert way_between(Wall(), begin, (0.2, 0.0), 0.0, None, ()) == (begin, (0.2, 0.0))
    assert way_between(Wall(), begin, end, 0.0, None, ()) is None
    assert way_between(Wall(), begin, end, 0.0, None, ((0.5, 0.0), above)) == (begin, above, end)


@pytest.mark.parametrize("angle", [-0.3, 0.0, 0.5])
def test_a_tilted_hand_points_so_much_more_steeply_and_keeps_its_axes_square(angle: float) -> None:
    pitch, bearing = 0.6, 0.4
    approach = np.array((math.cos(pitch) * math.cos(bearing), math.cos(pitch) * math.sin(bearing), -math.sin(pitch)))
    tip = TipPose(np.zeros(3), approach, np.array((math.sin(bearing), -math.cos(bearing), 0.0)))
    tilted = tip.tilted(angle)
    assert tilted.pitch_rad == pytest.approx(pitch + angle)
    assert float(tilted.approach @ tilted.opens) == pytest.approx(0.0, abs=1e-12)
    assert tip.towards(tilted, 0.5).pitch_rad == pytest.approx(pitch + angle / 2, abs=1e-6)
