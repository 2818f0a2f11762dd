"""What is taken as sound, and what every refusal is called."""

import struct

import numpy as np
import pytest

from contracts.speech import RATE_HZ, SpeechRefusal
from speech.sound import SoundError, duration_s, from_pcm, from_wav, to_wav


def tone(rate_hz: int, seconds: float = 1.0) -> np.ndarray:
    return (0.5 * np.sin(2 * np.pi * 440 * np.arange(int(rate_hz * seconds)) / rate_hz)).astype(np.float32)


def loudest_hz(samples: np.ndarray) -> float:
    return float(np.argmax(np.abs(np.fft.rfft(samples))) * RATE_HZ / len(samples))


@pytest.mark.parametrize("rate_hz", [8_000, 11_025, 16_000, 22_050, 44_100, 48_000])
def test_a_tone_of_any_usual_rate_is_the_same_tone_at_16_khz(rate_hz: int) -> None:
    samples = from_wav(to_wav(tone(rate_hz), rate_hz))
    assert duration_s(samples) == pytest.approx(1.0, abs=0.01)
    assert loudest_hz(samples) == pytest.approx(440, abs=2)
    assert np.abs(samples).max() == pytest.approx(0.5, abs=0.05)


WAV = to_wav(tone(RATE_HZ), RATE_HZ)


def changed(at: int, form: str, value: int) -> bytes:
    """The WAV with one field of its header another."""
    made = bytearray(WAV)
    struct.pack_into(form, made, at, value)
    return bytes(made)


@pytest.mark.parametrize(
    ("body", "refusal"),
    [
        (b"", SpeechRefusal.NOT_WAV),
        (b"OggS" + bytes(100), SpeechRefusal.NOT_WAV),
        (WAV[:30], SpeechRefusal.TRUNCATED),
        (WAV[:-1000], SpeechRefusal.TRUNCATED),
        (changed(16, "<I", 0x7FFF_FFFF), SpeechRefusal.TRUNCATED),
        (changed(20, "<H", 3), SpeechRefusal.UNSUPPORTED_CODING),
        (changed(34, "<H", 8), SpeechRefusal.UNSUPPORTED_CODING),
        (changed(24, "<I", 4_000), SpeechRefusal.UNSUPPORTED_RATE),
        (changed(24, "<I", 96_000), SpeechRefusal.UNSUPPORTED_RATE),
        (changed(22, "<H", 6), SpeechRefusal.UNSUPPORTED_RATE),
        (to_wav(tone(RATE_HZ, 0.05), RATE_HZ), SpeechRefusal.TOO_SHORT),
        (to_wav(tone(RATE_HZ, 15.1), RATE_HZ), SpeechRefusal.TOO_LONG),
    ],
)
def test_what_is_no_sound_to_listen_to_says_why(body: bytes, refusal: SpeechRefusal) -> None:
    with pytest.raises(SoundError) as told:
        from_wav(body)
    assert told.value.refusal is refusal


def test_a_stream_whose_length_nobody_knew_is_taken_as_far_as_it_goes() -> None:
    assert duration_s(from_wav(changed(40, "<I", 0x7FFF_F000))) == pytest.approx(1.0)


def test_raw_samples_are_whole_samples() -> None:
    assert duration_s(from_pcm(bytes(RATE_HZ))) == 0.5
    with pytest.raises(SoundError):
        from_pcm(bytes(RATE_HZ + 1))
