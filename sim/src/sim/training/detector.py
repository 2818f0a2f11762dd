"""Trains the detector: YOLOv8n on the COCO label list, from scratch, on a few CPU cores.

    python -m sim.training.detector DATA OUT.pt --steps 10000

A run that was broken off goes on where it stopped (OUT.state) when the command is repeated.

What makes it quick without a GPU: the network in bfloat16 with channels_last while boxes and loss stay float32,
images in memory as bytes, one batch an optimiser step, composition of the next batches in a thread of its own, and no
validation passes. New homes that appear in DATA while it runs are taken in. The saved weights are a running average.
"""

import argparse
import copy
import math
import queue
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import torch

from contracts.coco import COCO_LABELS
from inference.perception import torchvision_cpu
from sim.training.augment import Picker, Sample, compose
from sim.training.checkpoint import Checkpoint
from sim.training.length import Length
from sim.training.progress import say
from sim.training.records import LABEL_ID, Frame, from_json

REFRESH_S = 240.0
SAVE_S = 300.0
REPORT_S = 60.0
WARM_UP_STEPS = 150
AVERAGE_DECAY = 0.997


class Pool:
    """The data set in memory; `refresh` adds homes written since."""

    def __init__(self, data: Path) -> None:
        self._data = data
        self._read: set[Path] = set()
        self.samples: list[Sample] = []
        self.picker = Picker([])

    def refresh(self) -> int:
        """Read what is new; returns how many images were added."""
        before = len(self.samples)
        for path in sorted((self._data / "frames").glob("*.jsonl")):
            if path not in self._read:
                self._read.add(path)
                self.samples.extend(self._sample(from_json(line)) for line in path.read_text().splitlines())
        self.picker = Picker(self.samples)
        return len(self.samples) - before

    def _sample(self, frame: Frame) -> Sample:
        image = cv2.cvtColor(cv2.imread(str(self._data / frame.image)), cv2.COLOR_BGR2RGB)
        rows = [(LABEL_ID[box.kind], *box.bbox_xyxy) for box in frame.boxes]
        return Sample(image, np.array(rows, np.float32).reshape(-1, 5))


def batches(
    pool: Pool, size_px: int, batch: int, share: dict[str, float], seed: tuple[int, int]
) -> Iterator[dict[str, Any]]:
    """Endless training batches in the form ultralytics' loss reads; composed by a thread, at most four ahead."""
    ready: queue.Queue[dict[str, Any]] = queue.Queue(maxsize=4)

    def compose_forever() -> None:
        rng = np.random.default_rng(seed)
        while True:
            picker = pool.picker
            samples = [compose(picker, size_px, share["mosaic"], share["aim"], rng) for _ in range(batch)]
            ready.put(_collate(samples, size_px))

    threading.Thread(target=compose_forever, daemon=True, name="compose").start()
    while True:
        yield ready.get()


def _collate(samples: list[Sample], size_px: int) -> dict[str, Any]:
    images = torch.from_numpy(np.stack([sample.image for sample in samples])).permute(0, 3, 1, 2)
    labels = torch.from_numpy(np.concatenate([sample.labels for sample in samples]))
    owner = torch.cat([torch.full((len(sample.labels),), float(i)) for i, sample in enumerate(samples)])
    corners = labels[:, 1:] / size_px
    centre, size = (corners[:, :2] + corners[:, 2:]) / 2, corners[:, 2:] - corners[:, :2]
    return {"img": images, "cls": labels[:, :1], "bboxes": torch.cat([centre, size], 1), "batch_idx": owner}


def build(init: Path | None) -> Any:
    """A YOLOv8n `DetectionModel` with our label list, untrained or with the weights of an earlier run."""
    torchvision_cpu.install()
    from ultralytics.cfg import get_cfg
    from ultralytics.nn.tasks import DetectionModel

    model = DetectionModel("yolov8n.yaml", nc=len(COCO_LABELS), verbose=False)
    model.names = dict(enumerate(COCO_LABELS))
    model.args = get_cfg()
    if init is not None:
        model.load_state_dict(torch.load(init, map_location="cpu", weights_only=False)["model"].float().state_dict())
    return model


def save(model: Any, path: Path, size_px: int, note: str) -> None:
    """Write weights that `ultralytics.YOLO(path)` loads: fp16, no optimiser state."""
    plain = copy.deepcopy(model).half().to(memory_format=torch.contiguous_format).eval()
    plain.criterion = None
    plain.args = {"imgsz": size_px, "task": "detect", "model": "yolov8n.yaml", "data": None}
    for parameter in plain.parameters():
        parameter.requires_grad = False
    partial = path.with_suffix(".partial")
    fields = {"model": plain, "ema": None, "epoch": -1, "optimizer": None, "train_args": plain.args, "note": note}
    torch.save(fields, partial)
    partial.replace(path)


def learning_rate(step: int, spent: float, peak: float) -> float:
    """Warm-up, a plateau, then a cosine down to 1 %; `spent` is the share of the steps done."""
    if step < WARM_UP_STEPS:
        return peak * (step + 1) / WARM_UP_STEPS
    if spent < 0.3:
        return peak
    return peak * (0.01 + 0.99 * (0.5 + 0.5 * math.cos(math.pi * min(1.0, (spent - 0.3) / 0.7))))


