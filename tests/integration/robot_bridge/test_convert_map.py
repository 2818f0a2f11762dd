"""nav_msgs/OccupancyGrid becomes the bridge's map, or is refused with the reason."""

import math
from typing import Any

import pytest
from nav_msgs.msg import OccupancyGrid

from robot_bridge.adapters.ros import convert


def sent(width: int = 3, height: int = 2, *, data: Any = None, xyzw: Any = (0.0, 0.0, 0.0, 1.0), z: float = 0.0) -> Any:
    message = OccupancyGrid()
    message.info.width, message.info.height, message.info.resolution = width, height, 0.05
    message.info.origin.position.x, message.info.origin.position.y = -1.0, 2.0
    message.info.origin.position.z = z
    q = message.info.origin.orientation
    q.x, q.y, q.z, q.w = xyzw
    message.data = [0] * (width * height) if data is None else data
    return message


@pytest.mark.parametrize("yaw", [0.0, 0.1, 1.56, -2.4])
def test_a_turned_origin_is_read_as_it_is(yaw: float) -> None:
    grid = convert.grid(sent(xyzw=(0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))))
    assert (grid.origin.x, grid.origin.y, grid.origin.yaw) == pytest.approx((-1.0, 2.0, yaw))


def test_cells_are_rows_from_the_origin_and_what_means_nothing_is_unknown() -> None:
    grid = convert.grid(sent(data=[0, 100, -1, 127, -7, 50]))
    assert grid.cells.tolist() == [[0, 100, -1], [-1, -1, 50]]
    assert grid.resolution_m == 0.05


def test_the_height_of_the_floor_does_not_matter() -> None:
    assert convert.grid(sent(z=0.3)).origin.x == -1.0


@pytest.mark.parametrize(
    ("xyzw", "why"),
    [
        ((0.0, 0.0, 0.0, 0.0), "quaternion is zero"),
        ((math.nan, 0.0, 0.0, 1.0), "quaternion is zero or no number"),
        ((0.0, math.inf, 0.0, 1.0), "quaternion is zero or no number"),
        ((1.0, 0.0, 0.0, 0.0), "upside down"),
        ((math.sin(0.1), 0.0, 0.0, math.cos(0.1)), "tilted"),
        ((0.0, math.sin(math.pi / 4), 0.0, math.cos(math.pi / 4)), "tilted"),
    ],
)
def test_an_origin_that_is_no_pose_on_the_floor_is_refused_in_words(xyzw: Any, why: str) -> None:
    with pytest.raises(ValueError, match=why):
        convert.grid(sent(xyzw=xyzw))


@pytest.mark.parametrize("xyzw", [(0.0, 0.0, 0.0, 2.0), (0.001, 0.0, 0.0, 1.0)])
def test_an_origin_that_is_level_but_for_rounding_is_read(xyzw: Any) -> None:
    assert convert.grid(sent(xyzw=xyzw)).origin.yaw == pytest.approx(0.0)


def test_cells_that_are_not_width_times_height_are_refused() -> None:
    with pytest.raises(ValueError, match="5 cells, not 3 x 2"):
        convert.grid(sent(data=[0] * 5))
