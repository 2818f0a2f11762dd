"""Wyoming, the protocol of Home Assistant's voices: a recogniser and a voice that run somewhere else in the house.

It has neither encryption nor keys: both ends belong on a network that is trusted.
"""

import asyncio
from collections.abc import AsyncGenerator, AsyncIterator, Awaitable, Iterator, Sequence
from contextlib import asynccontextmanager
from typing import Final, TypeVar
from urllib.parse import urlsplit

import numpy as np
from wyoming.asr import Transcribe, Transcript
from wyoming.audio import AudioChunk, AudioStart, AudioStop
from wyoming.client import AsyncTcpClient
from wyoming.event import Event
from wyoming.info import Describe, Info
from wyoming.tts import Synthesize, SynthesizeVoice

from contracts.speech import RATE_HZ, Voice
from mesh.errors import UnavailableError
from speech.ports import Reading, Spoken
from speech.sound import Samples

T = TypeVar("T")

CHUNK_SAMPLES: Final = 8_000
CHARACTERS_A_TOKEN: Final = 3
FAULTS: Final = (ArithmeticError, AttributeError, EOFError, LookupError, RecursionError, TypeError, ValueError)
"""What comes of an answer that is no Wyoming: the library reads it without looking at it."""
SPOKEN_BYTES_MAX: Final = 12_000_000
"""Two minutes of 48 kHz: no sentence that may be said is as long."""


class _Server:
    """`uri` as tcp://host:port; whatever it is asked has `timeout_s`, all told."""

    def __init__(self, part: str, uri: str, timeout_s: float) -> None:
        self._part, self._uri, self._timeout_s = part, uri, timeout_s

    def ask(self, asking: Awaitable[T]) -> T:
        """Blocks. Raises `UnavailableError`."""

        async def within() -> T:
            async with asyncio.timeout(self._timeout_s):
                return await asking

        try:
            return asyncio.run(within())
        except TimeoutError:
            raise self.away("does not answer in time") from None
        except OSError as error:
            raise self.away(f"is not reachable: {error}") from None
        except FAULTS as error:
            raise self.away(f"does not speak Wyoming: {error!r}") from None

    @asynccontextmanager
    async def connected(self) -> AsyncGenerator[AsyncTcpClient]:
        address = urlsplit(self._uri)
        if address.scheme != "tcp" or not address.hostname or address.port is None:
            raise self.away("is no address of the form tcp://host:port")
        async with AsyncTcpClient(address.hostname, address.port) as client:
            yield client

    async def events(self, client: AsyncTcpClient) -> AsyncIterator[Event]:
        while (event := await client.read_event()) is not None:
            yield event
        raise self.away("hung up before it had answered")

    async def info(self) -> Info:
        async with self.connected() as client:
            await client.write_event(Describe().event())
            async for event in self.events(client):
                if Info.is_type(event.type):
                    return Info.from_event(event)
        raise AssertionError("events end in an error")

    def away(self, why: str) -> UnavailableError:
        return UnavailableError(self._part, f"wyoming {self._uri or '(no address is set)'} {why}")


class WyomingRecognizer:
    def __init__(self, uri: str, *, language: str, timeout_s: float) -> None:
        self._language = language
        self._server = _Server("recognizer", uri, timeout_s)
        self._model = ""

    @property
    def name(self) -> str:
        return f"wyoming {self._model}".strip()

    def load(self) -> None:
        self._model = self._server.ask(self._first())

    async def _first(self) -> str:
        programs = (await self._server.info()).asr
        if not programs:
            raise self._server.away("has no recogniser")
        return programs[0].name[:64]

    def tokens_of(self, text: str) -> int:
        return -(-len(text) // CHARACTERS_A_TOKEN)

    def readings(self, samples: Samples, hints: Sequence[str]) -> Iterator[Reading]:
        """What to expect is sent as its `transcript_names`, which older servers leave unread."""
        pcm = (np.clip(samples, -1.0, 1.0) * 32767).astype("<i2")
        for hint in hints:
            yield self._server.ask(self._read(pcm, hint.split(", ") if hint else None))

    async def _read(self, pcm: np.ndarray, names: list[str] | None) -> Reading:
        form = {"rate": RATE_HZ, "width": 2, "channels": 1}
        async with self._server.connected() as client:
            await client.write_event(Transcribe(language=self._language or None, transcript_names=names).event())
            await client.write_event(AudioStart(**form).event())
            for at in range(0, len(pcm), CHUNK_SAMPLES):
                await client.write_event(AudioChunk(audio=pcm[at : at + CHUNK_SAMPLES].tobytes(), **form).event())
            await client.write_event(AudioStop().event())
            async for event in self._server.events(client):
                if Transcript.is_type(event.type):
                    told = Transcript.from_event(event)
                    return Reading(str(told.text).strip(), str(told.language or self._language)[:16])
        raise AssertionError("events end in an error")


class WyomingSynthesizer:
    """Speaks as fast as its server does: the protocol has no speed."""

    def __init__(self, uri: str, *, timeout_s: float) -> None:
        self._server = _Server("voice", uri, timeout_s)
        self._voices: list[Voice] = []

    @property
    def voices(self) -> Sequence[Voice]:
        return self._voices

    def load(self) -> None:
        self._voices = self._server.ask(self._installed())
        if not self._voices:
            raise self._server.away("has no voice")

    async def _installed(self) -> list[Voice]:
        return [
            Voice(name=voice.name[:64], engine="wyoming", language=(voice.languages or [""])[0][:16])
            for program in (await self._server.info()).tts
            for voice in program.voices
            if voice.installed and voice.name
        ]

    def speak(self, text: str, voice: str, speed: float) -> Spoken:
        return self._server.ask(self._spoken(text, voice))

    async def _spoken(self, text: str, voice: str) -> Spoken:
        heard, rate_hz = bytearray(), RATE_HZ
        async with self._server.connected() as client:
            await client.write_event(Synthesize(text=text, voice=SynthesizeVoice(name=voice)).event())
            async for event in self._server.events(client):
                if AudioStop.is_type(event.type):
                    break
                if AudioChunk.is_type(event.type):
                    chunk = AudioChunk.from_event(event)
                    if (chunk.width, chunk.channels) != (2, 1):
                        raise self._server.away("speaks in something else than 16-bit mono")
                    heard += chunk.audio
                    rate_hz = chunk.rate
                if len(heard) > SPOKEN_BYTES_MAX:
                    raise self._server.away("does not stop speaking")
        samples = np.frombuffer(heard[: len(heard) // 2 * 2], "<i2").astype(np.float32) / np.float32(32768)
        return Spoken(samples, rate_hz)
