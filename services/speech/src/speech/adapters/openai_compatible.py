"""A server that speaks OpenAI's `POST /v1/audio/transcriptions`: speaches, LocalAI, vLLM, whisper.cpp's own.

What is said goes there. It leaves the house only where that server does not stand in it.
"""

from collections.abc import Iterator, Sequence
from typing import Final

import httpx
from pydantic import BaseModel, ValidationError

from contracts.speech import RATE_HZ
from mesh.errors import UnavailableError
from speech.ports import Reading
from speech.sound import Samples, to_wav

CHARACTERS_A_TOKEN: Final = 3
"""Its tokens are not known here; names of things take no more of them."""


class _Transcription(BaseModel):
    text: str
    language: str = ""


class OpenAiRecognizer:
    """`url` as far as `/v1`. Each call has `timeout_s`; nothing else is tried in its place."""

    def __init__(
        self,
        url: str,
        model: str,
        *,
        language: str,
        timeout_s: float,
        api_key: str = "",
        transport: httpx.BaseTransport | None = None,
    ) -> None:
        self._url, self._model, self._language = url.rstrip("/"), model, language
        self._http = httpx.Client(
            headers={"authorization": f"Bearer {api_key}"} if api_key else {},
            timeout=timeout_s,
            trust_env=False,
            transport=transport,
        )

    @property
    def name(self) -> str:
        return f"openai {self._model}"

    def load(self) -> None:
        """Any answer will do: not every server lists its models."""
        if not self._url:
            raise UnavailableError("recognizer", "SPEECH_OPENAI_URL is not set")
        self._asked("GET", "/models")

    def tokens_of(self, text: str) -> int:
        return -(-len(text) // CHARACTERS_A_TOKEN)

    def readings(self, samples: Samples, hints: Sequence[str]) -> Iterator[Reading]:
        wav = to_wav(samples, RATE_HZ)
        for hint in hints:
            said = {"model": self._model, "response_format": "json", "temperature": "0"}
            said |= {"language": self._language} if self._language else {}
            said |= {"prompt": hint} if hint else {}
            answer = self._asked(
                "POST", "/audio/transcriptions", data=said, files={"file": ("said.wav", wav, "audio/wav")}
            )
            if not answer.is_success:
                raise UnavailableError("recognizer", f"{self._url}: HTTP {answer.status_code}")
            try:
                read = _Transcription.model_validate_json(answer.content)
            except ValidationError:
                raise UnavailableError("recognizer", f"{self._url}: its answer is no transcription") from None
            yield Reading(read.text.strip(), (self._language or read.language)[:16])

    def _asked(self, method: str, path: str, **more: object) -> httpx.Response:
        try:
            return self._http.request(method, f"{self._url}{path}", **more)  # type: ignore[arg-type]
        except httpx.TimeoutException:
            raise UnavailableError("recognizer", f"{self._url} does not answer in time") from None
        except (httpx.HTTPError, httpx.InvalidURL) as error:
            raise UnavailableError("recognizer", f"{self._url} is not reachable: {error}") from None
