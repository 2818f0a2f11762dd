"""The map of what is remembered, drawn."""

import math
import re

import numpy as np
import pytest

from contracts.geometry import Pose2D
from geometry.grids import OccupancyGrid
from memory.picture import map_svg


@pytest.mark.parametrize("yaw", [0.0, 0.1, math.pi / 2, -2.0])
def test_a_wall_is_drawn_where_it_is_however_the_map_is_turned(yaw: float) -> None:
    cells = np.zeros((10, 20), np.int8)
    cells[3, 5:9] = 100
    ground = OccupancyGrid(cells, 0.5, Pose2D(x=1.0, y=-2.0, yaw=yaw))
    svg = map_svg([], [], ground, 0.0)
    a, b, c, d, e, f = (float(one) for one in re.findall(r"matrix\(([^)]*)\)", svg)[0].split())
    (x, y, width) = (
        float(re.findall(rf' {name}="([0-9.]+)"', svg.partition("wall")[2])[0]) for name in ("x", "y", "width")
    )
    corners_x, corners_y = ground.points(np.array([0, 20, 20, 0]), np.array([0, 0, 10, 10]))
    x_min, y_max = corners_x.min() - 0.5, corners_y.max() + 0.5
    at_x, at_y = ground.points(np.array([5.0, 9.0]), np.array([3.0, 3.0]))
    for column, map_x, map_y in ((x, at_x[0], at_y[0]), (x + width, at_x[1], at_y[1])):
        assert a * column + c * y + e == pytest.approx((map_x - x_min) * 60.0, abs=0.1)
        assert b * column + d * y + f == pytest.approx((y_max - map_y) * 60.0, abs=0.1)
