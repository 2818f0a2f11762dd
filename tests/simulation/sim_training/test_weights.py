"""The committed weights, on a home they never saw: the robot's own eyes in one picture after another."""

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from contracts.colours import Colour
from geometry.boxes import iou
from inference.perception import small_clip, torchvision_cpu
from sim.home import Home
from sim.training.camera import HomeCamera
from sim.training.records import LABEL_ID, Box
from sim.training.views import View, Viewpoints

WEIGHTS = Path(__file__).parents[3] / "sim" / "weights"
UNSEEN_SEED = 900_100
SEARCHED = {"bottle", "cup", "vase", "bowl", "teddy bear", "sports ball"}


@dataclass(frozen=True)
class Look:
    """A picture and the searched things that stand whole and near in it."""

    picture: npt.NDArray[np.uint8]
    boxes: list[Box]


@pytest.fixture(scope="module")
def looks() -> list[Look]:
    """Pictures of an unseen home."""
    home = Home.generate(UNSEEN_SEED)
    viewpoints = Viewpoints(home, np.random.default_rng(3))
    views = [view for view in (viewpoints.draw() for _ in range(160)) if view is not None]
    with HomeCamera(home) as camera:
        return [Look(camera.picture().copy(), seen) for view in views if (seen := clear_boxes(camera, view))]


def clear_boxes(camera: HomeCamera, view: View) -> list[Box]:
    return [box for box in camera.boxes(view) if clearly_seen(box)]


def clearly_seen(box: Box) -> bool:
    inside = min(box.bbox_xyxy) > 2 and max(box.bbox_xyxy) < 248
    return box.kind in SEARCHED and inside and 0.6 <= box.distance_m <= 2.0


def test_the_detector_finds_most_of_what_stands_clearly_before_it(looks: list[Look]) -> None:
    torchvision_cpu.install()
    from ultralytics import YOLO

    model = YOLO(WEIGHTS / "detector.pt", task="detect")
    found: list[bool] = []
    for look in looks:
        result = model.predict(look.picture[..., ::-1], conf=0.3, verbose=False)[0].boxes
        rows = list(zip(result.cls.int().tolist(), result.xyxy.tolist(), strict=True))
        found += [
            any(kind == LABEL_ID[box.kind] and iou(bbox, box.bbox_xyxy) >= 0.5 for kind, bbox in rows)
            for box in look.boxes
        ]
    assert len(found) >= 8
    assert np.mean(found) >= 0.75


def test_the_small_clip_tells_the_colours_of_a_kind_apart(looks: list[Look]) -> None:
    clip = small_clip.load(WEIGHTS / "clip.safetensors")
    colours = [colour.value for colour in Colour]
    right: list[bool] = []
    for look in looks:
        for box in (box for box in look.boxes if box.colour):
            seen = clip.embed_image([small_clip.crop(look.picture, box.bbox_xyxy)])
            said = clip.embed_text([f"{colour} {box.kind}" for colour in colours])
            right.append(colours[int((seen @ said.T).argmax())] == box.colour)
    assert len(right) >= 8
    assert np.mean(right) >= 0.9


def test_the_scores_beside_the_weights_are_of_homes_kept_apart() -> None:
    scores = json.loads((WEIGHTS / "scores.json").read_text())
    assert scores["held_out"]["homes"] >= 60
    assert scores["clip"]["threshold"] == small_clip.read_config(WEIGHTS / "clip.safetensors").threshold


def test_the_weights_stay_small_enough_to_live_in_the_repository() -> None:
    sizes_bytes = [path.stat().st_size for path in WEIGHTS.iterdir()]
    assert max(sizes_bytes) < 8_000_000
    assert sum(sizes_bytes) < 15_000_000
