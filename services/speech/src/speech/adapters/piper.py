"""piper: good voices of many languages, in this process. An extra (`atom-speech[piper]`), as it is GPL-3.0."""

import io
import wave
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from contracts.speech import Voice
from mesh.errors import UnavailableError
from speech.ports import Spoken


class PiperSynthesizer:
    """`model` is the .onnx file of a voice, its .onnx.json beside it."""

    def __init__(self, model: str) -> None:
        self._file = Path(model)
        self._piper: Any = None
        self._voice: Any = None

    @property
    def voices(self) -> Sequence[Voice]:
        stem = self._file.stem
        return [
            Voice(name=f"piper-{stem}"[:64], engine="piper", language=stem.partition("-")[0].replace("_", "-")[:16])
        ]

    def load(self) -> None:
        if not self._file.is_file():
            raise UnavailableError("voice", "piper: SPEECH_PIPER_VOICE names no file")
        try:
            self._piper = import_module("piper")
            self._voice = self._piper.PiperVoice.load(str(self._file))
        except Exception as error:  # a missing wheel or file: each library has its own error
            raise UnavailableError("voice", f"piper: {error}") from error

    def speak(self, text: str, voice: str, speed: float) -> Spoken:
        file = io.BytesIO()
        with wave.open(file, "wb") as out:
            pace = self._piper.SynthesisConfig(length_scale=1.0 / speed)
            self._voice.synthesize_wav(text, out, syn_config=pace)
        with wave.open(io.BytesIO(file.getvalue())) as told:
            heard = np.frombuffer(told.readframes(told.getnframes()), "<i2")
            return Spoken(heard.astype(np.float32) / np.float32(32768), told.getframerate())
