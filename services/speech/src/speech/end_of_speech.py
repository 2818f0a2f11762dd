"""When somebody has begun to speak and when they are done, from how likely speech is in each stretch of sound. Pure."""

from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Final

from contracts.speech import RATE_HZ

WINDOW_SAMPLES: Final = 512
WINDOW_S: Final = WINDOW_SAMPLES / RATE_HZ
"""What voice activity looks at a time."""

PROBABILITY_MIN: Final = 0.5
"""Silero's own: from here on it is speech."""
BEGIN_S: Final = 0.1
"""A click is shorter."""
END_S: Final = 0.7
"""A breath between two words is shorter."""
NOBODY_S: Final = 8.0
"""Who has not begun by then will not."""
PAUSES_S: Final = (0.16, 0.4)
"""After so long a silence it may be the end: what was said is read at once, as a stop is one word, and once more, as a
little silence behind a word makes it better read."""


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
    """`speech_s` and `silence_s` are the newest unbroken stretches; `begun_s` is where in the sound speech began."""

    turn: Turn = Turn.WAITING
    heard_s: float = 0.0
    speech_s: float = 0.0
    silence_s: float = 0.0
    begun_s: float | None = None


def step(was: Listening, probability: float, length_s: float, *, held: bool = False) -> Listening:
    """After `length_s` more of sound, in which speech is as likely as `probability`. An end stays an end; while a
    button is `held` silence is none.
    """
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
        return replace(now, turn=Turn.DONE) if now.silence_s >= END_S and not held else now
    if now.speech_s >= BEGIN_S:
        return replace(now, turn=Turn.SPEAKING, begun_s=now.heard_s - now.speech_s)
    return replace(now, turn=Turn.NOBODY) if now.heard_s >= NOBODY_S and not held else now


def paused(now: Listening) -> bool:
    """Whether what was said so far may be all."""
    return now.turn is Turn.SPEAKING and now.silence_s >= PAUSES_S[0] - WINDOW_S / 2


def due(now: Listening, read_s: float | None, period_s: float) -> bool:
    """Whether what was heard is to be read now, where it was last read at `read_s`: at every pause, and each `period_s`
    of what is said, the first time counted from where speech began."""
    if now.turn is not Turn.SPEAKING or now.begun_s is None:
        return False
    last_s = now.begun_s if read_s is None else read_s
    spoke_s = now.heard_s - now.silence_s
    if paused(now):
        return any(last_s + WINDOW_S / 2 < spoke_s + one <= now.heard_s + WINDOW_S / 2 for one in PAUSES_S)
    return spoke_s > last_s and now.heard_s - last_s >= period_s
