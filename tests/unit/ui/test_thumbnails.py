"""Pictures of remembered things."""

import io

import numpy as np
from PIL import Image

from contracts.geometry import Pose2D
from contracts.vision import Detection, Detections
from support.ui_world import camera_jpeg, thing
from ui.overlay import CameraFrame
from ui.thumbnails import SIDE_PX, Thumbnails, cropped

STAMP_S = 500.0
HERE = Pose2D(x=0.0, y=0.0, yaw=0.0)


def seen(*labels: str, stamp_s: float = STAMP_S) -> Detections:
    return Detections(
        stamp_s=stamp_s,
        image_width_px=480,
        image_height_px=502,
        pose=HERE,
        detections=tuple(Detection(label=one, confidence=0.9, bbox_xyxy=(205, 140, 265, 254)) for one in labels),
    )


def frame(yaw: float = 0.0) -> CameraFrame:
    return CameraFrame(STAMP_S + 0.1, camera_jpeg(0), 480, 502, Pose2D(x=0.0, y=0.0, yaw=yaw))


def test_a_thing_gets_the_crop_it_was_last_seen_on_and_keeps_it() -> None:
    kept = Thumbnails(10)
    kept.put(seen("bottle", "cup"), frame())
    kept.match([thing(1, last_seen_s=STAMP_S), thing(2, "blue cup", last_seen_s=STAMP_S - 60.0)])
    assert (kept.version(1), kept.version(2)) == (STAMP_S, None)
    kept.match([thing(1, last_seen_s=STAMP_S + 9.0)])
    found = kept.get(1)
    assert found is not None
    image = Image.open(io.BytesIO(cropped(found)))
    assert image.size == (SIDE_PX, SIDE_PX)
    middle = np.asarray(image.convert("RGB"))[20:70, 40:56].mean(axis=(0, 1))
    assert middle[0] > 2 * middle[1]
    kept.match([])
    assert kept.get(1) is None


def test_of_two_alike_and_of_another_view_no_picture_is_kept() -> None:
    kept = Thumbnails(10)
    kept.put(seen("bottle", "bottle"), frame())
    kept.put(seen("cup"), frame(yaw=0.5))
    kept.match([thing(1, last_seen_s=STAMP_S), thing(2, "blue cup", last_seen_s=STAMP_S)])
    assert (kept.get(1), kept.get(2)) == (None, None)


def test_only_the_newest_are_kept() -> None:
    kept = Thumbnails(2)
    for number in range(5):
        kept.put(seen("bottle", stamp_s=STAMP_S + number / 10), frame())
    kept.match([thing(number, last_seen_s=STAMP_S + number / 10) for number in range(5)])
    assert [number for number in range(5) if kept.get(number) is not None] == [3, 4]


def test_a_box_at_the_edge_of_the_picture_is_cropped_inside_it() -> None:
    kept = Thumbnails(2)
    edge = Detection(label="bottle", confidence=0.9, bbox_xyxy=(470, 0, 480, 502))
    kept.put(seen().model_copy(update={"detections": (edge,)}), frame())
    kept.match([thing(1, last_seen_s=STAMP_S)])
    found = kept.get(1)
    assert found is not None
    assert Image.open(io.BytesIO(cropped(found))).size == (SIDE_PX, SIDE_PX)
