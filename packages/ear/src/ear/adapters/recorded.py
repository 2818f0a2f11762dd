"""Sound that comes from elsewhere than a microphone: a WAV file at its own speed, or samples on standard input."""

import asyncio
import sys
import wave
from collections.abc import AsyncIterator
from pathlib import Path

from contracts.speech import RATE_HZ
from ear.ports import CHUNK_BYTES, CHUNK_S, SoundError
from mesh.clock import Clock


class WavFile:
    """The port `Source`: a file as if it were said now."""

    def __init__(self, path: Path, clock: Clock) -> None:
        self._path = path
        self._clock = clock

    async def chunks(self) -> AsyncIterator[bytes]:
        try:
            with wave.open(str(self._path)) as file:
                form = (file.getframerate(), file.getnchannels(), file.getsampwidth())
                if form != (RATE_HZ, 1, 2):
                    raise SoundError(f"{self._path}: {form[0]} Hz, {form[1]} channels; taken are 16-bit 16000 Hz, one")
                begun_s, told = self._clock.now_s(), 0
                while chunk := file.readframes(CHUNK_BYTES // 2):
                    told += 1
                    await self._clock.sleep(max(0.0, begun_s + told * CHUNK_S - self._clock.now_s()))
                    yield chunk.ljust(CHUNK_BYTES, b"\0")
        except (OSError, EOFError, wave.Error) as error:
            raise SoundError(f"{self._path}: {error}") from error


class StandardInput:
    """The port `Source`: `arecord -q -f S16_LE -r 16000 -c 1 -t raw | atom-ear`."""

    async def chunks(self) -> AsyncIterator[bytes]:
        reader = asyncio.StreamReader(limit=2**16)
        loop = asyncio.get_running_loop()
        try:
            transport, _ = await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), sys.stdin.buffer)
        except ValueError as error:
            raise SoundError("standard input is a file: name it, EAR_SOUND=said.wav") from error
        try:
            while True:
                yield await reader.readexactly(CHUNK_BYTES)
        except asyncio.IncompleteReadError:
            return
        finally:
            transport.close()
