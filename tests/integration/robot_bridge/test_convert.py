"""ROS messages become the bridge's own values, or are refused."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from irobot_create_msgs.msg import HazardDetection, HazardDetectionVector
from sensor_msgs.msg import LaserScan

from contracts.motion import Hazard
from robot_bridge.adapters.ros import convert
from robot_bridge.sensing.sensor_readings import Scan
from robot_bridge.sensing.transforms import matrix
from support.ros_messages import round_room

BEAMS = 360
TO_THE_LEFT = np.array([[0.0, -1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
"""The laser's x axis is base_link's y axis, as on a TurtleBot4."""


def scanned(range_at: Callable[[float], float]) -> Scan:
    """A scan whose range at each bearing in base_link (rad) is this, from a laser that looks to the left."""
    message = LaserScan(angle_min=-math.pi, angle_increment=math.tau / BEAMS, range_min=0.15, range_max=12.0)
    message.angle_max = math.pi
    bearings = -math.pi + math.tau / BEAMS * np.arange(BEAMS) + math.pi / 2
    message.ranges = [range_at(math.remainder(bearing, math.tau)) for bearing in bearings]
    return convert.scan(message, TO_THE_LEFT, 1.0)


def blind_deg(scan: Scan) -> int:
    """How much of the view is unknown."""
    return round(math.degrees(float(scan.blind[:, 1].sum())))


def post(bearing: float) -> float:
    """The standoffs of a TurtleBot 4 Standard, nearer than range_min; a room of 3 m behind them."""
    return 0.13 if min(abs(abs(bearing) - math.radians(deg)) for deg in (58.0, 112.0)) < 0.06 else 3.0


def test_narrow_posts_inside_the_footprint_are_the_robots_own_and_a_cover_is_not() -> None:
    assert blind_deg(scanned(post)) == 0
    assert blind_deg(scanned(lambda bearing: 0.13 if abs(bearing) < 0.3 else 3.0)) == pytest.approx(34, abs=2)


@pytest.mark.parametrize(
    ("mount", "side"),
    [((0.0, 0.0, 0.0, 1.0), 1), ((1.0, 0.0, 0.0, 0.0), -1), ((0.0, 1.0, 0.0, 0.0), 1)],
    ids=["upright", "upside down about x", "upside down about y"],
)
def test_what_is_covered_on_the_left_is_blind_on_the_left_however_the_laser_hangs(
    mount: tuple[float, float, float, float], side: int
) -> None:
    message = round_room(beams=BEAMS)
    message.ranges = [math.nan if abs(math.degrees(-math.pi + math.tau / BEAMS * k) - 90) < 30 else 3.0
                      for k in range(BEAMS)]  # fmt: skip
    ((begin, width),) = convert.scan(message, matrix((0.0, 0.0, 0.2), mount), 1.0).blind
    assert math.degrees(math.remainder(begin + width / 2, math.tau)) == pytest.approx(90.0 * side, abs=1.0)


def test_what_stands_ahead_of_the_robot_is_ahead_whatever_way_the_laser_looks() -> None:
    found = scanned(lambda bearing: 1.0 if abs(bearing) < 0.01 else math.inf)
    assert np.allclose(found.points_m, [[1.0, 0.0]], atol=0.02)


def test_nothing_in_reach_is_knowledge_and_no_number_is_not() -> None:
    far = scanned(lambda _: math.inf)
    assert (far.points_m.shape, blind_deg(far), far.open_rad.size) == ((0, 2), 0, BEAMS)
    blind = scanned(lambda _: math.nan)
    assert (blind.points_m.shape, blind_deg(blind), blind.open_rad.size) == ((0, 2), 360, 0)


def test_a_laser_that_is_blind_on_one_side_says_which() -> None:
    covered = scanned(lambda bearing: math.nan if abs(bearing) < math.pi / 2 else 2.0)
    begin, width = covered.blind[0]
    assert math.degrees(width) == pytest.approx(180.0, abs=2.0)
    assert math.remainder(begin + width / 2, math.tau) == pytest.approx(0.0, abs=0.02)


@pytest.mark.parametrize("near", [0.0, 0.1, -1.0, -math.inf])
def test_a_range_that_cannot_be_is_no_knowledge(near: float) -> None:
    assert blind_deg(scanned(lambda _: near)) == 360


@pytest.mark.parametrize(
    "broken",
    [
        LaserScan(range_max=12.0, angle_increment=0.1),
        LaserScan(range_max=12.0, angle_increment=math.nan, ranges=[1.0] * 10),
        LaserScan(range_max=12.0, angle_min=math.inf, ranges=[1.0] * 10),
        LaserScan(range_max=12.0, ranges=[1.0] * 30_000),
    ],
    ids=["empty", "angles that are no numbers", "an infinite angle", "too many beams"],
)
def test_a_scan_that_makes_no_sense_is_refused(broken: LaserScan) -> None:
    with pytest.raises(ValueError, match=r".+"):
        convert.scan(broken, TO_THE_LEFT, 1.0)


def test_hazards_have_names_and_unknown_ones_are_left_out() -> None:
    kinds = (HazardDetection.BUMP, HazardDetection.WHEEL_DROP, 77)
    message = HazardDetectionVector(detections=[HazardDetection(type=kind) for kind in kinds])
    assert convert.hazards(message) == {Hazard.BUMP, Hazard.WHEEL_DROP}
