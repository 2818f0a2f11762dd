"""Trains the small CLIP: crops of simulated things against phrases such as "red bottle".

    python -m sim.training.clip DATA OUT.safetensors --steps 3000 --held-out HELD_OUT_DATA

Four losses: an image must find its own phrase among all of them, its kind among the kinds, its colour among the
colours of its kind, and every pair of image and phrase must fall on the right side of one common threshold, which is
what a validator needs. The threshold itself is measured afterwards on homes the model never saw.
A run that was broken off goes on where it stopped (OUT.state) when the command is repeated.
"""

import argparse
import math
import random
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch.nn import functional

from inference.perception.small_clip import ClipConfig, build, load, load_model, save, tokenize
from sim.training.checkpoint import Checkpoint
from sim.training.crops import read_crops
from sim.training.detector import Average, groups
from sim.training.length import Length
from sim.training.phrases import Meaning, compared, phrase, vocabulary
from sim.training.progress import say
from sim.training.thresholds import calibrate

NAME = "atom-home-clip"
SCALE = 16.0
REPORT_S = 60.0
SAVE_S = 300.0


@dataclass(frozen=True)
class Targets:
    """All phrases there are, and for each crop which of them fit."""

    meanings: list[Meaning]
    exact: torch.Tensor
    """(n,) the phrase with kind and colour."""
    kind: torch.Tensor
    """(n,) the phrase with the kind alone."""
    same_kind: torch.Tensor
    """(phrases, phrases) whether two phrases name a colour of the same kind."""
    coloured: torch.Tensor
    """(phrases,) whether the phrase names a colour."""


def targets_of(meanings: list[Meaning]) -> Targets:
    """Collect the phrases. A kind that comes in colours also gets its phrase without one, and in every colour a vote
    compares it with: what was never said in training ("brown book") would be a rival with a score of chance.
    """
    phrases = sorted({*meanings, *(Meaning(one.kind) for one in meanings), *compared(meanings)})
    place = {one: i for i, one in enumerate(phrases)}
    kinds = np.array([one.kind for one in phrases])
    coloured = np.array([bool(one.colour) for one in phrases])
    same = (kinds[:, None] == kinds[None]) & coloured[:, None] & coloured[None]
    return Targets(
        meanings=phrases,
        exact=torch.tensor([place[one] for one in meanings]),
        kind=torch.tensor([place[Meaning(one.kind)] for one in meanings]),
        same_kind=torch.from_numpy(same),
        coloured=torch.from_numpy(coloured),
    )


def losses(cosine: torch.Tensor, bias: torch.Tensor, targets: Targets, rows: torch.Tensor) -> torch.Tensor:
    """The sum of the four losses for cosines (batch, phrases) of the crops `rows`."""
    logits = SCALE * cosine
    exact, kind = targets.exact[rows], targets.kind[rows]
    has_colour = targets.coloured[exact]
    own_without_colour = functional.one_hot(kind, logits.shape[1]).bool() & has_colour[:, None]
    among_all = functional.cross_entropy(logits.masked_fill(own_without_colour, -1e4), exact)
    among_kinds = functional.cross_entropy(logits.masked_fill(targets.coloured[None], -1e4), kind)
    total = among_all + 0.5 * among_kinds
    if has_colour.any():
        within = logits.masked_fill(~targets.same_kind[exact], -1e4)[has_colour]
        total = total + 1.5 * functional.cross_entropy(within, exact[has_colour])
    fits = functional.one_hot(exact, logits.shape[1]) + functional.one_hot(kind, logits.shape[1])
    right = fits.clamp(max=1).float()
    near = targets.same_kind[exact].float()  # another colour of the same kind: the mistake that matters most
    weight = right * 30 + near * (1 - right) * 8 + (1 - right)
    pairs = functional.binary_cross_entropy_with_logits(logits + bias, right, weight, reduction="sum")
    return total + pairs / weight.sum() * 4


class Disturbance:
    """Turns crops as stored into crops as met: mirrored, relit, noisy. Draws its noise from a bank made once."""

    def __init__(self, size_px: int) -> None:
        self._noise = 5 * torch.randn(64, 3, size_px, size_px)

    def __call__(self, squares: torch.Tensor) -> torch.Tensor:
        """Bytes (n, s, s, 3) to floats (n, 3, s, s) in -1..1."""
        images = squares.permute(0, 3, 1, 2).float()  # channels last, as the convolutions are fastest
        images = torch.flip(images, [3]) if random.random() < 0.5 else images
        count = len(images)
        gain = (0.75 + 0.45 * torch.rand(count, 1, 1, 1)) * (0.96 + 0.08 * torch.rand(count, 3, 1, 1))
        noise = self._noise[torch.randint(len(self._noise), (count,))] * torch.rand(count, 1, 1, 1)
        return (images * gain + noise + 6 * torch.randn(count, 1, 1, 1)).clamp(0, 255) / 127.5 - 1.0


