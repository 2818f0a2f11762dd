"""When somebody has begun to speak and when they are done, from how likely speech is in each stretch of sound. Pure."""

from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Final

PROBABILITY_MIN: Final = 0.5
"""Silero's own: from here on it is speech."""
BEGIN_S: Final = 0.1
"""A click is shorter."""
END_S: Final = 0.7
"""A breath between two words is shorter."""
NOBODY_S: Final = 8.0
"""Who has not begun by then will not."""


class Turn(StrEnum):
    """Where a speaker is."""

    WAITING = "waiting"
    """Nobody has spoken yet."""
    SPEAKING = "speaking"
    DONE = "done"
    """Was silent for `END_S` after speaking."""
    NOBODY = "nobody"
    """Did not begin within `NOBODY_S`."""


ALLOWED: Final[dict[Turn, frozenset[Turn]]] = {
    Turn.WAITING: frozenset({Turn.SPEAKING, Turn.NOBODY}),
    Turn.SPEAKING: frozenset({Turn.DONE}),
    Turn.DONE: frozenset(),
    Turn.NOBODY: frozenset(),
}


@dataclass(frozen=True, slots=True)
class Listening:
    """`speech_s` and `silence_s` are the newest unbroken stretches."""

    turn: Turn = Turn.WAITING
    heard_s: float = 0.0
    speech_s: float = 0.0
    silence_s: float = 0.0


def step(was: Listening, probability: float, length_s: float) -> Listening:
    """After `length_s` more of sound, in which speech is as likely as `probability`. An end stays an end."""
    if not ALLOWED[was.turn]:
        return was
    speech = probability >= PROBABILITY_MIN
    now = replace(
        was,
        heard_s=was.heard_s + length_s,
        speech_s=was.speech_s + length_s if speech else 0.0,
        silence_s=0.0 if speech else was.silence_s + length_s,
    )
    if was.turn is Turn.SPEAKING:
        return replace(now, turn=Turn.DONE) if now.silence_s >= END_S else now
    if now.speech_s >= BEGIN_S:
        return replace(now, turn=Turn.SPEAKING)
    return replace(now, turn=Turn.NOBODY) if now.heard_s >= NOBODY_S else now
