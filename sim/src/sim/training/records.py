"""The data set on disk: images, YOLO labels, and one JSON line for each image."""

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

from contracts.coco import COCO_LABELS

IMAGE_SIZE_PX = 250
"""Width and height of the robot's own preview image."""

LABEL_ID: dict[str, int] = {label: i for i, label in enumerate(COCO_LABELS)}
"""A detector's class number for each label."""


@dataclass(frozen=True)
class Box:
    """One thing as it appears in one image."""

    thing: str
    kind: str
    colour: str
    bbox_xyxy: tuple[int, int, int, int]
    distance_m: float
    """Along the floor, from the camera to the middle of the thing."""
    pixels: int
    """How many pixels of it are visible."""

    @property
    def short_side_px(self) -> int:
        """The shorter side of the box."""
        return min(self.bbox_xyxy[2] - self.bbox_xyxy[0], self.bbox_xyxy[3] - self.bbox_xyxy[1])


@dataclass(frozen=True)
class Frame:
    """One image and everything labelled in it."""

    image: str
    """Path of the image, relative to the data set."""
    seed: int
    """The home it was taken in."""
    boxes: tuple[Box, ...]


def yolo_lines(boxes: tuple[Box, ...], size_px: int = IMAGE_SIZE_PX) -> str:
    """The boxes in YOLO's text form: class, centre and size as shares of the image."""
    lines: list[str] = []
    for box in boxes:
        x_min, y_min, x_max, y_max = (side / size_px for side in box.bbox_xyxy)
        shares = ((x_min + x_max) / 2, (y_min + y_max) / 2, x_max - x_min, y_max - y_min)
        lines.append(" ".join([str(LABEL_ID[box.kind]), *(f"{share:.5f}" for share in shares)]))
    return "".join(line + "\n" for line in lines)


def to_json(frame: Frame) -> str:
    """One line, readable by `from_json`."""
    return json.dumps(asdict(frame))


def from_json(line: str) -> Frame:
    """The frame that `to_json` wrote; raises KeyError or ValueError on anything else."""
    fields = json.loads(line)
    boxes = tuple(Box(**{**box, "bbox_xyxy": tuple(box["bbox_xyxy"])}) for box in fields["boxes"])
    return Frame(image=fields["image"], seed=fields["seed"], boxes=boxes)


def read_frames(data: Path) -> Iterator[Frame]:
    """Every frame of the data set, home by home in order of seed; one file a home, so that many processes can write."""
    for path in sorted((data / "frames").glob("*.jsonl")):
        for line in path.read_text().splitlines():
            yield from_json(line)
