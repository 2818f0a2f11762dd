"""One open microphone: samples in, readings out, until the speaker is done or gone."""

import asyncio
import contextlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Final

from fastapi import WebSocket, WebSocketDisconnect
from pydantic import Field, TypeAdapter, ValidationError

from contracts.speech import HOT_WORDS_MAX, NOT_HELD, RATE_HZ, Hearing, HotWord, SpeechRefusal, Transcript
from mesh.errors import MeshError, TooManyError
from speech.end_of_speech import ALLOWED, WINDOW_SAMPLES, Listening, due, paused
from speech.sound import DURATION_S_MAX, DURATION_S_MIN, SoundError, from_pcm, samples_of
from speech.speech_service import SpeechService

CHUNK_BYTES_MAX: Final = 64_000
"""Two seconds: a microphone sends less, a file should be POSTed."""
WINDOW_BYTES: Final = 2 * WINDOW_SAMPLES
LOOK_WINDOWS: Final = 2
"""Voice activity looks at each 64 ms as they come,"""
BEFORE_BYTES: Final = 16 * WINDOW_BYTES
"""with half a second before them: it judges by what it has heard."""
LEAD_S: Final = 0.4
"""Read from so long before speech was noticed: a first consonant is quiet."""
BYTES_MAX: Final = int(DURATION_S_MAX * RATE_HZ) * 2
BYTES_MIN: Final = int(DURATION_S_MIN * RATE_HZ) * 2
SILENT_CLIENT_S: Final = 5.0
SOCKET_S_MAX: Final = 60.0
"""Four times what is listened to: one that drips sound does not hold its place for ever."""
_HOT_WORDS: Final = TypeAdapter(Annotated[list[HotWord], Field(max_length=HOT_WORDS_MAX)])


async def listen(socket: WebSocket, speech: SpeechService, hot_words: Sequence[str], *, held: bool) -> None:
    """`hot_words` as the client sent them: looked at only here, where a refusal can say why. `held`: a button is, and
    its holder says when it is let go.
    """
    await socket.accept()
    try:
        names = _HOT_WORDS.validate_python(hot_words)
    except ValidationError:
        await socket.close(1008, SpeechRefusal.HOT_WORDS)
        return
    try:
        with speech.listener():
            await _listen(socket, speech, names, held=held)
    except WebSocketDisconnect:
        return
    except TooManyError:
        await socket.close(1013, SpeechRefusal.BUSY)
    except SoundError as error:
        await socket.close(1003, error.refusal)
    except MeshError as error:
        await socket.close(1011, error.detail[:100])


async def _listen(socket: WebSocket, speech: SpeechService, names: Sequence[str], *, held: bool) -> None:
    loop = asyncio.get_running_loop()
    until_s = loop.time() + SOCKET_S_MAX
    teller = _Teller(socket, speech)
    heard, looked, read_s = bytearray(), 0, None
    listening = Listening()
    reading: asyncio.Task[None] | None = None
    try:
        while ALLOWED[listening.turn] and len(heard) < BYTES_MAX:
            chunk = await _chunk(socket, min(SILENT_CLIENT_S, until_s - loop.time()))
            if chunk is None:
                held = False
                continue
            if not chunk:
                break
            heard += chunk
            fresh = (len(heard) - looked) // WINDOW_BYTES
            if fresh >= LOOK_WINDOWS:
                before, looked = max(0, looked - BEFORE_BYTES), looked + fresh * WINDOW_BYTES
                listening = await speech.turn_of(listening, samples_of(heard[before:looked]), fresh, held=held)
            idle = speech.idle and (reading is None or reading.done())
            if idle and due(listening, read_s, speech.settings.partial_period_s):
                read_s = listening.heard_s
                await _over(reading)
                reading = asyncio.ensure_future(
                    teller.tell_partially(_said(heard, listening), paused=paused(listening))
                )
    finally:
        await _over(reading)
    await teller.tell(await speech.transcribe(from_pcm(_said(heard, listening)), names), final=True)
    await socket.close()


async def _over(reading: asyncio.Task[None] | None) -> None:
    """A partial reading that failed is nobody's loss: the next one, or the final one, says why."""
    if reading is not None:
        with contextlib.suppress(WebSocketDisconnect, RuntimeError, MeshError):
            await reading


def _said(heard: bytearray, listening: Listening) -> bytes:
    """From a little before speech began; long enough to be read."""
    begun_s = max(0.0, (listening.begun_s or 0.0) - LEAD_S)
    return bytes(heard[round(begun_s * RATE_HZ) * 2 : BYTES_MAX]).ljust(BYTES_MIN, b"\0")


@dataclass
class _Teller:
    """Sends readings, and remembers that one of them was an order to stop."""

    socket: WebSocket
    speech: SpeechService
    stop: bool = False

    async def tell_partially(self, heard: bytes, *, paused: bool) -> None:
        """In the middle of a word a reading that leans towards a stop would make one of "pop music"."""
        partial = await self.speech.read_partially(from_pcm(heard), look_for_stop=paused and not self.stop)
        await self.tell(partial, final=False)

    async def tell(self, transcript: Transcript, *, final: bool) -> None:
        self.stop = self.stop or transcript.stop
        await self.socket.send_text(Hearing(final=final, stop=self.stop, transcript=transcript).model_dump_json())


async def _chunk(socket: WebSocket, timeout_s: float) -> bytes | None:
    """Empty where the client says, or shows by its silence, that nothing more comes; none where it says that silence
    ends it from now on.
    """
    try:
        message = await asyncio.wait_for(socket.receive(), timeout_s)
    except TimeoutError:
        return b""
    if message["type"] == "websocket.disconnect":
        raise WebSocketDisconnect
    chunk: bytes = message.get("bytes") or b""
    if message.get("text") == NOT_HELD:
        return None
    if message.get("text"):
        raise SoundError(SpeechRefusal.NOT_WAV, "raw samples are sent as binary messages")
    if len(chunk) > CHUNK_BYTES_MAX:
        raise SoundError(SpeechRefusal.TOO_LONG, "a message of more than two seconds")
    if len(chunk) % 2:
        raise SoundError(SpeechRefusal.TRUNCATED, "it ends in the middle of a sample")
    return chunk
