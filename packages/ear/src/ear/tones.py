"""Short sounds that need no voice, as WAVs. Pure."""

import io
import wave
from functools import cache
from typing import Final

import numpy as np

from ear.messages import Tone

RATE_HZ: Final = 48_000
LOUDNESS: Final = 0.15
NOTES_HZ: Final = {Tone.AWAKE: (660.0, 880.0), Tone.DONE: (880.0,), Tone.TROUBLE: (440.0, 330.0)}
NOTE_S: Final = 0.09


@cache
def wav_of(tone: Tone) -> bytes:
    """16-bit mono; each note swells and fades, so that it does not click."""
    at_s = np.arange(round(NOTE_S * RATE_HZ)) / RATE_HZ
    swell = np.sin(np.pi * at_s / NOTE_S)
    notes = np.concatenate([np.sin(2 * np.pi * hz * at_s) * swell for hz in NOTES_HZ[tone]])
    file = io.BytesIO()
    with wave.open(file, "wb") as out:
        out.setnchannels(1)
        out.setsampwidth(2)
        out.setframerate(RATE_HZ)
        out.writeframes((LOUDNESS * 32767 * notes).astype("<i2").tobytes())
    return file.getvalue()
