"""What a faulted mission is: an episode of the search bench, and what goes wrong in it; all drawn from its seed."""

from typing import Any

import numpy as np
from pydantic import Field

from bench.search.episode import Episode
from bench.search.sets import DARK, TUNE_HOMES, episode, site
from bench.world.faults import Faults, draw
from contracts.base import Message

SETS = ("mapped", "moved", "removed", "distractor", "unseen", "occluded", "absent")
"""One command for one thing each."""
POLICIES = {"belief": 0.5, "viewpoints": 0.2, "direct": 0.15, "atom": 0.15}
"""How often each is drawn: the robot as it is delivered the most."""
PATIENCE_S = 240.0
FAULTLESS = 0.2
DOCKED = 0.2
"""So often it begins on its dock."""
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
    policy, fated, docked = drawn(seed)
    fated = fated if faults is None else faults
    one = episode(SETS[seed % len(SETS)], seed // len(SETS), homes)
    like: dict[str, Any] = {"policy": policy, "changes": (f"mission_timeout_s={PATIENCE_S:g}",)}
    if docked:
        like["start"] = site(one.home_seed).world.scene.dock
    if fated.errors.dark:
        like |= DARK
    return FaultedEpisode(seed=seed, episode=one.model_copy(update=like | changes), faults=fated)


def drawn(seed: int) -> tuple[str, Faults, bool]:
    """The policy, what goes wrong, and whether it begins on its dock."""
    rng = np.random.default_rng([seed, 1])
    count = 0 if rng.random() < FAULTLESS else int(rng.integers(1, KINDS_MOST + 1))
    policy = str(rng.choice(list(POLICIES), p=list(POLICIES.values())))
    return policy, draw(rng, count), bool(rng.random() < DOCKED)
