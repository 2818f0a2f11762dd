"""Language and vision-language models behind OpenAI's chat format: llama.cpp, vLLM, LM Studio."""

import base64
from typing import Any

import httpx
from pydantic import BaseModel, Field, ValidationError

from inference.ports import CONNECT_TIMEOUT_S, Prompt
from mesh.errors import ServiceTimeoutError, UnavailableError, UpstreamError

SERVICE = "openai"
REFUSED_FORMAT = frozenset((400, 422, 500, 501))


class _Message(BaseModel):
    content: str | None = None


class _Choice(BaseModel):
    message: _Message


class _Completion(BaseModel):
    choices: list[_Choice] = Field(min_length=1)


class _Error(BaseModel):
    message: str


class _Trouble(BaseModel):
    error: _Error


class OpenAiModel:
    """One model of one server. `base_url` ends before '/chat/completions', usually in '/v1'.

    Servers name the constrained format differently: 'json_schema' is tried first, then llama-cpp-python's 'json_object'
    with a schema; the one that was not refused is kept.
    """

    backend = "openai"

    def __init__(self, base_url: str, model: str, *, timeout_s: float, api_key: str = "") -> None:
        self._model = model
        self._named_format = True
        self._http = httpx.AsyncClient(
            base_url=base_url.rstrip("/") + "/",
            timeout=httpx.Timeout(timeout_s, connect=CONNECT_TIMEOUT_S),
            headers={"authorization": f"Bearer {api_key}"} if api_key else {},
            trust_env=False,
        )
        self.name = f"{self.backend}:{model}"

    async def complete(self, prompt: Prompt) -> str:
        response = await self._post(prompt)
        if response.status_code in REFUSED_FORMAT and self._named_format:
            self._named_format = False
            second = await self._post(prompt)
            self._named_format = not second.is_success
            response = second if second.is_success else response
        if not response.is_success:
            raise UpstreamError(SERVICE, response.status_code, _told(response))
        try:
            completion = _Completion.model_validate_json(response.content)
        except ValidationError as error:
            raise UpstreamError(SERVICE, response.status_code, "the answer is not OpenAI's wire format") from error
        return completion.choices[0].message.content or ""

    async def aclose(self) -> None:
        await self._http.aclose()

    async def _post(self, prompt: Prompt) -> httpx.Response:
        body = {
            "model": self._model,
            "messages": [{"role": "system", "content": prompt.system}, {"role": "user", "content": _content(prompt)}],
            "temperature": prompt.temperature,
            "max_tokens": prompt.answer_tokens_max,
            "response_format": self._format(prompt),
        }
        try:
            return await self._http.post("chat/completions", json=body)
        except httpx.TimeoutException as error:
            raise ServiceTimeoutError(SERVICE, f"{self._model} did not answer in time") from error
        except httpx.HTTPError as error:
            raise UnavailableError(SERVICE, f"not reachable ({type(error).__name__})") from error

    def _format(self, prompt: Prompt) -> dict[str, Any]:
        schema = dict(prompt.schema)
        if self._named_format:
            return {"type": "json_schema", "json_schema": {"name": "answer", "strict": True, "schema": schema}}
        return {"type": "json_object", "schema": schema}


def _content(prompt: Prompt) -> str | list[dict[str, Any]]:
    if not prompt.images:
        return prompt.question
    pictures = [
        {"type": "image_url", "image_url": {"url": f"data:image/jpeg;base64,{base64.b64encode(one).decode()}"}}
        for one in prompt.images
    ]
    return [{"type": "text", "text": prompt.question}, *pictures]


def _told(response: httpx.Response) -> str:
    """What the server gave as its reason, in few words."""
    try:
        return _Trouble.model_validate_json(response.content).error.message[:200]
    except ValidationError:
        return f"HTTP {response.status_code}"
