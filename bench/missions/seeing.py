"""What a detector, a colour word and the votes would say, made from ground truth with errors of known size.

Not the network. A thing is detected the more surely the taller it is in the picture and the less of it is hidden (the
figures follow what the project's own small detector reaches: nearly always within 1.2 m, hardly past 2.5 m).
"""

import math

import numpy as np

from bench.missions.place import InPicture
from bench.world.faults import Errors
from contracts.colours import Colour
from contracts.vision import Detection, Target, Verdict, Vote
from sim.world.robot import RGB_CAMERA

SIZE_PX = RGB_CAMERA.width_px
CLIP_THRESHOLD = 0.40


def detection_chance(seen: InPicture) -> float:
    """0 to 1."""
    height_px = seen.bbox_xyxy[3] - seen.bbox_xyxy[1]
    size = 1.0 / (1.0 + math.exp(-(height_px - 15.0) / 2.5))
    return size * min(1.0, max(0.0, (seen.visible - 0.15) / 0.35))


def detect(seen: InPicture, rng: np.random.Generator, errors: Errors) -> Detection | None:
    chance = detection_chance(seen) * (1.0 - errors.missed)
    if rng.random() > chance:
        return None
    jitter = rng.normal(0.0, 0.8, 4)
    x0, y0, x1, y1 = (float(min(max(a + b, 0.0), SIZE_PX)) for a, b in zip(seen.bbox_xyxy, jitter, strict=True))
    if x1 - x0 < 1.0 or y1 - y0 < 1.0:
        return None
    confidence = float(np.clip(0.35 + 0.55 * chance + rng.normal(0.0, 0.06), 0.3, 0.97))
    return Detection(
        label=seen.thing.kind, confidence=confidence, bbox_xyxy=(x0, y0, x1, y1), colour=_colour(seen, rng, errors)
    )


def _colour(seen: InPicture, rng: np.random.Generator, errors: Errors) -> Colour | None:
    if not seen.thing.colour or errors.dark or rng.random() < errors.unknown_colour:
        return None
    if rng.random() < errors.wrong_colour:
        return Colour(str(rng.choice([c for c in ("red", "green", "blue", "yellow") if c != seen.thing.colour])))
    return Colour(seen.thing.colour)


def false_box(label: str, rng: np.random.Generator) -> Detection:
    width, height = rng.uniform(14, 60, 2).tolist()
    x, y = rng.uniform(0, SIZE_PX - width), rng.uniform(60, SIZE_PX - height)
    return Detection(
        label=label, confidence=float(rng.uniform(0.32, 0.8)), bbox_xyxy=(x, y, x + width, y + height), colour=None
    )


def right_thing(seen: InPicture | None, target: Target) -> bool:
    return seen is not None and target.may_be(seen.thing.kind, seen.thing.colour or None)


def votes(
    seen: InPicture | None, boxed: bool, target: Target, rng: np.random.Generator, errors: Errors
) -> tuple[Vote, ...]:
    """Detector, CLIP and (where there is one) the vision-language model on what stands in the box."""
    right = right_thing(seen, target)
    kind = seen is not None and seen.thing.kind == target.label
    detector = (boxed and (kind or errors.false_boxes > 0.0)) or errors.liar == "detector"
    middle = 0.58 if right else 0.22 if kind else 0.12
    if errors.dark:
        middle = min(middle, 0.33)
    score = float(np.clip(rng.normal(middle, errors.clip_sigma), 0.0, 1.0))
    if errors.liar == "clip":
        score = 0.62
    answers = [
        Vote(voter="detector", verdict=_word(detector), score=0.7 if detector else None, threshold=0.3),
        Vote(voter="clip", verdict=_word(score >= CLIP_THRESHOLD), score=score, threshold=CLIP_THRESHOLD),
    ]
    if errors.vlm:
        says = right and not errors.dark and rng.random() > 0.05
        answers.append(Vote(voter="vlm", verdict=_word(says or errors.liar == "vlm")))
    else:
        answers.append(Vote(voter="vlm", verdict=Verdict.ABSTAIN, reason="none is there"))
    return tuple(answers)


def _word(yes: bool) -> Verdict:
    return Verdict.YES if yes else Verdict.NO
