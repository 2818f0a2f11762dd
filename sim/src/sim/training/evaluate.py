"""Scores the weights on homes they never saw, and writes down what was found.

    python -m sim.training.evaluate HELD_OUT_DATA --weights sim/weights [--coco PATH]

Writes scores.json and README.md into the folder of the weights and prints a table. `--coco` names a real COCO detector
(any path that `ultralytics.YOLO` loads); scoring it too says how much these renders look like the things themselves.
"""

import argparse
import json
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import torch

from contracts.coco import COCO_LABELS
from contracts.colours import Colour
from inference.perception import torchvision_cpu
from inference.perception.small_clip import SmallClip, crop, load
from sim.training.crops import SHORT_SIDE_MIN_PX, read_crops
from sim.training.phrases import Meaning
from sim.training.progress import say
from sim.training.records import Frame, read_frames
from sim.training.report import readme, table
from sim.training.scores import (
    Guess,
    Matches,
    Truth,
    average_precision,
    match,
    mean,
    precision,
    recall,
    recall_by_distance,
)
from sim.training.thresholds import calibrate

DETECTOR_FILE = "detector.pt"
CLIP_FILE = "clip.safetensors"
HISTORY_FILE = "history.md"
"""A paragraph, written by hand, on how the present weights came to be; goes into the README."""
SEARCHED = ("bottle", "cup", "vase", "bowl", "teddy bear", "sports ball")
NEAR_M = 2.0
MEAN_AP_AIM, RECALL_AIM, COLOUR_AIM = 0.75, 0.90, 0.95


@dataclass(frozen=True)
class Run:
    """What a detector said about every frame, and how long it took."""

    guesses: list[list[Guess]]
    image_ms: float


def detect(weights: Path, data: Path, frames: Sequence[Frame], imgsz: int) -> Run:
    """Every guess of a detector with a confidence of at least 0.01."""
    torchvision_cpu.install()
    from ultralytics import YOLO

    model = YOLO(weights, task="detect")
    guesses: list[list[Guess]] = []
    times_ms: list[float] = []
    for frame in frames:
        image = cv2.imread(str(data / frame.image))
        began_s = time.perf_counter()
        found = model.predict(image, imgsz=imgsz, conf=0.01, iou=0.6, max_det=100, verbose=False)[0].boxes
        times_ms.append(1000 * (time.perf_counter() - began_s))
        rows = zip(found.cls.tolist(), found.conf.tolist(), found.xyxy.tolist(), strict=True)
        guesses.append([Guess(COCO_LABELS[int(kind)], sure, tuple(bbox)) for kind, sure, bbox in rows])
    return Run(guesses, float(np.median(times_ms)))


def score_detector(matches: Matches, run: Run, confidence: float) -> dict[str, Any]:
    """The detector's part of scores.json."""
    kinds = sorted({truth.box.kind for truth in matches.truths})
    by_kind: dict[str, Any] = {}
    for kind in kinds:
        mine = [truth for truth in matches.truths if truth.box.kind == kind]
        near = [truth for truth in mine if truth.box.distance_m <= NEAR_M]
        by_kind[kind] = {
            "boxes": len(mine),
            "ap50": round(average_precision(matches, kind), 3),
            "recall": round(recall(mine, confidence), 3),
            "boxes_within_2_m": len(near),
            "recall_within_2_m": round(recall(near, confidence), 3) if near else None,
        }
    searched = [truth for truth in matches.truths if truth.box.kind in SEARCHED]
    near = [truth for truth in searched if truth.box.distance_m <= NEAR_M]
    return {
        "map50": round(mean([scores["ap50"] for scores in by_kind.values()]), 4),
        "confidence": confidence,
        "precision": round(precision(matches, confidence), 4),
        "recall": round(recall(matches.truths, confidence), 4),
        "recall_within_2_m_searched": round(recall(near, confidence), 4),
        "recall_by_distance_searched": recall_by_distance(searched, confidence),
        "image_ms": round(run.image_ms, 1),
        "kinds": by_kind,
    }


def score_colour(
    clip: SmallClip, data: Path, frames: Sequence[Frame], matches: Matches, confidence: float
) -> dict[str, Any]:
    """Colour among all there are on the detector's own boxes, where it found a coloured thing; all and within 2 m."""
    colours = [colour.value for colour in Colour]
    hits: list[tuple[Truth, bool]] = []
    truths = iter(matches.truths)
    for frame in frames:
        image = cv2.cvtColor(cv2.imread(str(data / frame.image)), cv2.COLOR_BGR2RGB)
        for truth in (next(truths) for _ in frame.boxes):
            if truth.guess is None or truth.confidence < confidence or not truth.box.colour:
                continue
            seen = clip.embed_image([crop(image, truth.guess.bbox_xyxy)])
            said = clip.embed_text([Meaning(truth.box.kind, colour).plain for colour in colours])
            hits.append((truth, colours[int((seen @ said.T).argmax())] == truth.box.colour))
    near = [right for truth, right in hits if truth.box.distance_m <= NEAR_M]
    searched = [right for truth, right in hits if truth.box.distance_m <= NEAR_M and truth.box.kind in SEARCHED]
    return {
        "boxes": len(hits),
        "accuracy": round(float(np.mean([right for _, right in hits])), 4),
        "accuracy_within_2_m": round(float(np.mean(near)), 4),
        "accuracy_within_2_m_searched": round(float(np.mean(searched)), 4),
        "wrong": [f"{t.box.colour} {t.box.kind} at {t.box.distance_m} m" for t, right in hits if not right][:40],
    }