def train(arguments: argparse.Namespace) -> None:
    """Run all steps, then measure the threshold on the held-out homes."""
    torch.set_num_threads(arguments.threads)
    config = ClipConfig(name=NAME, words=vocabulary(), threshold=0.5)
    crops = read_crops(arguments.data, config.image_size_px, arguments.copies, arguments.seed)
    targets = targets_of(crops.meanings)
    squares = torch.from_numpy(crops.squares)
    say("clip", f"{len(squares)} crops, {len(targets.meanings)} phrases, {len(config.words)} words")
    model = build(config) if arguments.init is None else started_from(arguments.init, config)
    model.visual.to(memory_format=torch.channels_last)
    model.train()
    average = Average(model)
    bias = torch.nn.Parameter(torch.tensor(-0.5 * SCALE))
    optimiser = torch.optim.AdamW([*groups(model, 0.05), {"params": [bias], "weight_decay": 0.0}], lr=1e-6)
    count = torch.bincount(targets.exact, minlength=len(targets.meanings)).float()
    chance = count[targets.exact] ** -0.5
    parts = {"model": model, "average": average.model, "optimiser": optimiser, "bias": torch.nn.ParameterList([bias])}
    checkpoint = Checkpoint(arguments.out.with_suffix(".state"), parts)
    first = checkpoint.load()
    torch.manual_seed(arguments.seed + first)
    random.seed(arguments.seed + first)
    draw, disturb = random.Random(arguments.seed + first), Disturbance(config.image_size_px)
    began_s = reported_s = saved_s = time.monotonic()
    sums: list[float] = []
    step, length = first - 1, Length(arguments.steps, arguments.minutes)
    for step, spent in length.steps_from(first):
        now_s = time.monotonic()
        rate = arguments.lr * min(1.0, (step + 1) / 100) * (0.01 + 0.99 * (0.5 + 0.5 * math.cos(math.pi * spent)))
        for group in optimiser.param_groups:
            group["lr"] = rate
        rows = torch.multinomial(chance, arguments.batch, replacement=True)
        texts = tokenize([phrase(one, draw) for one in targets.meanings], config)
        with torch.autocast("cpu", torch.bfloat16, enabled=not arguments.float32):
            seen, said = model.encode_image(disturb(squares[rows])), model.encode_text(texts)
        cosine = functional.normalize(seen.float(), dim=-1) @ functional.normalize(said.float(), dim=-1).T
        loss = losses(cosine, bias, targets, rows)
        optimiser.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(model.parameters(), 5.0)
        optimiser.step()
        average.update(model, step)
        sums.append(loss.item())
        if now_s - reported_s > REPORT_S:
            say("clip", f"{(now_s - began_s) / 60:.1f} min, step {step}, loss {np.mean(sums):.3f}, rate {rate:.5f}")
            reported_s, sums = now_s, []
        if now_s - saved_s > SAVE_S:
            saved_s = now_s
            save(arguments.out, average.model, config, {"steps": step})
            checkpoint.save(step + 1)
    finish(arguments, average.model, config, {"steps": step + 1, "crops": len(squares)})
    checkpoint.done()


def started_from(path: Path, config: ClipConfig) -> Any:
    """The model of an earlier run; its vocabulary must be the same."""
    model, earlier = load_model(path)
    if earlier.words != config.words:
        raise ValueError(f"{path} knows other words than this recipe: train from the start")
    return model


def finish(arguments: argparse.Namespace, model: Any, config: ClipConfig, notes: dict[str, Any]) -> None:
    """Save; where there are held-out homes, measure threshold and accuracy on them first."""
    save(arguments.out, model, config, notes)
    if arguments.held_out is None:
        return
    small = load(arguments.out)
    crops = read_crops(arguments.held_out, config.image_size_px, 0, 0)
    found = calibrate(small.embed_squares(crops.squares), crops.meanings, small.embed_text)
    say("clip", f"held out: {found}")
    save(arguments.out, model, replace(config, threshold=round(found.threshold, 3)), {**notes, **found.as_dict()})


def main() -> None:
    """Read the command line and train."""
    parser = argparse.ArgumentParser(prog="sim.training.clip", description=__doc__.splitlines()[0])
    parser.add_argument("data", type=Path, help="a data set written by sim.training.dataset")
    parser.add_argument("out", type=Path, help="where the weights go (.safetensors; a .json is written beside them)")
    parser.add_argument("--held-out", type=Path, help="a data set of other homes, to measure the threshold on")
    parser.add_argument("--steps", type=int, default=3000, help="batches to learn from (default 3000)")
    parser.add_argument("--minutes", type=float, help="end after so many, the learning rate down by then")
    parser.add_argument("--init", type=Path, help="go on from an earlier run's weights")
    parser.add_argument("--copies", type=int, default=2, help="shaken crops of each thing (default 2)")
    parser.add_argument("--batch", type=int, default=128)
    parser.add_argument("--lr", type=float, default=0.0015)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--float32", action="store_true", help="where the processor has no bfloat16: ten times as fast")
    train(parser.parse_args())


if __name__ == "__main__":
    main()
