"""Prints how probably one picture shows the detector a thing, by distance, place in the picture and kind.

    python -m sim.training.detectability HELD_OUT_DATA --weights sim/weights

A label is a thing of which enough is visible, `distance_m` along the floor; found means a box on it of its kind with at
least `--confidence`. The tables in `coordinator.belief.detection_probability` are this output. Not in it: things hidden
altogether (line of sight is the map's business), and light, which these pictures do not tell.
"""

import argparse
import math
import sys
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path

from contracts.coco import COCO_LABELS
from sim.training.evaluate import DETECTOR_FILE, detect
from sim.training.records import IMAGE_SIZE_PX, read_frames
from sim.training.scores import Truth, match

RINGS_M = (0.0, 0.7, 1.2, 1.6, 2.0, 2.5, 3.0, 3.5, 4.5, 9.0)
OFF_AXIS = (0.0, 0.25, 0.5, 0.75, 0.9, 1.0)
"""Of half the picture's width, the box's middle."""
PRIOR_BOXES = 6.0
"""The ring's own share counts for a kind as much as so many labels of it."""


def main() -> None:
    parser = argparse.ArgumentParser(prog="sim.training.detectability", description=__doc__.splitlines()[0])
    parser.add_argument("data", type=Path)
    parser.add_argument("--weights", type=Path, default=Path("sim/weights"))
    parser.add_argument("--imgsz", type=int, default=320)
    parser.add_argument("--confidence", type=float, default=0.30)
    arguments = parser.parse_args()
    frames = list(read_frames(arguments.data))
    run = detect(arguments.weights / DETECTOR_FILE, arguments.data, frames, arguments.imgsz)
    truths = match(frames, run.guesses).truths
    sys.stdout.write("\n".join(tables(truths, arguments.confidence)) + "\n")


def tables(truths: Sequence[Truth], confidence: float) -> list[str]:
    """Lines: rings of distance, places in the picture, and each kind's rings drawn towards those of all."""
    rings = shares(truths, lambda one: one.box.distance_m, RINGS_M, confidence)
    lines = [f"{len(truths)} labels", "RINGS_M = " + repr(RINGS_M)]
    lines.append("ALL = " + repr(tuple(round(share, 3) for share, _ in rings)) + f"  # of {[n for _, n in rings]}")
    across = shares(truths, _off_axis, OFF_AXIS, confidence)
    lines.append("OFF_AXIS = " + repr(OFF_AXIS))
    lines.append("ACROSS = " + repr(tuple(round(p, 3) for p, _ in across)) + f"  # of {[n for _, n in across]}")
    for kind in sorted({truth.box.kind for truth in truths}, key=COCO_LABELS.index):
        mine = [truth for truth in truths if truth.box.kind == kind]
        own = shares(mine, lambda one: one.box.distance_m, RINGS_M, confidence)
        drawn = tuple(
            round((share * n + PRIOR_BOXES * of_all) / (n + PRIOR_BOXES), 2)
            for (share, n), (of_all, _) in zip(own, rings, strict=True)
        )
        lines.append(f'    "{kind}": {drawn},  # {len(mine)}')
    return lines


def shares(
    truths: Sequence[Truth], of: Callable[[Truth], float], edges: Sequence[float], confidence: float
) -> list[tuple[float, int]]:
    """For each interval the share found, and of how many; 0 of none."""
    rows: list[tuple[float, int]] = []
    for low, high in pairwise(edges):
        inside = [truth for truth in truths if low <= of(truth) < high or (high == edges[-1] and of(truth) == high)]
        rows.append((sum(truth.confidence >= confidence for truth in inside) / max(1, len(inside)), len(inside)))
    return rows


def _off_axis(truth: Truth) -> float:
    middle_px = (truth.box.bbox_xyxy[0] + truth.box.bbox_xyxy[2]) / 2
    return min(1.0, math.fabs(middle_px - IMAGE_SIZE_PX / 2) / (IMAGE_SIZE_PX / 2))


if __name__ == "__main__":
    main()