def missed_aims(detector: dict[str, Any], colour: dict[str, Any]) -> list[str]:
    """A sentence for every aim that was not reached."""
    missed: list[str] = []
    if detector["map50"] < MEAN_AP_AIM:
        missed.append(f"mAP50 over all kinds is {detector['map50']:.3f}, the aim is {MEAN_AP_AIM}")
    for kind in SEARCHED:
        found = detector["kinds"].get(kind, {}).get("recall_within_2_m")
        if found is not None and found < RECALL_AIM:
            missed.append(f"recall of {kind} within 2 m is {found:.3f}, the aim is {RECALL_AIM}")
    if colour["accuracy"] < COLOUR_AIM:
        missed.append(f"the colour is right for {colour['accuracy']:.3f} of the boxes, the aim is {COLOUR_AIM}")
    return missed


def evaluate(arguments: argparse.Namespace) -> dict[str, Any]:
    """All scores, as written to scores.json."""
    torch.set_num_threads(arguments.threads)
    frames = list(read_frames(arguments.data))
    say("evaluate", f"{len(frames)} images of {len({frame.seed for frame in frames})} homes")
    run = detect(arguments.weights / DETECTOR_FILE, arguments.data, frames, arguments.imgsz)
    matches = match(frames, run.guesses)
    detector = score_detector(matches, run, arguments.confidence)
    say("evaluate", f"detector: mAP50 {detector['map50']}")
    clip = load(arguments.weights / CLIP_FILE)
    colour = score_colour(clip, arguments.data, frames, matches, arguments.confidence)
    crops = read_crops(arguments.data, clip.config.image_size_px, 0, 0)
    measured = calibrate(clip.embed_squares(crops.squares), crops.meanings, clip.embed_text)
    scores: dict[str, Any] = {
        "held_out": {
            "homes": len({frame.seed for frame in frames}),
            "images": len(frames),
            "boxes": sum(len(frame.boxes) for frame in frames),
        },
        "detector": {"file": DETECTOR_FILE, "imgsz": arguments.imgsz, **detector},
        "clip": {
            "file": CLIP_FILE,
            "threshold": clip.threshold,
            "colour_within_kind_on_detected_boxes": colour,
            "on_true_boxes": measured.as_dict(),
        },
        "aims_missed": missed_aims(detector, colour),
    }
    if arguments.coco is not None:
        real = detect(arguments.coco, arguments.data, frames, arguments.coco_imgsz)
        scores["coco_yolov8n"] = {
            "what": "a YOLOv8n trained on COCO photographs, on the same images; not part of this repository",
            "imgsz": arguments.coco_imgsz,
            **score_detector(match(frames, real.guesses), real, arguments.confidence),
        }
    return scores


def main() -> None:
    """Read the command line, score, write scores.json and README.md, print the table."""
    parser = argparse.ArgumentParser(prog="sim.training.evaluate", description=__doc__.splitlines()[0])
    parser.add_argument("data", type=Path, help="a data set of homes that were not trained on")
    parser.add_argument("--weights", type=Path, default=Path("sim/weights"), help="folder of both models")
    parser.add_argument("--imgsz", type=int, default=320, help="side the detector scales the image to (default 320)")
    parser.add_argument("--confidence", type=float, default=0.30, help="from which a box counts for recall")
    parser.add_argument("--coco", type=Path, help="a real COCO detector to score beside ours")
    parser.add_argument("--coco-imgsz", type=int, default=640)
    parser.add_argument("--threads", type=int, default=1)
    arguments = parser.parse_args()
    scores = evaluate(arguments)
    (arguments.weights / "scores.json").write_text(json.dumps(scores, indent=1) + "\n")
    history = (arguments.weights / HISTORY_FILE).read_text()
    (arguments.weights / "README.md").write_text(readme(scores, history, SHORT_SIDE_MIN_PX))
    missed = "; ".join(scores["aims_missed"]) or "none"
    say("evaluate", f"mAP50 {scores['detector']['map50']}, aims missed: {missed}\n{table(scores)}")


if __name__ == "__main__":
    main()
