"""What each vote is worth, measured on held-out pictures: log p(score | the target) / p(score | something else).

    python -m bench.calibration HELD_OUT_DATA [--weights sim/weights] [--out out/bench]

HELD_OUT_DATA is a data set of `sim.training.dataset` from homes no model was trained on. Every box the detector reports
is a candidate, as in a mission; the service's own `Validator` is asked for its own phrase, every other colour of its
kind, and (where the detector took one kind for another) the colour it looks most. Of the wrong, other colours and other
kinds weigh half each. A logistic curve a voter and size of box is fitted on half of the homes and checked on
the other half, both ways round; the table that is written is fitted on all. Writes calibration.json beside the weights,
calibration.json (the check) and calibration.png (reliability) under --out, and prints the check.
"""

import argparse
import asyncio
import hashlib
import json
import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from bench.results import pyplot, save
from bench.seeing.voting import HIT_IOU, OneFrame, Remembering, load_rgb
from contracts.vision import Detection, Target, ValidateRequest, Vote
from geometry.boxes import iou
from inference.adapters.image_text import SmallClipModel
from inference.adapters.yolo import YoloDetector, read_card
from inference.perception.models import Loaded, Models
from inference.perception.worker import Worker
from inference.validation.calibration import FILE, Calibration, Curve, VoterCurves, side_share, statistic
from inference.validation.validation import Validator
from sim.home.catalog import THINGS
from sim.training.records import Box, Frame, read_frames

SIDES_PX = (0, 14, 28, 56)
"""From where a size begins: the shorter side of a box, of a picture 250 px wide."""
IMAGE_PX = 250
RIDGE = 0.02
LOG_ODDS_CAP = 4.5
Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Asked:
    """One vote of one voter on one candidate, and the truth."""

    voter: str
    value: float | None
    """None: the detector saw none of the kind."""
    right: bool
    kind_of: str
    yes: bool
    raw: float
    side: float
    seed: int
    thing: str
    label: str
    colour: str
    image: str
    distance_m: float
    light: float


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("--weights", type=Path, default=Path("sim/weights"))
    parser.add_argument("--out", type=Path, default=Path("out/bench"))
    arguments = parser.parse_args()
    detector_file, clip_file = arguments.weights / "detector.pt", arguments.weights / "clip.safetensors"
    card = read_card(detector_file)
    detector = YoloDetector(detector_file, threshold=card.threshold, imgsz=card.imgsz)
    clip = SmallClipModel(clip_file)
    frames = list(read_frames(arguments.data))
    asked = asyncio.run(ask_all(Loaded(detector, clip), arguments.data, frames))
    table = Calibration(
        detector=curves(asked, "detector", detector.name, detector_file),
        clip_colour=curves(asked, "clip_colour", clip.name, clip_file),
        clip_kind=curves(asked, "clip_kind", clip.name, clip_file),
    )
    (arguments.weights / FILE).write_text(json.dumps(table.model_dump(mode="json"), indent=1) + "\n")
    checked = [pair for voter in VOTERS for pair in cross_validated(asked, voter)]
    report = {
        "pictures": len(frames),
        "homes": len({frame.seed for frame in frames}),
        "voters": {voter: checks([(a, p) for a, p in checked if a.voter == voter]) for voter in VOTERS},
        "correlation_of_two_views_of_one_thing": {v: correlation(asked, table, v) for v in VOTERS},
    }
    save(arguments.out / "calibration.json", report)
    plot(arguments.out / "calibration.png", checked)
    tell(report, table)


VOTERS = ("detector", "clip_colour", "clip_kind")


async def ask_all(loaded: Loaded, data: Path, frames: Sequence[Frame]) -> list[Asked]:
    """Every candidate of every picture, and what each voter says of it."""
    assert loaded.detector is not None
    detector, camera, worker = Remembering(loaded.detector), OneFrame(), Worker(waiting_max=4)
    models = Models(load=lambda: Loaded(detector=detector, clip=loaded.clip), worker=worker, colour_crops_max=0)
    await models.open()
    validator = Validator(camera, models, None, frame_wait_s=1.0, vlm_deadline_s=1.0)
    asked: list[Asked] = []
    called: list[tuple[Box, Frame, str]] = []
    for frame in frames:
        camera.show(data / frame.image)
        image = load_rgb(data / frame.image)
        found = detector.detect(image)
        for guess in found:
            box = meant(guess, frame)
            if box is not None and box.kind != guess.label:
                called.append((box, frame, guess.label))
            votes: list[tuple[Target, tuple[Vote, ...]]] = []
            for colour in ("", *(THINGS[guess.label].colours if guess.label in THINGS else ())):
                target = Target(label=guess.label, description=f"{colour} {guess.label}".strip())
                told = await validator.validate(ValidateRequest(target=target, bbox_xyxy=guess.bbox_xyxy))
                votes.append((target, told.votes))
            asked += judged(votes, guess, box, frame, light(image, guess))
        for box in frame.boxes:
            missed = not any(g.label == box.kind and iou(g.bbox_xyxy, bounds(box)) >= HIT_IOU for g in found)
            asked.append(unseen(box, frame, box.kind, right=True, missed=missed))
    by_image = {frame.image: frame for frame in frames}
    for box, frame, label in called:  # whether what was taken for another kind is taken for it again in another picture
        for other in (one for one in by_image.values() if one.seed == frame.seed and one.image != frame.image):
            for again in (one for one in other.boxes if one.thing == box.thing):
                camera.show(data / other.image)
                found = detector.detect(load_rgb(data / other.image))
                missed = not any(g.label == label and iou(g.bbox_xyxy, bounds(again)) >= 0.3 for g in found)
                asked.append(unseen(again, other, label, right=False, missed=missed))
    worker.close()
    return asked


