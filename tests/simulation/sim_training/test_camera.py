"""Pictures of homes and their labels, really rendered."""

from pathlib import Path

import numpy as np
import pytest

from sim.home import Home
from sim.training.camera import SHORT_SIDE_MIN_PX, HomeCamera
from sim.training.dataset import Job, frames_file, render_home
from sim.training.records import IMAGE_SIZE_PX, LABEL_ID, read_frames
from sim.training.views import View, Viewpoints
from sim.world.robot import CAMERA_Z_M

SEED = 900_000


def looking_at(x_m: float, y_m: float, from_x_m: float, from_y_m: float) -> View:
    return View(from_x_m, from_y_m, CAMERA_Z_M, float(np.arctan2(y_m - from_y_m, x_m - from_x_m)), 0.0, 0.0, 54.0)


def test_every_box_lies_in_the_picture_and_is_large_enough_to_see() -> None:
    home = Home.generate(SEED)
    viewpoints = Viewpoints(home, np.random.default_rng(1))
    views = [view for view in (viewpoints.draw() for _ in range(6)) if view is not None]
    with HomeCamera(home) as camera:
        boxes = [box for view in views for box in camera.boxes(view)]
        picture = camera.picture()
    assert picture.shape == (IMAGE_SIZE_PX, IMAGE_SIZE_PX, 3)
    assert boxes
    assert all(min(box.bbox_xyxy) >= 0 and max(box.bbox_xyxy) <= IMAGE_SIZE_PX for box in boxes)
    assert all(box.short_side_px >= SHORT_SIDE_MIN_PX and box.kind in LABEL_ID for box in boxes)


def test_a_thing_straight_ahead_is_labelled_in_the_middle_with_its_distance() -> None:
    home = Home.generate(SEED)
    ball = next(thing for thing in home.things if thing.support == "floor")
    views = [
        looking_at(ball.x_m, ball.y_m, ball.x_m + np.cos(a), ball.y_m + np.sin(a)) for a in np.arange(0, 6.28, 0.5)
    ]
    with HomeCamera(home) as camera:
        seen = [box for view in views for box in camera.boxes(view) if box.thing == ball.id]
    assert seen
    assert all(box.distance_m == pytest.approx(1.0, abs=0.02) for box in seen)
    middles_px = [(box.bbox_xyxy[0] + box.bbox_xyxy[2]) / 2 for box in seen]
    assert np.median(middles_px) == pytest.approx(IMAGE_SIZE_PX / 2, abs=12)


def test_a_rendered_home_reads_back_as_it_was_written(tmp_path: Path) -> None:
    for folder in ("images", "labels", "frames"):
        (tmp_path / folder).mkdir()
    job = Job(tmp_path, SEED, 2)
    counts = render_home(job)
    frames = list(read_frames(tmp_path))
    assert frames_file(job).exists()
    assert sum(counts.values()) == sum(len(frame.boxes) for frame in frames)
    assert all((tmp_path / frame.image).exists() for frame in frames)
