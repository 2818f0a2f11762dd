"""How probably one picture shows the detector a thing that is in sight, by distance, kind and place in the picture.

Measured on 1219 labels in 480 pictures of 60 homes that the detector was not trained on, printed by
`python -m sim.training.detectability HELD_OUT_DATA`. A kind's rings are drawn towards those of all kinds, the more the
fewer labels it has. Light was not measured: those pictures do not tell it.
"""

import numpy as np
from numpy.typing import NDArray

RINGS_M = (0.0, 0.7, 1.2, 1.6, 2.0, 2.5, 3.0, 3.5, 4.5, 9.0)
ALL = (0.883, 0.9, 0.904, 0.836, 0.837, 0.919, 0.846, 0.771, 0.616)
OFF_AXIS = (0.0, 0.25, 0.5, 0.75, 0.9, 1.0)
"""Of half the picture's width."""
ACROSS = (0.843, 0.871, 0.886, 0.802, 0.577)
KINDS: dict[str, tuple[float, ...]] = {
    "bench": (0.88, 0.64, 0.9, 0.89, 0.78, 0.79, 0.88, 0.83, 0.71),
    "backpack": (0.94, 0.97, 0.96, 0.9, 0.89, 0.95, 0.79, 0.72, 0.64),
    "umbrella": (0.88, 0.95, 0.94, 0.88, 0.88, 0.92, 0.85, 0.83, 0.71),
    "handbag": (0.93, 0.91, 0.83, 0.67, 0.78, 0.95, 0.88, 0.77, 0.52),
    "suitcase": (0.92, 0.83, 0.86, 0.72, 0.82, 0.95, 0.92, 0.86, 0.69),
    "sports ball": (0.89, 0.95, 0.95, 0.88, 0.89, 0.95, 0.87, 0.7, 0.47),
    "bottle": (0.87, 0.94, 0.96, 0.9, 0.84, 0.95, 0.88, 0.76, 0.62),
    "wine glass": (0.92, 0.96, 0.93, 0.83, 0.75, 0.92, 0.87, 0.62, 0.62),
    "cup": (0.95, 0.83, 0.97, 0.81, 0.75, 0.87, 0.64, 0.7, 0.53),
    "bowl": (0.88, 0.96, 0.96, 0.92, 0.89, 0.94, 0.85, 0.7, 0.62),
    "banana": (0.95, 0.87, 0.94, 0.89, 0.86, 0.95, 0.9, 0.77, 0.62),
    "apple": (0.95, 0.95, 0.94, 0.91, 0.92, 0.93, 0.87, 0.7, 0.62),
    "orange": (0.9, 0.95, 0.95, 0.86, 0.89, 0.92, 0.85, 0.77, 0.62),
    "chair": (0.66, 0.89, 0.84, 0.83, 0.89, 0.97, 0.54, 0.79, 0.64),
    "couch": (0.88, 0.68, 0.8, 0.81, 0.86, 0.87, 0.85, 0.84, 0.78),
    "potted plant": (0.95, 0.9, 0.94, 0.9, 0.82, 0.96, 0.91, 0.74, 0.78),
    "bed": (0.88, 0.91, 0.7, 0.77, 0.79, 0.94, 0.87, 0.74, 0.67),
    "dining table": (0.88, 0.89, 0.86, 0.75, 0.9, 0.96, 0.88, 0.8, 0.65),
    "toilet": (0.88, 0.82, 0.95, 0.89, 0.89, 0.81, 0.9, 0.83, 0.67),
    "tv": (0.88, 0.82, 0.92, 0.89, 0.88, 0.95, 0.85, 0.86, 0.64),
    "laptop": (0.83, 0.87, 0.93, 0.86, 0.88, 0.79, 0.76, 0.77, 0.46),
    "keyboard": (0.95, 0.95, 0.94, 0.88, 0.82, 0.93, 0.87, 0.8, 0.62),
    "microwave": (0.88, 0.9, 0.9, 0.84, 0.75, 0.95, 0.88, 0.83, 0.51),
    "oven": (0.88, 0.74, 0.79, 0.75, 0.78, 0.96, 0.9, 0.74, 0.64),
    "toaster": (0.88, 0.9, 0.9, 0.84, 0.89, 0.95, 0.85, 0.7, 0.57),
    "sink": (0.9, 0.84, 0.94, 0.88, 0.91, 0.95, 0.87, 0.8, 0.63),
    "refrigerator": (0.88, 0.95, 0.94, 0.89, 0.64, 0.84, 0.9, 0.83, 0.65),
    "book": (0.61, 0.89, 0.96, 0.75, 0.81, 0.79, 0.9, 0.7, 0.31),
    "clock": (0.79, 0.95, 0.91, 0.84, 0.77, 0.93, 0.85, 0.86, 0.46),
    "vase": (0.95, 0.97, 0.89, 0.78, 0.92, 0.95, 0.91, 0.83, 0.67),
    "teddy bear": (0.83, 0.96, 0.94, 0.91, 0.8, 0.95, 0.88, 0.6, 0.57),
}  # fmt: skip
IN_SIGHT = 0.9
"""Assumed, not measured: the map is flat, and a thing in line of sight on it may still hide behind a lower one."""


def by_distance(label: str, distance_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Between the middles of the rings a straight line; beyond the last 0. Never above 1."""
    middles = (np.array(RINGS_M[:-1]) + np.array(RINGS_M[1:])) / 2
    seen = np.interp(distance_m, middles, np.array(KINDS.get(label, ALL)))
    return IN_SIGHT * np.where(distance_m <= RINGS_M[-1], seen, 0.0)


def across(off_axis: NDArray[np.float64]) -> NDArray[np.float64]:
    """Relative to the picture's middle; `off_axis` is 0 there and 1 at its edge; 0 outside the picture."""
    ring = np.clip(np.searchsorted(OFF_AXIS, off_axis, side="right") - 1, 0, len(ACROSS) - 1)
    return np.where(off_axis <= 1.0, np.minimum(1.0, np.array(ACROSS)[ring] / ACROSS[0]), 0.0)
