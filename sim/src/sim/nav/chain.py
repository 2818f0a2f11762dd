"""What lies between Nav2's controller and the bridge, velocity smoother and collision monitor, as seen of the real."""

import math
from collections import deque
from dataclasses import dataclass
from typing import Final

from contracts.geometry import Twist2D
from sim.nav.follower import STILL

REPEATS_S: Final = 1.0
"""The smoother's `velocity_timeout`: so long it repeats the last word of a controller that fell silent."""
ZEROS_S: Final = 1.0
"""Then zeros for so long, then nothing."""


@dataclass(frozen=True)
class ChainHabits:
    """`gap_s` long nothing comes out, once in `gap_every_s`; 0 = never."""

    delay_s: float = 0.1
    gap_s: float = 0.0
    gap_every_s: float = 5.0


class VelocityChain:
    """`put` what the controller wants, `out` at each control period what comes out at the end. One clock."""

    def __init__(self, habits: ChainHabits) -> None:
        self._habits = habits
        self._due: deque[tuple[float, Twist2D]] = deque()
        self._last = STILL
        self._last_s = -math.inf

    def put(self, twist: Twist2D, now_s: float) -> None:
        self._due.append((now_s + self._habits.delay_s, twist))

    def out(self, now_s: float) -> Twist2D | None:
        """None = nothing is published now."""
        while self._due and self._due[0][0] <= now_s:
            self._last_s, self._last = self._due.popleft()
        silent_s = now_s - self._last_s
        in_gap = now_s % self._habits.gap_every_s < self._habits.gap_s
        if in_gap or silent_s > REPEATS_S + ZEROS_S:
            return None
        return self._last if silent_s <= REPEATS_S else STILL
