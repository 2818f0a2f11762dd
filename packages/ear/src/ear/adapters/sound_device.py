"""Microphone and loudspeaker of this machine through PortAudio: an extra (`pip install 'atom-ear[device]'`)."""

import asyncio
import io
import threading
import wave
from collections.abc import AsyncIterator
from importlib import import_module
from typing import Any, Final

import structlog

from contracts.speech import RATE_HZ
from ear.ports import CHUNK_BYTES, CHUNK_S, SoundError

log = structlog.get_logger()

WAITING_S_MAX: Final = 4.0
"""A machine that is so far behind leaves out what is oldest."""
SILENT_S_MAX: Final = 10.0
"""A microphone gives samples in silence too: one that gives none is gone."""
PLAYED_AT_A_TIME_S: Final = 0.1


class Microphone:
    """The port `Source`, for real."""

    def __init__(self, name: str = "") -> None:
        self._name = name or None

    async def chunks(self) -> AsyncIterator[bytes]:
        device: Any = _device()
        waiting: asyncio.Queue[bytes] = asyncio.Queue(round(WAITING_S_MAX / CHUNK_S))
        loop = asyncio.get_running_loop()

        def keep(chunk: bytes) -> None:
            if waiting.full():
                waiting.get_nowait()
            waiting.put_nowait(chunk)

        def from_portaudio(chunk: Any, frames: int, time: Any, status: Any) -> None:
            loop.call_soon_threadsafe(keep, bytes(chunk))

        try:
            with device.RawInputStream(
                samplerate=RATE_HZ,
                blocksize=CHUNK_BYTES // 2,
                channels=1,
                dtype="int16",
                device=self._name,
                callback=from_portaudio,
            ):
                while True:
                    async with asyncio.timeout(SILENT_S_MAX):
                        chunk = await waiting.get()
                    yield chunk
        except TimeoutError:
            raise SoundError(f"the microphone gave nothing for {SILENT_S_MAX:.0f} s") from None
        except (device.PortAudioError, ValueError) as error:  # the second for a name that no device has
            raise SoundError(f"the microphone: {error}") from error


class SoundDeviceLoudspeaker:
    """The port `Loudspeaker`, for real."""

    def __init__(self, name: str = "") -> None:
        self._name = name or None

    async def play(self, wav: bytes) -> None:
        ended = threading.Event()
        playing = asyncio.get_running_loop().run_in_executor(None, self._play, wav, ended)
        try:
            await asyncio.shield(playing)
        except asyncio.CancelledError:
            ended.set()
            await asyncio.gather(playing, return_exceptions=True)
            raise

    def _play(self, wav: bytes, ended: threading.Event) -> None:
        try:
            file = wave.open(io.BytesIO(wav))  # noqa: SIM115 - closed below
        except (wave.Error, EOFError) as error:
            raise SoundError(f"what is to be played is no WAV: {error}") from error
        device: Any = _device()
        with file:
            rate_hz, frames = file.getframerate(), round(PLAYED_AT_A_TIME_S * file.getframerate())
            try:
                with device.RawOutputStream(samplerate=rate_hz, channels=1, dtype="int16", device=self._name) as out:
                    while not ended.is_set() and (chunk := file.readframes(frames)):
                        out.write(chunk)
            except (device.PortAudioError, ValueError) as error:
                raise SoundError(f"the loudspeaker: {error}") from error


class NoLoudspeaker:
    """The port `Loudspeaker` where there is none, or it is not wanted."""

    async def play(self, wav: bytes) -> None:
        log.debug("nothing is played here", wav_bytes=len(wav))


def _device() -> Any:
    try:
        return import_module("sounddevice")
    except ImportError:
        raise SoundError("sounddevice is not installed: pip install 'atom-ear[device]'") from None
    except OSError as error:  # it looks for the library as it is imported
        raise SoundError(f"{error} (Debian: apt-get install libportaudio2)") from error
