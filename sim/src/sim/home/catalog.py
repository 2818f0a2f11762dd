"""The kinds of things and furniture a home may hold, their usual size, their colours and where they may stand."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Final

Rgb = tuple[float, float, float]

COLOURS: Final[dict[str, Rgb]] = {
    "red": (0.84, 0.05, 0.07),
    "green": (0.07, 0.56, 0.17),
    "blue": (0.07, 0.24, 0.86),
    "yellow": (0.98, 0.86, 0.06),
    "white": (0.95, 0.95, 0.94),
    "black": (0.07, 0.07, 0.08),
    "purple": (0.48, 0.12, 0.70),
    "orange": (1.00, 0.44, 0.02),
}
"""The eight colours a person may name, chosen to stay apart under the lights of the simulated homes."""

EXTRA_COLOURS: Final[dict[str, Rgb]] = {"brown": (0.50, 0.30, 0.15), "grey": (0.50, 0.51, 0.53)}
"""Colours that only some kinds come in: a brown teddy bear, a wooden chair, a grey couch."""

ALL_COLOURS: Final[dict[str, Rgb]] = COLOURS | EXTRA_COLOURS
_EIGHT = tuple(COLOURS)


class Place(StrEnum):
    """Where a thing may be put."""

    FLOOR = "floor"  # on the floor beside a wall or a piece of furniture
    LOW = "low"  # on a surface between 0.2 m and 0.5 m
    BOARD = "board"  # on a board of an open shelf, seen from its front only
    HIGH = "high"  # on a kitchen counter or a cabinet, 0.6 m to 0.95 m
    WALL = "wall"  # hung on a wall


@dataclass(frozen=True)
class Kind:
    """One kind: its COCO id (None where COCO has no word), width x depth x height in m, and its colours."""

    label: str
    coco_id: int | None
    size_m: tuple[float, float, float]
    colours: tuple[str, ...] = ()
    places: tuple[Place, ...] = ()
    findable: bool = False
    variants: int = 1
    per_home: tuple[int, int] = (0, 0)


_F, _L, _B, _H, _W = Place.FLOOR, Place.LOW, Place.BOARD, Place.HIGH, Place.WALL

THINGS: Final[dict[str, Kind]] = {
    kind.label: kind
    for kind in (
        Kind("bottle", 39, (0.095, 0.095, 0.30), _EIGHT, (_F, _L, _B), True, 3, (1, 3)),
        Kind("cup", 41, (0.160, 0.100, 0.115), _EIGHT, (_F, _L, _B), True, 2, (1, 3)),
        Kind("bowl", 45, (0.240, 0.240, 0.105), _EIGHT, (_F, _L, _B), True, 2, (1, 2)),
        Kind("vase", 75, (0.180, 0.180, 0.33), _EIGHT, (_F, _L), True, 3, (1, 2)),
        Kind("book", 73, (0.200, 0.150, 0.26), _EIGHT, (_F, _L, _B), True, 3, (1, 3)),
        Kind("teddy bear", 77, (0.340, 0.320, 0.45), (*_EIGHT, "brown", "brown"), (_F, _L), True, 1, (1, 2)),
        Kind("sports ball", 32, (0.220, 0.220, 0.22), _EIGHT, (_F, _B), True, 3, (1, 2)),
        Kind("backpack", 24, (0.320, 0.250, 0.45), _EIGHT, (_F,), True, 1, (1, 2)),
        Kind("handbag", 26, (0.330, 0.150, 0.34), _EIGHT, (_F, _L), True, 2, (0, 2)),
        Kind("suitcase", 28, (0.420, 0.260, 0.70), _EIGHT, (_F,), True, 1, (0, 2)),
        Kind("umbrella", 25, (0.800, 0.800, 0.62), _EIGHT, (_F,), True, 1, (0, 1)),
        Kind("potted plant", 58, (0.460, 0.460, 0.62), (), (_F, _L), True, 3, (1, 2)),
        Kind("clock", 74, (0.320, 0.050, 0.32), (), (_L, _W, _W), True, 1, (1, 1)),
        Kind("laptop", 63, (0.360, 0.320, 0.25), (), (_F, _L), True, 2, (0, 1)),
        Kind("keyboard", 66, (0.460, 0.170, 0.09), (), (_F,), True, 1, (0, 1)),
        Kind("wine glass", 40, (0.095, 0.095, 0.24), (), (_F, _L, _B), True, 1, (0, 2)),
        Kind("apple", 47, (0.110, 0.110, 0.11), ("red", "green"), (_F, _L, _B), True, 1, (0, 2)),
        Kind("orange", 49, (0.105, 0.105, 0.10), (), (_F, _L, _B), True, 1, (0, 1)),
        Kind("banana", 46, (0.240, 0.120, 0.11), (), (_F, _L, _B), True, 1, (0, 1)),
        Kind("microwave", 68, (0.500, 0.360, 0.29), (), (_H,), False, 2, (0, 1)),
        Kind("toaster", 70, (0.300, 0.180, 0.20), (), (_H, _L), False, 2, (0, 1)),
        Kind("tv", 62, (0.980, 0.200, 0.66), (), (), False, 1, (0, 0)),
    )
}
"""Kinds of things; `findable` ones are small enough to be named in a mission and always stand approachably."""

FURNITURE: Final[dict[str, Kind]] = {
    kind.label: kind
    for kind in (
        Kind("chair", 56, (0.44, 0.46, 0.88), (*_EIGHT, "brown", "brown", "brown", "brown"), variants=3),
        Kind("couch", 57, (1.80, 0.86, 0.76), (*_EIGHT, "grey", "grey", "brown", "brown"), variants=2),
        Kind("bed", 59, (1.40, 2.02, 0.92), variants=1),
        Kind("dining table", 60, (1.30, 0.80, 0.74), variants=2),
        Kind("bench", 13, (1.10, 0.40, 0.80), variants=1),
        Kind("toilet", 61, (0.40, 0.68, 0.78)),
        Kind("sink", 71, (0.58, 0.46, 0.88)),
        Kind("oven", 69, (0.60, 0.62, 0.90), variants=2),
        Kind("refrigerator", 72, (0.66, 0.66, 1.70), variants=3),
        Kind("coffee table", None, (0.90, 0.50, 0.28), variants=2),
        Kind("cabinet", None, (0.90, 0.42, 0.40), variants=2),
        Kind("counter", None, (1.40, 0.58, 0.88), variants=2),
        Kind("shelf", None, (0.90, 0.32, 0.86), variants=2),
    )
}
"""Kinds of furniture; their front is along their own +y, their back to a wall."""

KINDS: Final[dict[str, Kind]] = THINGS | FURNITURE
"""Every kind by its label; a `Wanted` may name any of them."""

COCO_IDS: Final[dict[str, int]] = {kind.label: kind.coco_id for kind in KINDS.values() if kind.coco_id is not None}
"""COCO id (0..79) of every kind that COCO names: 31 of them."""


def rgb_of(colour: str) -> Rgb:
    """Linear 0..1 red, green, blue of a named colour; KeyError for a name that is not in `ALL_COLOURS`."""
    return ALL_COLOURS[colour]
