"""Camera poses: on free floor, at the robot's own height."""

import numpy as np
import pytest

from sim.home import Home
from sim.training.views import Viewpoints
from sim.world.robot import CAMERA_Z_M


@pytest.mark.parametrize("seed", [100000, 900000])
def test_every_view_stands_in_a_room_and_clear_of_furniture(seed: int) -> None:
    home = Home.generate(seed)
    viewpoints = Viewpoints(home, np.random.default_rng(0))
    views = [view for view in (viewpoints.draw() for _ in range(50)) if view is not None]
    assert len(views) == 50
    assert all(any(room.contains(view.x_m, view.y_m) for room in home.rooms) for view in views)
    nearest_m = [
        np.hypot(view.x_m - piece.x_m, view.y_m - piece.y_m) - min(piece.size_m[:2]) / 2
        for view in views
        for piece in home.furniture
    ]
    assert min(nearest_m) > 0.19
    assert all(CAMERA_Z_M - 0.02 < view.z_m < CAMERA_Z_M + 0.02 for view in views)
