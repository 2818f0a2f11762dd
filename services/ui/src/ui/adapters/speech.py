"""speech over HTTP and a socket, with the page's settings."""

import httpx

import mesh.speech
from ui.settings import Settings


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
