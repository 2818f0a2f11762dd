"""openWakeWord's models in TensorFlow Lite, out of the wheel `pyopen-wakeword`."""

from pyopen_wakeword import Model, OpenWakeWord, OpenWakeWordFeatures

from ear.ports import CHUNK_BYTES
from ear.settings import WakeWord


class OpenWakeWordDetector:
    """The port `WakeWordDetector`, for real."""

    def __init__(self, word: WakeWord, probability_min: float) -> None:
        self._features = OpenWakeWordFeatures.from_builtin()
        self._word = OpenWakeWord.from_builtin(Model(word.value))
        self._probability_min = probability_min
        self.heard(bytes(CHUNK_BYTES))  # the first call takes eight seconds of silence along

    def heard(self, samples: bytes) -> bool:
        found = [
            probability >= self._probability_min
            for features in self._features.process_streaming(samples)
            for probability in self._word.process_streaming(features)
        ]
        return any(found)

    def forget(self) -> None:
        """The word alone is begun anew: with new features eight seconds of silence would be reckoned again."""
        self._word.reset()
