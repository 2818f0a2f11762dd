"""The names other people's models give COCO's classes. Pure."""

import re

from contracts.coco import COCO_LABELS

OLDER_NAMES = {
    "aeroplane": "airplane",
    "doughnut": "donut",
    "hairdryer": "hair drier",
    "mobilephone": "cell phone",
    "motorbike": "motorcycle",
    "sofa": "couch",
    "television": "tv",
    "tvmonitor": "tv",
}
"""As Pascal VOC, Darknet and their children call them, written without blanks."""


def label_of(name: str) -> str | None:
    """COCO's label: 'Sofa', 'wine_glass', 'pottedplant' and 'cell-phone' name one; a number names none."""
    return _LABELS.get(_squeezed(name))


def _squeezed(name: str) -> str:
    return re.sub(r"[\s_-]+", "", name).lower()


_LABELS = {_squeezed(label): label for label in COCO_LABELS} | OLDER_NAMES