def judged(
    votes: Sequence[tuple[Target, tuple[Vote, ...]]], guess: Detection, box: Box | None, frame: Frame, lit: float
) -> Iterable[Asked]:
    """One question of the colour it has and one of each other; of another kind only the colour that it looks most."""
    right_kind = box is not None and box.kind == guess.label
    rows: list[Asked] = []
    for target, (first, second, _) in votes:
        colour = target.colour or ""
        right = right_kind and colour in {"", box.colour if box is not None else ""}
        kind_of = "right" if right else "other colour" if right_kind else "other kind"
        for voter, vote in (("detector", first), ("clip_colour" if colour else "clip_kind", second)):
            value = statistic(vote)
            if value is None:
                continue
            rows.append(
                Asked(
                    voter, value, right, kind_of, vote.verdict == "yes", raw_of(vote),
                    side_share(guess.bbox_xyxy, IMAGE_PX),
                    frame.seed, box.thing if box is not None else "", guess.label, colour, frame.image,
                    box.distance_m if box is not None else math.nan, lit,
                )
            )  # fmt: skip
    coloured = [row for row in rows if row.colour]
    if not right_kind and coloured:
        most = max(
            (row for row in coloured if row.voter == "clip_colour"), key=lambda row: row.value or 0.0, default=None
        )
        rows = [row for row in rows if not row.colour or (most is not None and row.colour == most.colour)]
    if not coloured:  # a kind of one colour: nobody would name it
        return rows
    return [row for row in rows if row.colour or row.voter == "clip_kind"]


def raw_of(vote: Vote) -> float:
    return min(1.0, max(0.0, vote.score or 0.0))


def unseen(box: Box, frame: Frame, label: str, *, right: bool, missed: bool) -> Asked:
    side = side_share(bounds(box), IMAGE_PX)
    return Asked(
        "unseen", None if missed else 1.0, right, "right" if right else "other kind", not missed, 0.0, side,
        frame.seed, box.thing, label, box.colour, frame.image, box.distance_m, 0.0,
    )  # fmt: skip


def bounds(box: Box) -> tuple[float, float, float, float]:
    x_min, y_min, x_max, y_max = map(float, box.bbox_xyxy)
    return x_min, y_min, x_max, y_max


def meant(guess: Detection, frame: Frame) -> Box | None:
    """The labelled thing under a guess: of its own kind first."""
    over = [box for box in frame.boxes if iou(bounds(box), guess.bbox_xyxy) >= HIT_IOU]
    return max(over, key=lambda b: (b.kind == guess.label, iou(bounds(b), guess.bbox_xyxy)), default=None)


def light(image: npt.NDArray[np.uint8], guess: Detection) -> float:
    """Mean grey of the picture inside the box, 0 to 1."""
    left, top, right, bottom = (int(side) for side in guess.bbox_xyxy)
    inside = image[top : max(top + 1, bottom), left : max(left + 1, right)]
    return float(cv2.cvtColor(np.ascontiguousarray(inside), cv2.COLOR_RGB2GRAY).mean()) / 255


def weights(asked: Sequence[Asked]) -> Floats:
    """Right and wrong weigh the same; of the wrong, other colours and other kinds half each."""
    count: dict[str, int] = defaultdict(int)
    for one in asked:
        count[one.kind_of] += 1
    wrong = sum(kind != "right" for kind in count)
    return np.array([(1.0 if a.kind_of == "right" else 1.0 / wrong) / count[a.kind_of] / 2 for a in asked])


def curves(asked: Sequence[Asked], voter: str, model: str, file: Path) -> VoterCurves:
    mine = [one for one in asked if one.voter == voter]
    looks = [one for one in asked if one.voter == "unseen"] if voter == "detector" else []
    by_size: list[Curve] = []
    for i in range(len(SIDES_PX)):
        by_size.append(fitted(in_bin(mine, i), SIDES_PX[i] / IMAGE_PX, in_bin(looks, i), looks))
    return VoterCurves(model=model, sha256=hashlib.sha256(file.read_bytes()).hexdigest(), by_size=tuple(by_size))


