"""What goes wrong between services, drawn from a seed: messages late, lost, twice; answers late, lost, senseless."""

import math
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from bench.world.faults import Faults

SENSELESS: Final = b'{"sense": "none"}'
"""The body of an answer that is JSON and keeps no contract."""


@dataclass(frozen=True)
class Answering:
    """What becomes of one call. `late_s`: of the request and its answer together."""

    late_s: float = 0.0
    lost_there: bool = False
    """The service never hears of it."""
    lost_back: bool = False
    """The service has done it; the caller does not hear so."""
    senseless: bool = False


WELL: Final = Answering()


@dataclass
class Line:
    """Between all services of one mesh. Nothing goes wrong before `begins_s`, on the loop's own clock."""

    faults: Faults = field(default_factory=Faults)
    seed: int = 0
    begins_s: float = math.inf
    dead: set[str] = field(default_factory=set[str])
    """Services that are no more: nothing they still say arrives."""

    def __post_init__(self) -> None:
        self._bus, self._calls = (np.random.default_rng([self.seed, 400 + part]) for part in range(2))

    def copies_s(self, now_s: float) -> tuple[float, ...]:
        """How late each copy of a message of the bus is, s; none where it is lost."""
        faults, rng = self.faults, self._bus
        if now_s < self.begins_s:
            return (0.0,)
        if faults.bus_drop and rng.random() < faults.bus_drop:
            return ()
        count = 2 if faults.bus_duplicate and rng.random() < faults.bus_duplicate else 1
        return tuple(_drawn_s(rng, faults.bus_delay_s_max) for _ in range(count))

    def answering(self, now_s: float) -> Answering:
        faults, rng = self.faults, self._calls
        if now_s < self.begins_s:
            return WELL
        late_s = _drawn_s(rng, faults.reply_delay_s_max)
        lost = bool(faults.reply_lost) and rng.random() < faults.reply_lost
        there = lost and rng.random() < 0.5
        senseless = bool(faults.reply_senseless) and rng.random() < faults.reply_senseless
        return Answering(late_s, there, lost and not there, senseless)


def _drawn_s(rng: np.random.Generator, most_s: float) -> float:
    return float(rng.uniform(0.0, most_s)) if most_s else 0.0
