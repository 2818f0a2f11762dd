"""Renders simulated homes into a labelled data set, seen from the robot's own camera.

    python -m sim.training.dataset DATA --first 100000 --homes 1000 --images 8 --jobs 2

Writes DATA/images/*.jpg (250x250), DATA/labels/*.txt (YOLO, numbered as COCO) and DATA/frames/SEED.jsonl (each box with
kind, colour, distance and visible pixels). A home that is already there is left alone, so the command can be repeated
and enlarged. Seeds keep the sets apart: homes to train on start at 100000, held-out ones at 900000, and what a demo
shows has a small number.
"""

import argparse
import multiprocessing
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt

from sim.home import Home
from sim.training.camera import HomeCamera, kinds_in
from sim.training.progress import say
from sim.training.records import IMAGE_SIZE_PX, Box, Frame, to_json, yolo_lines
from sim.training.views import Viewpoints

EMPTY_KEPT = 0.2
"""Share of views without anything in them that are kept, as examples of nothing."""
FILLING_MAX = 0.6
REPORT_S = 30.0


@dataclass(frozen=True)
class Job:
    """One home to render."""

    data: Path
    seed: int
    images: int


def render_home(job: Job) -> Counter[str]:
    """Take the pictures of one home; returns how many boxes of each kind they hold."""
    rng = np.random.default_rng([job.seed, 77])
    home = Home.generate(job.seed)
    viewpoints = Viewpoints(home, rng)
    frames: list[Frame] = []
    with HomeCamera(home) as camera:
        for _ in range(4 * job.images):
            view = viewpoints.draw()
            if view is None or len(frames) == job.images:
                break
            boxes = camera.boxes(view)
            if not worth_keeping(boxes, rng):
                continue
            name = f"{job.seed:06d}_{len(frames):02d}"
            write_picture(job.data / "images" / f"{name}.jpg", disturbed(camera.picture(), rng), rng)
            (job.data / "labels" / f"{name}.txt").write_text(yolo_lines(boxes))
            frames.append(Frame(f"images/{name}.jpg", job.seed, boxes))
    partial = frames_file(job).with_suffix(".partial")
    partial.write_text("".join(to_json(frame) + "\n" for frame in frames))
    partial.replace(frames_file(job))
    return Counter(box.kind for frame in frames for box in frame.boxes)


def worth_keeping(boxes: tuple[Box, ...], rng: np.random.Generator) -> bool:
    """Not a nose against a cupboard, and only now and then a view of nothing."""
    if not boxes:
        return bool(rng.random() < EMPTY_KEPT)
    return max(box.pixels for box in boxes) < FILLING_MAX * IMAGE_SIZE_PX**2


def disturbed(picture: npt.NDArray[np.uint8], rng: np.random.Generator) -> npt.NDArray[np.uint8]:
    """The picture under slightly other light, with a sensor's noise."""
    bright = 255 * (picture.astype(np.float32) / 255) ** rng.uniform(0.85, 1.15) * rng.uniform(0.9, 1.1)
    noisy = bright + rng.normal(0, 1, picture.shape).astype(np.float32) * rng.uniform(0, 4)
    return np.clip(noisy, 0, 255).astype(np.uint8)


def write_picture(path: Path, picture: npt.NDArray[np.uint8], rng: np.random.Generator) -> None:
    """Write an RGB picture as JPEG of some everyday quality."""
    quality = int(rng.integers(60, 96))
    cv2.imwrite(str(path), cv2.cvtColor(picture, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, quality])


def frames_file(job: Job) -> Path:
    """Written last: where it exists, the home is done."""
    return job.data / "frames" / f"{job.seed:06d}.jsonl"


def render_homes(data: Path, seeds: range, images: int, jobs: int) -> None:
    """Render every home of `seeds` that is not there yet."""
    for folder in ("images", "labels", "frames"):
        (data / folder).mkdir(parents=True, exist_ok=True)
    todo = [job for seed in seeds if not frames_file(job := Job(data, seed, images)).exists()]
    say("dataset", f"{len(todo)} homes to render, {len(seeds) - len(todo)} there already")
    began_s = reported_s = time.monotonic()
    counts: Counter[str] = Counter()
    with multiprocessing.get_context("spawn").Pool(jobs, maxtasksperchild=100) as pool:
        for done, kinds in enumerate(pool.imap_unordered(render_home, todo), start=1):
            counts += kinds
            now_s = time.monotonic()
            if now_s - reported_s > REPORT_S or done == len(todo):
                reported_s = now_s
                say("dataset", f"{done} of {len(todo)} homes, {(now_s - began_s) / done:.2f} s each")
    say("dataset", kinds_in(counts))


def main() -> None:
    """Read the command line and render."""
    parser = argparse.ArgumentParser(prog="sim.training.dataset", description=__doc__.splitlines()[0])
    parser.add_argument("data", type=Path, help="folder to write into; what is there already is kept")
    parser.add_argument("--first", type=int, required=True, help="first seed (100000 to train on, 900000 held out)")
    parser.add_argument("--homes", type=int, required=True, help="how many homes")
    parser.add_argument("--images", type=int, default=8, help="pictures of each home (default 8)")
    parser.add_argument("--jobs", type=int, default=2, help="processes (default 2)")
    arguments = parser.parse_args()
    seeds = range(arguments.first, arguments.first + arguments.homes)
    render_homes(arguments.data, seeds, arguments.images, arguments.jobs)


if __name__ == "__main__":
    main()
