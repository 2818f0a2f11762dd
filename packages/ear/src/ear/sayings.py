"""Where a short saying begins and ends, by loudness alone: what may be an order to stop is worth a reading. Pure."""

from dataclasses import dataclass, field
from typing import Final

import numpy as np

from ear.ports import CHUNK_S

LOUD_MIN: Final = 150.0
"""Root mean square of 16-bit samples: a voice across a room; a microphone's own noise is a tenth of it."""
OVER_FLOOR: Final = 3.0
"""So much louder than what is heard all the time (10 dB)."""
BEFORE_S: Final = 0.3
"""A first consonant is quiet."""
END_S: Final = 0.24
LONG_S: Final = 2.0
"""An order to stop is shorter: who says more is not read."""
SHORT_S: Final = 0.24
"""A click is shorter, also where it falls into two chunks."""
ALWAYS_S: Final = 4.0
"""What is loud for so long is the room, not a saying."""


@dataclass
class Sayings:
    """Fed with chunks of `CHUNK_S`; keeps no more than `LONG_S` and what stands around it."""

    _floor: float = 40.0
    _before: list[bytes] = field(default_factory=list[bytes])
    _said: list[bytes] = field(default_factory=list[bytes])
    _loud_s: float = 0.0
    _silent_s: float = 0.0
    _too_long: bool = False

    def take(self, chunk: bytes) -> bytes | None:
        """A saying that has just ended, with a little silence around it; none where none has, or it was a long one."""
        loudness = _loudness(chunk)
        loud = loudness >= max(LOUD_MIN, OVER_FLOOR * self._floor)
        if not loud:
            self._floor += 0.1 * (loudness - self._floor)
        if not self._said and not loud:
            self._before = [*self._before, chunk][-round(BEFORE_S / CHUNK_S) :]
            return None
        self._silent_s = 0.0 if loud else self._silent_s + CHUNK_S
        self._loud_s += CHUNK_S * loud
        self._too_long = self._too_long or self._loud_s > LONG_S
        self._said = (
            [*self._before, chunk] if not self._said else self._said if self._too_long else [*self._said, chunk]
        )
        if self._loud_s > ALWAYS_S:
            self._floor, self._silent_s = loudness, END_S
        if self._silent_s < END_S - CHUNK_S / 2:
            return None
        ended = b"".join(self._said) if not self._too_long and self._loud_s >= SHORT_S - CHUNK_S / 2 else None
        self.forget()
        return ended

    def forget(self) -> None:
        """What comes next does not follow. How loud the room is stays known."""
        self._before, self._said = [], []
        self._loud_s = self._silent_s = 0.0
        self._too_long = False


def _loudness(chunk: bytes) -> float:
    samples = np.frombuffer(chunk, "<i2").astype(np.float64)
    return float(np.sqrt(np.mean(samples**2))) if len(samples) else 0.0
