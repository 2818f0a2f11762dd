"""The speech service's ports without models: loud is speech, and everything sounds the same."""

from collections.abc import Iterator, Sequence

import numpy as np

from contracts.speech import Voice
from speech.ports import Reading, Spoken
from speech.sound import Samples


class FakeRecognizer:
    name = "fake"

    def __init__(self, plain: str = "Find the cap.", hot: str = "find the cup") -> None:
        self.texts = {False: plain, True: hot}
        self.hot_words: list[str] = []
        """Of each reading."""

    def load(self) -> None: ...

    def tokens_of(self, text: str) -> int:
        return len(text)

    def readings(self, samples: Samples, hints: Sequence[str]) -> Iterator[Reading]:
        for hint in hints:
            self.hot_words.append(hint)
            yield Reading(self.texts[bool(hint)], "en")


class LoudActivity:
    def load(self) -> None: ...

    def probabilities(self, samples: Samples) -> Sequence[float]:
        padded = np.pad(samples, (0, -len(samples) % 512)).reshape(-1, 512)
        return [float(one) for one in (np.abs(padded).mean(axis=1) > 0.01)]


class FakeSynthesizer:
    def __init__(self, name: str = "fake") -> None:
        self.voices = [Voice(name=name, engine="fake", language="en")]

    def load(self) -> None: ...

    def speak(self, text: str, voice: str, speed: float) -> Spoken:
        return Spoken(np.full(24_000, 0.1, np.float32), 24_000)
