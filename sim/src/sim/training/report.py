"""The README beside the weights: how they were made and how good they are, written from scores.json."""

from typing import Any

_RECIPE = """# Weights for the simulated home

Two small models that let the simulated robot see. They know the renders of `sim.home` and nothing else: a real robot
uses a COCO detector and CLIP ViT-B/32 instead.

| file | what | trained on |
|---|---|---|
| `{detector_file}` | YOLOv8n, 80 COCO labels, fp16; loaded by `ultralytics.YOLO` | boxes from segmentation |
| `{clip_file}` and `.json` | open_clip, own words; loaded by `inference.perception.small_clip` | crops and phrases |
| `scores.json` | everything below, by machine | |

Both were trained from nothing, on two shared processor cores without a GPU, by the scripts in `sim/src/sim/training`.
The detector's network definition and file format are those of ultralytics (AGPL-3.0).

## Scores

Measured on {homes} homes that no training saw ({images} images of 250 x 250 pixels, {boxes} boxes), at confidence
{confidence:.2f}.

- Detector (input scaled to {imgsz}): **mAP50 {map50:.3f}** over {kinds} kinds, precision {precision:.2f}, recall
  {recall:.2f}; within 2 m, for bottle, cup, vase, bowl, teddy bear and sports ball together, recall **{near:.2f}**.
- Small CLIP: the right colour within the kind for **{colour:.3f}** of the coloured things the detector found
  ({colour_near:.3f} within 2 m); threshold **{threshold:.3f}**, at which it accepts {accepted:.2f} of true phrases,
  {other_colour:.3f} of phrases with another colour and {other_kind:.3f} of those with another kind.

{aims}

{table}

Recall by distance, the six searched kinds: {rings}.

{real}## How they were made

{history}

```
python -m sim.training.dataset DATA --first 100000 --homes 700 --images 10       # homes to train on
python -m sim.training.dataset HELD_OUT --first 900000 --homes 60 --images 8     # homes to measure on
python -m sim.training.detector DATA detector.pt --steps 20000 --threads 2       # or --init, --minutes
python -m sim.training.clip DATA clip.safetensors --held-out HELD_OUT --steps 3000
python -m sim.training.evaluate HELD_OUT --weights sim/weights [--coco PATH]     # writes this page and scores.json
```

Seeds keep the sets apart: training homes start at 100000, held-out ones at 900000; homes shown in demos have small
numbers. A box is labelled from {short_side} pixels on its shorter side, where at least a quarter of it is visible.
"""


def table(scores: dict[str, Any]) -> str:
    """The scores kind by kind, as Markdown."""
    real = scores.get("coco_yolov8n", {}).get("kinds", {})
    lines = [
        "| kind | boxes | AP50 | recall | recall within 2 m | AP50 of a COCO YOLOv8n |",
        "|---|---:|---:|---:|---:|---:|",
    ]
    for kind, row in sorted(scores["detector"]["kinds"].items(), key=lambda item: -item[1]["ap50"]):
        near = "" if row["recall_within_2_m"] is None else f"{row['recall_within_2_m']:.2f}"
        photo = f"{real[kind]['ap50']:.2f}" if kind in real else ""
        lines.append(f"| {kind} | {row['boxes']} | {row['ap50']:.2f} | {row['recall']:.2f} | {near} | {photo} |")
    return "\n".join(lines)


def readme(scores: dict[str, Any], history: str, short_side_px: int) -> str:
    """The whole page; `history` is a paragraph that says how this particular pair of files came to be."""
    detector, clip, held_out = scores["detector"], scores["clip"], scores["held_out"]
    colour, measured = clip["colour_within_kind_on_detected_boxes"], clip["on_true_boxes"]
    missed = "".join(f"- {sentence}\n" for sentence in scores["aims_missed"])
    real = ""
    if "coco_yolov8n" in scores:
        photo = scores["coco_yolov8n"]
        real = (
            f"A YOLOv8n trained on COCO photographs (not part of this repository) reaches mAP50 {photo['map50']:.3f}"
            " on the same images: how much these renders look like the things themselves.\n\n"
        )
    rings = ", ".join(
        f"{ring} {share:.2f} of {n}" for ring, (share, n) in detector["recall_by_distance_searched"].items()
    )
    return _RECIPE.format(
        detector_file=detector["file"],
        clip_file=clip["file"],
        homes=held_out["homes"],
        images=held_out["images"],
        boxes=held_out["boxes"],
        confidence=detector["confidence"],
        imgsz=detector["imgsz"],
        map50=detector["map50"],
        kinds=len(detector["kinds"]),
        precision=detector["precision"],
        recall=detector["recall"],
        near=detector["recall_within_2_m_searched"],
        colour=colour["accuracy"],
        colour_near=colour["accuracy_within_2_m"],
        threshold=clip["threshold"],
        accepted=measured["accepted_right"],
        other_colour=measured["accepted_other_colour"],
        other_kind=measured["accepted_other_kind"],
        aims=f"Aims not reached:\n\n{missed}" if missed else "All aims were reached.",
        table=table(scores),
        rings=rings,
        real=real,
        history=history.strip(),
        short_side=short_side_px,
    )