def in_bin(asked: Sequence[Asked], i: int) -> list[Asked]:
    ends = (*(side / IMAGE_PX for side in SIDES_PX), math.inf)
    return [one for one in asked if ends[i] <= one.side < ends[i + 1]]


def fitted(asked: Sequence[Asked], share_min: float, here: Sequence[Asked], looks: Sequence[Asked]) -> Curve:
    """A logistic curve by Newton's method; no log-odds beyond what so many pictures can show."""
    x = np.array([one.value for one in asked], float)
    y = np.array([one.right for one in asked], float)
    w = weights(asked)
    scale = float(x.std()) or 1.0
    design = np.stack([np.ones_like(x), x / scale], axis=1)
    beta = np.zeros(2)
    for _ in range(50):
        p = 1 / (1 + np.exp(-design @ beta))
        gradient = design.T @ (w * (y - p)) - RIDGE * np.array([0.0, 1.0]) * beta / len(x) ** 0.5
        hessian = (design * (w * p * (1 - p))[:, None]).T @ design + np.diag([1e-9, RIDGE / len(x) ** 0.5])
        beta += np.linalg.solve(hessian, gradient)
    slope = max(0.0, float(beta[1]) / scale)
    right, wrong = int(y.sum()), int((1 - y).sum())
    reach = (x.min(), x.max())
    curve = Curve(
        side_share_min=share_min,
        intercept=round(float(beta[0]), 3),
        slope=round(slope, 3),
        lowest=round(-min(LOG_ODDS_CAP, math.log(right + 1)), 3),
        highest=round(min(LOG_ODDS_CAP, math.log(wrong + 1)), 3),
    )
    ends = [curve.log_odds(float(end)) for end in reach]
    return curve.model_copy(
        update={
            "lowest": round(min(0.0, ends[0]), 3),
            "highest": round(max(0.0, ends[1]), 3),
            "unseen": unseen_log_odds(here, looks) if looks else None,
        }
    )


def unseen_log_odds(here: Sequence[Asked], looks: Sequence[Asked]) -> float:
    """Of a picture in which the detector sees none of the kind: misses of the thing against those of a wrong one."""
    right = [one.value is None for one in here if one.right]
    wrong = [one.value is None for one in looks if not one.right]  # of every size: they are few
    missed = (sum(right) + 1) / (len(right) + 2)
    gone = (sum(wrong) + 1) / (len(wrong) + 2)
    return round(min(0.0, math.log(missed / (0.5 * missed + 0.5 * gone))), 3)


def cross_validated(asked: Sequence[Asked], voter: str) -> list[tuple[Asked, float]]:
    """Each vote with the probability that curves of the other half of the homes give it."""
    mine = [one for one in asked if one.voter == voter]
    pairs: list[tuple[Asked, float]] = []
    for half in (0, 1):
        taught = [one for one in mine if one.seed % 2 != half]
        for i in range(len(SIDES_PX)):
            curve = fitted(in_bin(taught, i), 0.0, (), ())
            tested = [one for one in in_bin(mine, i) if one.seed % 2 == half]
            pairs += [(one, probability(curve.log_odds(one.value or 0.0))) for one in tested]
    return pairs


def probability(log_odds: float) -> float:
    return 1.0 / (1.0 + math.exp(-log_odds))


def checks(pairs: Sequence[tuple[Asked, float]]) -> dict[str, Any]:
    slices: dict[str, Callable[[Asked], str]] = {
        "size": lambda a: cut(a.side * IMAGE_PX, SIDES_PX[1:], "px"),
        "distance": lambda a: "no thing" if math.isnan(a.distance_m) else cut(a.distance_m, (0.8, 1.2, 1.8, 2.5), "m"),
        "light": lambda a: cut(a.light, (0.25, 0.45), "grey"),
        "kind": lambda a: a.label,
    }
    by: dict[str, Any] = {}
    for name, of in slices.items():
        groups: dict[str, list[tuple[Asked, float]]] = defaultdict(list)
        for pair in pairs:
            groups[of(pair[0])].append(pair)
        by[name] = {
            key: one_row(rows)
            for key, rows in sorted(groups.items())
            if min(sum(a.right is r for a, _ in rows) for r in (True, False)) >= 10
        }
    return {"all": one_row(pairs), "by": by}


def cut(value: float, edges: Sequence[float], unit: str) -> str:
    at = sum(value >= edge for edge in edges)
    ends = ("0", *(f"{edge:g}" for edge in edges), "")
    return f"{ends[at]}-{ends[at + 1]} {unit}"


