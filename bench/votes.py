"""How often the votes confirm the wrong thing and refuse the right one, on homes no model was trained on.

    python -m bench.votes [--coco PATH] [--homes 60] [--images 8] [--quick]

Renders homes of two sets of seeds: on one (800000..) the small CLIP's threshold and margins are chosen, on the other
(900000..) the votes are judged with the numbers that stand beside the weights. Each coloured thing within the range in
which the robot votes is asked about once as what it is, once in each other colour its kind comes in, and once as
another kind. Every question goes through the service's own `Validator`. Writes out/bench/votes.json and votes.png.
"""

import argparse
import asyncio
import json
import sys
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bench.results import save
from bench.seeing.plots import save_confusion
from bench.seeing.statistics import share
from bench.seeing.voting import Answer, Asker, Question, questions
from contracts.vision import Verdict
from inference.adapters.image_text import Overrides, SmallClipModel
from inference.adapters.yolo import YoloDetector, read_card
from inference.colours import colour_prompts
from inference.perception.models import Loaded
from inference.perception.small_clip import load
from sim.training.crops import read_crops
from sim.training.dataset import render_homes
from sim.training.records import Frame, read_frames
from sim.training.thresholds import calibrate

OUT = Path("out/bench")
CALIBRATION_SEED, HELD_OUT_SEED = 800_000, 900_000
CONFIRMED_WRONG_AIM, REFUSED_RIGHT_AIM = 0.01, 0.05
NAMED_WRONG_AIM = 0.005
IMAGES_QUICK = 3


@dataclass(frozen=True)
class Judged:
    """A question, the answer, and whether that was right."""

    question: Question
    answer: Answer

    @property
    def good(self) -> bool:
        """The right thing confirmed, or nothing confirmed where there was nothing to confirm."""
        return self.answer.confirmed_right if self.question.right else not self.answer.confirmed_wrong


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--weights", type=Path, default=Path("sim/weights"))
    parser.add_argument("--coco", type=Path, help="a detector trained on COCO photographs, judged beside ours")
    parser.add_argument("--homes", type=int, default=60, help="of each set (default 60)")
    parser.add_argument("--images", type=int, default=8, help="pictures of each home (default 8)")
    parser.add_argument("--range-m", type=float, default=2.5, help="votes are cast up to here (default 2.5)")
    parser.add_argument("--data", type=Path, default=OUT / "homes", help="where the pictures are kept")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--quick", action="store_true", help="a few homes, to see that it runs")
    arguments = parser.parse_args()
    homes, images = (2, IMAGES_QUICK) if arguments.quick else (arguments.homes, arguments.images)
    folder = arguments.data / ("quick" if arguments.quick else "full")
    for name, first in (("calibration", CALIBRATION_SEED), ("held_out", HELD_OUT_SEED)):
        render_homes(folder / name, range(first, first + homes), images, arguments.jobs)
    report = asyncio.run(judge(arguments, folder))
    save(OUT / "votes.json", report)
    save_confusion(OUT / "votes.png", {name: one["confusion"] for name, one in report["held_out"].items()})
    tell(report)


async def judge(arguments: argparse.Namespace, folder: Path) -> dict[str, Any]:
    sim = YoloDetector(
        arguments.weights / "detector.pt",
        threshold=read_card(arguments.weights / "detector.pt").threshold,
        imgsz=read_card(arguments.weights / "detector.pt").imgsz,
    )
    detectors = {"sim": sim}
    if arguments.coco is not None:
        detectors["coco"] = YoloDetector(arguments.coco, threshold=0.30, imgsz=640, name="yolov8n (COCO)")
    clip_file = arguments.weights / "clip.safetensors"
    open_clip = SmallClipModel(clip_file, overrides=Overrides(threshold=-1.0, vote_margin=-2.0))
    calibration = list(read_frames(folder / "calibration"))
    raw = await ask(Loaded(sim, open_clip), folder / "calibration", calibration, arguments.range_m)
    as_it_is = SmallClipModel(clip_file)
    cut = calibrated_cut(raw, clip_file, folder / "calibration")
    names = colour_leads(sim, as_it_is, folder / "calibration", calibration)
    held_out = list(read_frames(folder / "held_out"))
    report: dict[str, Any] = {
        "command": " ".join(["python -m bench.votes", *sys.argv[1:]]),
        "aims": {"confirmed_wrong": CONFIRMED_WRONG_AIM, "refused_right": REFUSED_RIGHT_AIM},
        "range_m": arguments.range_m,
        "calibration": {
            "seeds": seeds_of(calibration),
            "images": len(calibration),
            "clip_threshold_and_vote_margin": cut,
            "colour_margin": best_margin(names),
        },
        "in_use": {
            "detector_threshold": sim.threshold,
            "clip_threshold": as_it_is.threshold,
            "vote_margin": as_it_is.vote_margin,
            "colour_margin": as_it_is.colour_margin,
        },
        "held_out": {},
    }
    for name, detector in detectors.items():
        judged = await ask(Loaded(detector, as_it_is), folder / "held_out", held_out, arguments.range_m)
        report["held_out"][name] = {
            "detector": detector.name,
            "clip": as_it_is.name,
            "seeds": seeds_of(held_out),
            "images": len(held_out),
            **summary(judged),
            "at_calibrated_cut": dict(
                zip(
                    ("right_refused_of_spotted", "wrong_confirmed_of_spotted"),
                    at_cut(judged, cut["threshold"], cut["vote_margin"]),
                    strict=True,
                )
            ),
            "colour_names": named(colour_leads(detector, as_it_is, folder / "held_out", held_out), as_it_is),
        }
    return report


