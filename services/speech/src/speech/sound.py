"""What a client sends, read as 16 kHz mono samples: WAV of any usual rate, or raw PCM. Pure."""

import io
import wave
from typing import Final

import numpy as np
from numpy.typing import NDArray

from contracts.speech import RATE_HZ, SpeechRefusal

RATE_HZ_MIN, RATE_HZ_MAX = 8_000, 48_000
CHANNELS_MAX: Final = 2
DURATION_S_MIN, DURATION_S_MAX = 0.1, 15.0
BYTES_MAX: Final = int((DURATION_S_MAX + 1) * RATE_HZ_MAX * CHANNELS_MAX * 2)
"""Of the largest body worth reading: a second more than is taken, so that the answer can say what is too long."""
LENGTH_UNKNOWN: Final = 0x7FFF_0000
"""Bytes from which on the length in a header is that of a stream whose end nobody knew, as espeak-ng writes it."""

Samples = NDArray[np.float32]


class SoundError(Exception):
    """Why this is not taken as sound."""

    def __init__(self, refusal: SpeechRefusal, detail: str) -> None:
        super().__init__(detail)
        self.refusal = refusal
        self.detail = detail


def duration_s(samples: Samples) -> float:
    return len(samples) / RATE_HZ


def from_wav(body: bytes) -> Samples:
    """Raises `SoundError`. Two channels become their mean."""
    if body[:4] != b"RIFF" or body[8:12] != b"WAVE":
        raise SoundError(SpeechRefusal.NOT_WAV, "neither a RIFF WAVE file nor sent as audio/L16")
    try:
        with wave.open(io.BytesIO(body)) as file:
            channels, width, rate, frames = (
                file.getnchannels(),
                file.getsampwidth(),
                file.getframerate(),
                file.getnframes(),
            )
            data = file.readframes(min(frames, len(body)))
    except (EOFError, RuntimeError):  # `wave` raises the second for a chunk longer than the file
        raise SoundError(SpeechRefusal.TRUNCATED, "it ends before its header says so") from None
    except wave.Error as error:
        raise SoundError(SpeechRefusal.UNSUPPORTED_CODING, f"only 16-bit PCM is read: {error}") from None
    if width != 2:
        raise SoundError(SpeechRefusal.UNSUPPORTED_CODING, f"only 16-bit PCM is read, not {8 * width}-bit")
    if not RATE_HZ_MIN <= rate <= RATE_HZ_MAX or not 1 <= channels <= CHANNELS_MAX:
        limits = f"{RATE_HZ_MIN} to {RATE_HZ_MAX} Hz and 1 or {CHANNELS_MAX} channels"
        raise SoundError(SpeechRefusal.UNSUPPORTED_RATE, f"{rate} Hz, {channels} channels; taken are {limits}")
    promised = frames * channels * width
    if len(data) < promised < LENGTH_UNKNOWN:
        raise SoundError(SpeechRefusal.TRUNCATED, f"its header promises {promised} bytes of sound, {len(data)} came")
    frame_bytes = channels * width
    heard = np.frombuffer(data[: len(data) // frame_bytes * frame_bytes], "<i2").reshape(-1, channels)
    _require_length(len(heard) / rate)
    return _at_16_khz(heard.mean(axis=1).astype(np.float32) / 32768, rate)


def from_pcm(body: bytes) -> Samples:
    """Raw 16-bit little-endian samples at 16 kHz, one channel. Raises `SoundError`."""
    if len(body) % 2:
        raise SoundError(SpeechRefusal.TRUNCATED, "it ends in the middle of a sample")
    _require_length(len(body) / (2 * RATE_HZ))
    return samples_of(body)


def samples_of(pcm: bytes | bytearray) -> Samples:
    """Whole 16-bit samples, of any length."""
    return np.frombuffer(pcm, "<i2").astype(np.float32) / np.float32(32768)


def to_wav(samples: Samples, rate_hz: int) -> bytes:
    """16-bit mono."""
    file = io.BytesIO()
    with wave.open(file, "wb") as out:
        out.setnchannels(1)
        out.setsampwidth(2)
        out.setframerate(rate_hz)
        out.writeframes((np.clip(samples, -1.0, 1.0) * 32767).astype("<i2").tobytes())
    return file.getvalue()


def _require_length(length_s: float) -> None:
    if length_s < DURATION_S_MIN:
        raise SoundError(SpeechRefusal.TOO_SHORT, f"{length_s:.2f} s; a word takes at least {DURATION_S_MIN} s")
    if length_s > DURATION_S_MAX:
        raise SoundError(SpeechRefusal.TOO_LONG, f"{length_s:.1f} s; at most {DURATION_S_MAX:.0f} s are listened to")


def _at_16_khz(samples: Samples, rate_hz: int) -> Samples:
    """By its spectrum: what 16 kHz cannot hold is cut off, nothing folds back."""
    if rate_hz == RATE_HZ:
        return samples
    length = round(len(samples) * RATE_HZ / rate_hz)
    spectrum = np.fft.rfft(samples)[: length // 2 + 1]
    return (np.fft.irfft(spectrum, length) * (length / len(samples))).astype(np.float32)