def one_row(pairs: Sequence[tuple[Asked, float]]) -> dict[str, Any]:
    """Before: the verdict taken for certain, and the bare score taken for a probability; after: the curves."""
    asked = [a for a, _ in pairs]
    w = weights(asked)
    w = w / w.sum()
    y = np.array([a.right for a in asked], float)
    row: dict[str, Any] = {"n": len(asked), "right": int(y.sum())}
    for name, p in (
        ("verdict", np.array([float(a.yes) for a in asked])),
        ("score", np.array([a.raw for a in asked])),
        ("calibrated", np.array([p for _, p in pairs])),
    ):
        row[name] = {"brier": round(float((w * (p - y) ** 2).sum()), 4), "ece": round(ece(p, y, w), 4)}
    return row


def bins(p: Floats, y: Floats, w: Floats) -> list[tuple[float, float, float]]:
    """(mean probability, share that was right, weight) of ten equal steps of probability."""
    at = np.minimum((p * 10).astype(int), 9)
    rows: list[tuple[float, float, float]] = []
    for i in range(10):
        mass = float(w[at == i].sum())
        if mass > 0:
            rows.append((float((w * p)[at == i].sum()) / mass, float((w * y)[at == i].sum()) / mass, mass))
    return rows


def ece(p: Floats, y: Floats, w: Floats) -> float:
    return sum(mass * abs(mean - share) for mean, share, mass in bins(p, y, w))


def correlation(asked: Sequence[Asked], table: Calibration, voter: str) -> dict[str, Any]:
    """Of what is left of two votes on one thing from two places, once right and wrong have their own mean."""
    model = getattr(table, voter)
    mine = [a for a in asked if a.voter == voter and a.thing]
    worth = {id(a): model.at(a.side).log_odds(a.value) for a in mine}
    mean = {right: np.mean([worth[id(a)] for a in mine if a.right is right] or [0.0]) for right in (True, False)}
    same: dict[tuple[Any, ...], list[float]] = defaultdict(list)
    for a in mine:
        same[a.seed, a.thing, a.label, a.colour, a.right].append(worth[id(a)] - mean[a.right])
    pairs = [(x, y) for left in same.values() for i, x in enumerate(left) for y in left[:i]]
    spread = float(np.mean([x * x for left in same.values() for x in left])) or 1.0
    return {
        "pairs": len(pairs),
        "correlation": round(float(np.mean([x * y for x, y in pairs])) / spread, 3) if pairs else None,
    }


def plot(path: Path, checked: Sequence[tuple[Asked, float]]) -> None:
    plt = pyplot()
    figure, axes = plt.subplots(1, len(VOTERS), figsize=(5 * len(VOTERS), 4.6))
    for axis, voter in zip(axes, VOTERS, strict=True):
        axis.plot([0, 1], [0, 1], color="grey", linewidth=0.8)
        for i in range(len(SIDES_PX)):
            pairs = [(a, p) for a, p in checked if a.voter == voter and a in in_bin([a], i)]
            if len(pairs) < 30:
                continue
            w, y = weights([a for a, _ in pairs]), np.array([a.right for a, _ in pairs], float)
            rows = bins(np.array([p for _, p in pairs]), y, w)
            axis.plot(
                [m for m, _, _ in rows],
                [s for _, s, _ in rows],
                marker="o",
                label=f"from {SIDES_PX[i]} px, n={len(pairs)}",
            )
        axis.set_title(voter.replace("_", ", by "))
        axis.set_xlabel("probability after calibration (other half of the homes)")
        axis.set_ylabel("share that was the target")
        axis.legend(fontsize=7)
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)


def tell(report: dict[str, Any], table: Calibration) -> None:
    print(f"{report['pictures']} pictures of {report['homes']} homes; Brier / ECE, lower is better")  # noqa: T201
    head = ("voter", "of", "n", "verdict", "score", "calibrated")
    print(("{:<12} {:<24} {:>6} " + "{:>15} " * 3).format(*head))  # noqa: T201
    for voter, one in report["voters"].items():
        rows = [
            ("all", one["all"]),
            *((key, row) for by in ("size", "distance", "light") for key, row in one["by"][by].items()),
        ]
        for name, row in rows:
            numbers = [f"{row[k]['brier']:.3f} / {row[k]['ece']:.3f}" for k in ("verdict", "score", "calibrated")]
            print(("{:<12} {:<24} {:>6} " + "{:>15} " * 3).format(voter, name, row["n"], *numbers))  # noqa: T201
    print(report["correlation_of_two_views_of_one_thing"])  # noqa: T201
    for voter in VOTERS:
        for curve in getattr(table, voter).by_size:
            print(voter, curve.model_dump_json())  # noqa: T201


if __name__ == "__main__":
    main()