def seeds_of(frames: Sequence[Frame]) -> str:
    return f"{frames[0].seed}..{frames[-1].seed}"


async def ask(loaded: Loaded, data: Path, frames: Sequence[Frame], range_m: float) -> list[Judged]:
    """Every question about every frame."""
    judged: list[Judged] = []
    rng = np.random.default_rng(0)
    async with Asker(loaded) as asker:
        for frame in frames:
            for question in questions(frame, range_m, rng):
                judged.append(Judged(question, await asker.ask(data / frame.image, frame, question)))
    return judged


def summary(judged: Sequence[Judged]) -> dict[str, Any]:
    """What the requirement asks for, and where it goes wrong."""
    right = [one for one in judged if one.question.kind_of == "right"]
    colour = [one for one in judged if one.question.kind_of == "other colour"]
    kind = [one for one in judged if one.question.kind_of == "other kind"]
    spotted = [one for one in right if one.answer.spotted]
    wrong = [one for one in (*colour, *kind) if one.answer.confirmed_wrong]
    confirmed = sum(one.answer.confirmed_right for one in right)
    return {
        "right_refused_of_spotted": share(sum(not one.good for one in spotted), len(spotted)),
        "right_refused_of_all": share(sum(not one.good for one in right), len(right)),
        "other_colour_confirmed": share(sum(not one.good for one in colour), len(colour)),
        "other_kind_confirmed": share(sum(not one.good for one in kind), len(kind)),
        "precision": round(confirmed / max(1, confirmed + len(wrong)), 4),
        "recall_of_spotted": round(sum(one.good for one in spotted) / max(1, len(spotted)), 4),
        "recall_of_all": round(sum(one.good for one in right) / max(1, len(right)), 4),
        "clip_ms_p50": round(float(np.median([one.answer.clip_ms for one in judged])), 2),
        "by_kind": by_kind(judged),
        "confusion": confusion([*right, *colour]),
        "refused": [described(one) for one in spotted if not one.good][:40],
        "confirmed": [described(one) for one in wrong][:40],
    }


def by_kind(judged: Iterable[Judged]) -> dict[str, dict[str, Any]]:
    counts: dict[str, dict[str, int]] = defaultdict(lambda: defaultdict(int))
    for one in judged:
        row, what = counts[one.question.box.kind], one.question.kind_of
        row[what] += 1
        row[f"{what}, bad"] += not one.good
        if what == "right" and one.answer.spotted:
            row["spotted"] += 1
            row["spotted, bad"] += not one.good
    return {kind: dict(sorted(row.items())) for kind, row in sorted(counts.items())}


def confusion(judged: Iterable[Judged]) -> dict[str, dict[str, list[int]]]:
    """True colour -> colour asked for -> [confirmed, asked], of what the detector spotted."""
    table: dict[str, dict[str, list[int]]] = defaultdict(lambda: defaultdict(lambda: [0, 0]))
    for one in judged:
        if one.answer.spotted:
            cell = table[one.question.box.colour][one.question.colour]
            cell[0] += one.answer.confirmed_right or one.answer.confirmed_wrong
            cell[1] += 1
    return {true: dict(sorted(row.items())) for true, row in sorted(table.items())}


