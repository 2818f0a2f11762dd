"""speech over HTTP and a socket, with the ear's settings."""

import io
import wave

import httpx

import mesh.speech
from contracts.speech import Transcript
from ear.ports import RATE_HZ
from ear.settings import Settings


class SpeechClient(mesh.speech.SpeechClient):
    """The port `Speech`, for real."""

    def __init__(self, settings: Settings, *, transport: httpx.AsyncBaseTransport | None = None) -> None:
        super().__init__(
            settings.speech_url,
            key=settings.own_key,
            timeout_s=settings.call_timeout_s,
            speak_timeout_s=settings.speak_timeout_s,
            transport=transport,
        )

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
