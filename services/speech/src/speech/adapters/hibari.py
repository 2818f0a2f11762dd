"""hibari: a small American voice in this process, from its wheel."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from contracts.speech import Voice
from mesh.errors import UnavailableError
from speech.ports import Spoken


class HibariSynthesizer:
    def __init__(self) -> None:
        self._voice: Any = None

    @property
    def voices(self) -> Sequence[Voice]:
        return [Voice(name="heart", engine="hibari", language="en-US")]

    def load(self) -> None:
        try:
            from hibari import Hibari

            self._voice = Hibari(voice="heart")
        except Exception as error:  # a missing wheel or file: each library has its own error
            raise UnavailableError("voice", f"hibari: {error}") from error

    def speak(self, text: str, voice: str, speed: float) -> Spoken:
        return Spoken(np.asarray(self._voice(text, speed=speed), np.float32), int(self._voice.sample_rate))
