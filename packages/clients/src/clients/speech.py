"""speech, for whoever hears and talks through it: a socket for what is said, and a voice for what is answered."""

import contextlib
import io
import wave
from collections.abc import AsyncGenerator, AsyncIterator, Sequence
from typing import Final, Protocol
from urllib.parse import urlencode

import httpx
from pydantic import SecretStr, ValidationError
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, WebSocketException

from contracts.speech import NOT_HELD, RATE_HZ, Hearing, SpeakRequest, Transcript
from mesh.errors import UnavailableError, UnprocessableError, UpstreamError
from mesh.http import ServiceClient, bearer

OPEN_S: Final = 2.0
QUERY_BYTES_MAX: Final = 6_000
"""Of hot words: a request line of more than 8 kB is refused by the server before anybody reads it."""


def query_of(hot_words: Sequence[str]) -> str:
    """As many of the first as `QUERY_BYTES_MAX` holds: a letter of another script is nine bytes."""
    told = ""
    for one in hot_words:
        longer = f"{told}&{urlencode({'hot_words': one})}".lstrip("&")
        if len(longer) > QUERY_BYTES_MAX:
            break
        told = longer
    return told


class SpeechSocket:
    """The client's end of WS /listen. Sound is 16-bit little-endian PCM, one channel, 16 kHz."""

    def __init__(self, socket: ClientConnection) -> None:
        self._socket = socket

    async def send(self, samples: bytes) -> None:
        await self._send(samples)

    async def not_held(self) -> None:
        """From now on silence ends what is said."""
        await self._send(NOT_HELD)

    async def end(self) -> None:
        """No more sound comes: the last reading is of what came."""
        await self._send("")

    async def _send(self, message: str | bytes) -> None:
        """What is said after the last reading is nobody's loss: why it closed is told by `hearings`."""
        with contextlib.suppress(ConnectionClosed):
            await self._socket.send(message)

    async def hearings(self) -> AsyncIterator[Hearing]:
        """To the end of the saying. Raises `UnavailableError` when the line breaks, `UpstreamError` for no reading."""
        try:
            async for message in self._socket:
                yield Hearing.model_validate_json(message)
        except ConnectionClosed as error:
            why = error.rcvd.reason if error.rcvd is not None and error.rcvd.reason else "the line to it broke"
            raise UnavailableError("speech", why) from error
        except ValidationError as error:
            raise UpstreamError("speech", 200, "the answer is not the contract") from error


class SpeechSettings(Protocol):
    """What a caller says of itself; times in s."""

    @property
    def speech_url(self) -> str: ...
    @property
    def own_key(self) -> SecretStr | None: ...
    @property
    def call_timeout_s(self) -> float:
        """Of what is quick."""
        ...

    @property
    def speak_timeout_s(self) -> float:
        """Of a sentence to be made."""
        ...


class SpeechClient(ServiceClient):
    def __init__(self, settings: SpeechSettings, *, transport: httpx.AsyncBaseTransport | None = None) -> None:
        key = settings.own_key
        super().__init__("speech", settings.speech_url, key=key, timeout_s=settings.call_timeout_s, transport=transport)
        self._listen_url = f"ws{settings.speech_url.removeprefix('http')}/listen"
        self._says_who = bearer(key)
        self._speak_timeout_s = settings.speak_timeout_s

    @contextlib.asynccontextmanager
    async def listen(self, hot_words: Sequence[str], *, held: bool = False) -> AsyncGenerator[SpeechSocket]:
        """`held`: silence does not end it until `not_held`. Raises `UnavailableError`."""
        query = f"held=true&{query_of(hot_words)}" if held else query_of(hot_words)
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

    async def speak(self, request: SpeakRequest) -> bytes:
        """A WAV. Raises `UnprocessableError` for a voice that does not exist and for nothing to say."""
        try:
            return (await self.call("POST", "/speak", body=request, timeout_s=self._speak_timeout_s)).content
        except UpstreamError as error:
            if error.upstream_status in {404, 422}:  # no such voice, nothing to say: a failure of who asked
                raise UnprocessableError(error.said, code=error.code) from error
            raise

    async def transcribe(self, samples: bytes) -> Transcript:
        """`samples`: 16-bit little-endian PCM, one channel, `RATE_HZ`."""
        return await self.post("/transcribe", _wav(samples), Transcript)


def _wav(samples: bytes) -> bytes:
    file = io.BytesIO()
    with wave.open(file, "wb") as out:
        out.setnchannels(1)
        out.setsampwidth(2)
        out.setframerate(RATE_HZ)
        out.writeframes(samples)
    return file.getvalue()
