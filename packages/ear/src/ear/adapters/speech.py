"""speech over HTTP and a socket: what is said, and a voice for what is answered."""

import contextlib
import io
import wave
from collections.abc import AsyncGenerator, AsyncIterator, Sequence
from typing import Final
from urllib.parse import urlencode

import httpx
from pydantic import ValidationError
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, WebSocketException

from contracts.speech import Hearing, SpeakRequest, Transcript
from ear.ports import RATE_HZ
from ear.settings import Settings
from mesh.errors import UnavailableError, UpstreamError
from mesh.http import ServiceClient, bearer

OPEN_S: Final = 2.0
HOT_WORDS_MAX: Final = 24
"""Of 40 letters each, so that a request line stays under 8 kB."""


class SpeechSocket:
    """The port `Ears`, for real: WS /listen."""

    def __init__(self, socket: ClientConnection) -> None:
        self._socket = socket

    async def send(self, samples: bytes) -> None:
        await self._send(samples)

    async def end(self) -> None:
        await self._send("")

    async def _send(self, message: str | bytes) -> None:
        """What is said after the last reading is nobody's loss: why it closed is told by `hearings`."""
        with contextlib.suppress(ConnectionClosed):
            await self._socket.send(message)

    async def hearings(self) -> AsyncIterator[Hearing]:
        try:
            async for message in self._socket:
                yield Hearing.model_validate_json(message)
        except ConnectionClosed as error:
            why = error.rcvd.reason if error.rcvd is not None and error.rcvd.reason else "the line to it broke"
            raise UnavailableError("speech", why) from error
        except ValidationError as error:
            raise UpstreamError("speech", 200, "the answer is not the contract") from error


class SpeechClient(ServiceClient):
    """The port `Speech`, for real."""

    def __init__(self, settings: Settings, *, transport: httpx.AsyncBaseTransport | None = None) -> None:
        base_url, key = settings.speech_url, settings.own_key
        super().__init__("speech", base_url, key=key, timeout_s=settings.call_timeout_s, transport=transport)
        self._listen_url = f"ws{base_url.removeprefix('http')}/listen"
        self._says_who = bearer(key)
        self._speak_timeout_s = settings.speak_timeout_s

    @contextlib.asynccontextmanager
    async def listen(self, hot_words: Sequence[str]) -> AsyncGenerator[SpeechSocket]:
        query = urlencode([("hot_words", one) for one in hot_words[:HOT_WORDS_MAX]])
        try:
            socket = await connect(
                f"{self._listen_url}?{query}",
                additional_headers=self._says_who,
                open_timeout=OPEN_S,
                close_timeout=1.0,
                proxy=None,
            )
        except (OSError, TimeoutError, WebSocketException) as error:
            raise UnavailableError("speech", "not reachable") from error
        try:
            yield SpeechSocket(socket)
        finally:
            await socket.close()

    async def transcribe(self, samples: bytes) -> Transcript:
        return await self.post("/transcribe", _wav(samples), Transcript)

    async def speak(self, request: SpeakRequest) -> bytes:
        return (await self.call("POST", "/speak", body=request, timeout_s=self._speak_timeout_s)).content


def _wav(samples: bytes) -> bytes:
    file = io.BytesIO()
    with wave.open(file, "wb") as out:
        out.setnchannels(1)
        out.setsampwidth(2)
        out.setframerate(RATE_HZ)
        out.writeframes(samples)
    return file.getvalue()
