"""Silero's voice activity, as faster-whisper carries it."""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from mesh.errors import UnavailableError
from speech.sound import Samples

WINDOW: Final = 512


class SileroActivity:
    def __init__(self) -> None:
        self._model: Any = None

    def load(self) -> None:
        try:
            from faster_whisper.vad import get_vad_model

            self._model = get_vad_model()
        except Exception as error:  # a missing wheel or file: each library has its own error
            raise UnavailableError("voice_activity", str(error)) from error

    def probabilities(self, samples: Samples) -> Sequence[float]:
        padded = np.pad(samples, (0, -len(samples) % WINDOW)).astype(np.float32)
        return [float(one) for one in np.ravel(self._model(padded))] if len(padded) else []
