"""The microphone of this machine, where there is one: an extra (`pip install 'atom-cli[listen]'`)."""

import io
import threading
import wave
from collections.abc import Callable
from importlib import import_module
from typing import Any, Final

from contracts.speech import RATE_HZ

SECONDS_MAX: Final = 15.0
"""Speech takes no more."""
BYTES_MAX: Final = int(SECONDS_MAX * RATE_HZ) * 2


class MicrophoneError(Exception):
    """Why nothing can be recorded here."""


def recorded(wait_for_end: Callable[[], object]) -> bytes:
    """A WAV of what is said until `wait_for_end` returns, the first 15 s of it. Raises `MicrophoneError`."""
    device: Any = _device()
    heard = bytearray()
    lock = threading.Lock()

    def keep(chunk: Any, frames: int, time: Any, status: Any) -> None:
        with lock:
            heard.extend(bytes(chunk)[: BYTES_MAX - len(heard)])

    try:
        with device.RawInputStream(samplerate=RATE_HZ, channels=1, dtype="int16", callback=keep):
            wait_for_end()
    except device.PortAudioError as error:
        raise MicrophoneError(f"the microphone: {error}") from error
    with lock:
        return _wav(bytes(heard))


def _device() -> Any:
    try:
        return import_module("sounddevice")
    except ImportError:
        raise MicrophoneError(
            "sounddevice is not installed: pip install 'atom-cli[listen]', or give a --file"
        ) from None
    except OSError as error:  # it looks for the library as it is imported
        raise MicrophoneError(f"{error} (Debian: apt-get install libportaudio2)") from error


def _wav(pcm: bytes) -> bytes:
    file = io.BytesIO()
    with wave.open(file, "wb") as out:
        out.setnchannels(1)
        out.setsampwidth(2)
        out.setframerate(RATE_HZ)
        out.writeframes(pcm)
    return file.getvalue()
