"""What the service needs of the world: who reads speech, who tells it from noise, who speaks."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

from contracts.speech import Voice
from speech.sound import Samples


@dataclass(frozen=True, slots=True)
class Reading:
    """`language` is BCP 47, empty where the engine does not say."""

    text: str
    language: str


@dataclass(frozen=True, slots=True)
class Spoken:
    samples: Samples
    rate_hz: int


class Recognizer(Protocol):
    """Speech to text. Methods block; one at a time is called, never on the event loop.

    Raises `mesh.errors.UnavailableError` where it cannot be asked now.
    """

    @property
    def name(self) -> str:
        """The engine and its model, for people."""
        ...

    def load(self) -> None: ...

    def tokens_of(self, text: str) -> int:
        """How much of what the engine takes as hot words this is."""
        ...

    def readings(self, samples: Samples, hints: Sequence[str]) -> Iterator[Reading]:
        """Of 16 kHz, one for each of `hints`, made when it is asked for: the hot words it leans towards, '' = none."""
        ...


class VoiceActivity(Protocol):
    """Tells speech from everything else. Blocks."""

    def load(self) -> None: ...

    def probabilities(self, samples: Samples) -> Sequence[float]:
        """How likely somebody speaks, for each 32 ms of 16 kHz; what is left at the end counts as one more."""
        ...


class Synthesizer(Protocol):
    """Text to speech. Blocks. Raises `mesh.errors.UnavailableError` where it cannot be asked now."""

    @property
    def voices(self) -> Sequence[Voice]:
        """Those that would speak now; none where it is not installed."""
        ...

    def load(self) -> None: ...

    def speak(self, text: str, voice: str, speed: float) -> Spoken: ...
