"""What a faulted mission is: an episode of the search bench, and what goes wrong in it; all drawn from its seed."""

from typing import Any

import numpy as np
from pydantic import Field

from bench.search.episode import Episode
from bench.search.sets import TUNE_HOMES, episode
from bench.world.faults import WITH_REAL_EYES, Faults, draw
from contracts.base import Message

SETS = ("mapped", "moved", "removed", "distractor", "unseen", "occluded", "absent")
"""One command for one thing each."""
POLICIES = ("viewpoints", "belief", "direct", "atom")
PATIENCE_S = 240.0
FAULTLESS = 0.2
KINDS_MOST = 4


class FaultedEpisode(Message):
    """Everything needed to play it again, bit for bit."""

    seed: int = Field(ge=0)
    episode: Episode
    faults: Faults

    @property
    def name(self) -> str:
        return f"{self.seed:04d}"


def faulted(seed: int, homes: tuple[int, ...] = TUNE_HOMES, *, faults: Faults | None = None,
            **changes: Any) -> FaultedEpisode:  # fmt: skip
    """The campaign's mission of that seed. A fifth has no faults at all, the others one to four kinds together.

    `faults`: these instead; `changes`: of the episode.
    """
    policy, fated = drawn(seed)
    plain = episode(SETS[seed % len(SETS)], seed // len(SETS), homes)
    like = {"policy": policy, "changes": (f"mission_timeout_s={PATIENCE_S:g}",)} | changes
    return FaultedEpisode(seed=seed, episode=plain.model_copy(update=like), faults=fated if faults is None else faults)


def drawn(seed: int) -> tuple[str, Faults]:
    """The policy and what goes wrong."""
    rng = np.random.default_rng([seed, 1])
    policy, count = str(rng.choice(POLICIES)), 0 if rng.random() < FAULTLESS else int(rng.integers(1, KINDS_MOST + 1))
    return policy, draw(rng, count, WITH_REAL_EYES)