def groups(model: torch.nn.Module, weight_decay: float) -> list[dict[str, Any]]:
    """Parameters in two groups: weights decay; biases and normalisation do not."""
    decaying = [p for p in model.parameters() if p.requires_grad and p.ndim > 1]
    other = [p for p in model.parameters() if p.requires_grad and p.ndim <= 1]
    return [{"params": decaying, "weight_decay": weight_decay}, {"params": other, "weight_decay": 0.0}]


def as_float32(value: Any) -> Any:
    """The same nest of tensors with every float tensor in float32."""
    if isinstance(value, torch.Tensor):
        return value.float() if value.is_floating_point() else value
    if isinstance(value, dict):
        return {key: as_float32(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return type(value)(as_float32(item) for item in value)
    return value


class Average:
    """A running average of the weights: steadier than the last step's."""

    def __init__(self, model: torch.nn.Module) -> None:
        self.model = copy.deepcopy(model).eval()

    @torch.no_grad()
    def update(self, model: torch.nn.Module, step: int) -> None:
        """Move a little toward the model; the first steps move more."""
        keep = AVERAGE_DECAY * (1 - math.exp(-(step + 1) / 300))
        mine = [v for v in self.model.state_dict().values() if v.is_floating_point()]
        theirs = [v for v in model.state_dict().values() if v.is_floating_point()]
        torch._foreach_lerp_(mine, theirs, 1 - keep)


def train(arguments: argparse.Namespace) -> None:
    """Run all steps, saving every few minutes."""
    torch.set_num_threads(arguments.threads)
    cv2.setNumThreads(1)
    pool = Pool(arguments.data)
    say("detector", f"{pool.refresh()} images read, {arguments.imgsz} px, batch {arguments.batch}")
    model = build(arguments.init).to(memory_format=torch.channels_last).train()
    criterion = model.init_criterion()
    average = Average(model)
    optimiser = torch.optim.AdamW(groups(model, 0.001), lr=1e-6, betas=(0.9, 0.99))
    parts = {"model": model, "average": average.model, "optimiser": optimiser}
    checkpoint = Checkpoint(arguments.out.with_suffix(".state"), parts)
    first = checkpoint.load()
    torch.manual_seed(arguments.seed + first)
    share = {"mosaic": arguments.mosaic, "aim": 0.85}
    began_s = reported_s = saved_s = refreshed_s = time.monotonic()
    losses: list[list[float]] = []
    step, length = first - 1, Length(arguments.steps, arguments.minutes)
    composed = batches(pool, arguments.imgsz, arguments.batch, share, (arguments.seed, first))
    for (step, spent), batch in zip(length.steps_from(first), composed, strict=False):
        now_s = time.monotonic()
        if spent > 0.75:  # end on images as the robot sees them
            share |= {"mosaic": 0.0, "aim": 0.3}
        for group in optimiser.param_groups:
            group["lr"] = learning_rate(step, spent, arguments.lr)
        images = batch["img"].contiguous(memory_format=torch.channels_last).float() / 255
        with torch.autocast("cpu", torch.bfloat16, enabled=not arguments.float32):
            predictions = model(images)
        loss, items = criterion(as_float32(predictions), batch)
        optimiser.zero_grad()
        loss.sum().backward()
        torch.nn.utils.clip_grad_norm_(model.parameters(), 10.0)
        optimiser.step()
        average.update(model, step)
        losses.append([float(item) for item in (items.values() if isinstance(items, dict) else items)])
        if now_s - reported_s > REPORT_S:
            box, kind, edge = np.mean(losses, axis=0)
            rate = len(losses) * arguments.batch / (now_s - reported_s)
            say("detector", f"{(now_s - began_s) / 60:.1f} min, step {step}, {rate:.1f} images/s, "
                f"losses: box {box:.3f} class {kind:.3f} edge {edge:.3f}")  # fmt: skip
            reported_s, losses = now_s, []
        if now_s - refreshed_s > REFRESH_S:
            refreshed_s = now_s
            if added := pool.refresh():
                say("detector", f"{added} images more, {len(pool.samples)} in all")
        if now_s - saved_s > SAVE_S:
            saved_s = now_s
            save(average.model, arguments.out, arguments.imgsz, f"step {step}")
            checkpoint.save(step + 1)
    save(average.model, arguments.out, arguments.imgsz, f"step {step + 1}")
    checkpoint.done()
    say("detector", f"done: {step + 1} steps of {arguments.batch}, {len(pool.samples)} images, {arguments.out}")


def main() -> None:
    """Read the command line and train."""
    parser = argparse.ArgumentParser(prog="sim.training.detector", description=__doc__.splitlines()[0])
    parser.add_argument("data", type=Path, help="a data set written by sim.training.dataset")
    parser.add_argument("out", type=Path, help="where the weights go (.pt)")
    parser.add_argument("--steps", type=int, default=10000, help="batches to learn from (default 10000)")
    parser.add_argument("--minutes", type=float, help="end after so many, the learning rate down by then")
    parser.add_argument("--init", type=Path, help="go on from these weights of an earlier run")
    parser.add_argument("--imgsz", type=int, default=320, help="side of the training image in pixels (default 320)")
    parser.add_argument("--batch", type=int, default=16)
    parser.add_argument("--lr", type=float, default=0.002, help="highest learning rate (0.001 when going on)")
    parser.add_argument("--mosaic", type=float, default=0.6, help="share of mosaics, but none in the last quarter")
    parser.add_argument("--threads", type=int, default=1, help="for torch; more only on idle cores (default 1)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--float32", action="store_true", help="where the processor has no bfloat16: ten times as fast")
    train(parser.parse_args())


if __name__ == "__main__":
    main()
