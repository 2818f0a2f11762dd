"""espeak-ng as a child process: many languages, robotic, there where Debian's package is."""

import io
import shutil
import subprocess
import wave
from collections.abc import Sequence
from typing import Final

import numpy as np

from contracts.speech import Voice
from mesh.errors import UnavailableError
from speech.ports import Spoken

LANGUAGES: Final = ("en-us", "en-gb", "de", "fr", "es", "it")
WORDS_A_MINUTE: Final = 160
TIMEOUT_S: Final = 10.0


class EspeakSynthesizer:
    @property
    def voices(self) -> Sequence[Voice]:
        return [Voice(name=f"espeak-{one}", engine="espeak-ng", language=one) for one in LANGUAGES]

    def load(self) -> None:
        if shutil.which("espeak-ng") is None:
            raise UnavailableError("voice", "espeak-ng is not installed")

    def speak(self, text: str, voice: str, speed: float) -> Spoken:
        pace = str(round(WORDS_A_MINUTE * speed))
        command = ["espeak-ng", "--stdout", "-v", voice.removeprefix("espeak-"), "-s", pace, "--stdin"]
        try:
            done = subprocess.run(command, input=text.encode(), capture_output=True, timeout=TIMEOUT_S, check=True)
        except (OSError, subprocess.SubprocessError) as error:
            raise UnavailableError("voice", f"espeak-ng: {error}") from error
        try:
            with wave.open(io.BytesIO(done.stdout)) as file:
                heard = np.frombuffer(file.readframes(len(done.stdout)), "<i2")
                return Spoken(heard.astype(np.float32) / np.float32(32768), file.getframerate())
        except (EOFError, wave.Error) as error:
            raise UnavailableError("voice", f"espeak-ng said nothing: {error}") from error
