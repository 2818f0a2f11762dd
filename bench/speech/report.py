"""The figures as a table, with Wilson intervals of 95 %."""

import math
from collections import defaultdict
from collections.abc import Sequence

from bench.speech.grammar import held_out
from bench.speech.playing import Clip
from bench.speech.scoring import Scored, Scorer

Z = 1.96
HEAD = (
    "| half | sound | voice | clips | WER | plain reading | agreement | asked back | wrong without asking |\n"
    "|---|---|---|---:|---:|---|---|---|---|\n"
)


async def table(clips: Sequence[Clip]) -> str:
    scorer, groups = Scorer(), defaultdict[tuple[str, str, str], list[Scored]](list)
    for clip in clips:
        scored = await scorer.score(clip)
        half = "held out" if held_out(clip.command) else "tuned on"
        for voice in ("all", clip.voice):
            groups[half, clip.noise, voice].append(scored)
    return HEAD + "".join(_row(*key, some) for key, some in sorted(groups.items()))


def share(count: int, every: int) -> str:
    """'0.50 (0.24-0.76)'"""
    part, weight = count / every, Z * Z / every
    middle = (part + weight / 2.0) / (1.0 + weight)
    half = Z * math.sqrt(part * (1.0 - part) / every + weight / (4.0 * every)) / (1.0 + weight)
    return f"{part:.2f} ({max(0.0, middle - half):.2f}-{min(1.0, middle + half):.2f})"


def _row(half: str, noise: str, voice: str, some: Sequence[Scored]) -> str:
    counts = [sum(getattr(one, name) for one in some) for name in ("plain_right", "right", "asked", "wrong")]
    errors = sum(one.errors for one in some) / sum(one.words for one in some)
    shares = " | ".join(share(count, len(some)) for count in counts)
    return f"| {half} | {noise} | {voice} | {len(some)} | {errors:.3f} | {shares} |\n"