def described(one: Judged) -> str:
    box = one.question.box
    seen = f"{box.colour} {box.kind} at {box.distance_m} m, {box.short_side_px} px"
    return f"{seen}, asked for '{one.question.description}': {one.answer.reason}"


def calibrated_cut(judged: Sequence[Judged], clip_file: Path, data: Path) -> dict[str, Any]:
    """The threshold that best parts true phrases from false ones, and the smallest lead that keeps the wrong out."""
    model = load(clip_file)
    crops = read_crops(data, model.config.image_size_px, 0, 0)
    threshold = calibrate(model.embed_squares(crops.squares), crops.meanings, model.embed_text).threshold
    rows = [
        (round(float(margin), 2), *at_cut(judged, threshold, float(margin))) for margin in np.arange(0.0, 0.31, 0.01)
    ]
    margin, refused, confirmed = next((row for row in rows if row[2] <= CONFIRMED_WRONG_AIM), rows[-1])
    return {
        "threshold": round(threshold, 2),
        "vote_margin": margin,
        "right_refused": refused,
        "wrong_confirmed": confirmed,
        "crops": len(crops.meanings),
    }


def at_cut(judged: Sequence[Judged], threshold: float, margin: float) -> tuple[float, float]:
    """Shares of right ones refused and of wrong ones confirmed, of what was spotted, were the line drawn there."""
    passed: dict[bool, list[bool]] = {True: [False], False: [False]}
    for one in judged:
        score, lead = one.answer.clip_score, one.answer.clip_lead
        if one.answer.spotted and score is not None and lead is not None:
            yes = one.answer.detector is Verdict.YES and score >= threshold and lead > 0 and lead >= margin
            passed[one.question.right].append(yes)
    right, wrong = passed[True][1:], passed[False][1:]
    return (
        round(1 - sum(right) / len(right), 4) if right else 0.0,
        round(sum(wrong) / len(wrong), 4) if wrong else 0.0,
    )


def colour_leads(detector: YoloDetector, clip: SmallClipModel, data: Path, frames: Sequence[Frame]) -> list[tuple]:
    """(lead of the best colour over the next, whether it is the true one) of each coloured thing that was spotted."""
    from bench.seeing.voting import hit, load_rgb

    leads: list[tuple[float, bool]] = []
    for frame in frames:
        image = load_rgb(data / frame.image)
        found = detector.detect(image)
        for box in frame.boxes:
            seen = hit(found, box)
            if seen is None or box.colour not in clip.colours:
                continue
            said = clip.embed_text(colour_prompts(clip.template, box.kind, clip.colours))
            scores = (clip.embed_image([clip.crop(image, seen.bbox_xyxy)]) @ said.T)[0]
            best, second = np.argsort(scores)[::-1][:2]
            leads.append((float(scores[best] - scores[second]), clip.colours[best] == box.colour))
    return leads


def best_margin(leads: Sequence[tuple[float, bool]]) -> dict[str, Any]:
    """The smallest margin at which at most 0.5 % of the colours named are wrong."""
    rows = [(round(float(margin), 2), *shares(leads, float(margin))) for margin in np.arange(0.0, 0.41, 0.01)]
    fit = next((row for row in rows if row[2] <= NAMED_WRONG_AIM), rows[-1])
    return {"margin": fit[0], "named": fit[1], "wrong_of_named": fit[2], "things": len(leads)}


def named(leads: Sequence[tuple[float, bool]], clip: SmallClipModel) -> dict[str, float]:
    told, wrong = shares(leads, clip.colour_margin)
    return {"things": len(leads), "named": told, "wrong_of_named": wrong}


def shares(leads: Sequence[tuple[float, bool]], margin: float) -> tuple[float, float]:
    said = [right for lead, right in leads if lead >= margin]
    wrong = sum(not right for right in said) / len(said) if said else 0.0
    return round(len(said) / max(1, len(leads)), 4), round(wrong, 4)


def tell(report: dict[str, Any]) -> None:
    print(json.dumps({key: report[key] for key in ("calibration", "in_use")}, indent=1))  # noqa: T201
    for name, one in report["held_out"].items():
        print(f"\n{name}: {one['detector']} and {one['clip']}, seeds {one['seeds']}, {one['images']} images")  # noqa: T201
        for key, value in one.items():
            if key not in {"by_kind", "confusion", "refused", "confirmed"}:
                print(f"  {key}: {value}")  # noqa: T201


if __name__ == "__main__":
    main()
