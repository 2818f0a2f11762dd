"""Language and vision-language models behind OpenAI's chat format: llama.cpp, vLLM, LM Studio."""

import base64
import json
from typing import Any, NamedTuple

import httpx
from pydantic import BaseModel, ValidationError

from inference.ports import CONNECT_TIMEOUT_S, THINKING_TOKENS_MAX, Completion, Ending, Prompt
from mesh.errors import ServiceTimeoutError, UnavailableError, UpstreamError

SERVICE = "openai"
REFUSED_FORM = frozenset((400, 422, 500, 501))
ENDINGS = {"length": Ending.CUT_OFF, "content_filter": Ending.REFUSED}


class _Form(NamedTuple):
    """How a request is put: what the format of the answer is called, and whether thinking is to be left out."""

    named_format: bool
    no_thinking: bool


FORMS = (_Form(named_format=True, no_thinking=True), _Form(True, False), _Form(False, False))
"""`chat_template_kwargs` is known to llama.cpp and vLLM, and strict servers refuse it; llama-cpp-python knows
'json_object' with a schema alone."""


TEXT_PARTS = frozenset(("text", "output_text"))
"""Other parts of a message are thoughts, or pictures."""


class _Part(BaseModel):
    type: str = "text"
    text: str = ""

    def words(self) -> str:
        return self.text if self.type in TEXT_PARTS else ""


class _Function(BaseModel):
    arguments: str | dict[str, Any] = ""

    def fields(self) -> str:
        return self.arguments if isinstance(self.arguments, str) else json.dumps(self.arguments)


class _ToolCall(BaseModel):
    function: _Function = _Function()


class _Message(BaseModel):
    """`reasoning_content` is llama.cpp's, vLLM's and DeepSeek's name for thoughts, `reasoning` that of others."""

    content: str | list[_Part | str] | dict[str, Any] | None = None
    reasoning_content: str | None = None
    reasoning: str | None = None
    refusal: str | None = None
    tool_calls: list[_ToolCall] | None = None
    function_call: _Function | None = None

    def words(self) -> str:
        """The text, its parts put together, or the fields of the tool call made in its place."""
        if isinstance(self.content, dict):
            text = json.dumps(self.content)
        elif isinstance(self.content, list):
            text = "".join(one if isinstance(one, str) else one.words() for one in self.content)
        else:
            text = self.content or ""
        called = [one.function for one in self.tool_calls or ()] + ([self.function_call] if self.function_call else [])
        return called[0].fields() if called and not text.strip() else text


class _Choice(BaseModel):
    message: _Message
    finish_reason: str | None = None

    def completion(self) -> Completion:
        message = self.message
        thoughts = message.reasoning_content or message.reasoning or ""
        if message.refusal:
            return Completion(message.refusal, thoughts, Ending.REFUSED)
        return Completion(message.words(), thoughts, ENDINGS.get(self.finish_reason or "", Ending.WHOLE))


class _Completion(BaseModel):
    choices: list[_Choice]

    def first(self) -> Completion:
        return self.choices[0].completion() if self.choices else Completion("")


class _Error(BaseModel):
    message: str


class _Trouble(BaseModel):
    error: _Error | str

    def told(self) -> str:
        return (self.error if isinstance(self.error, str) else self.error.message)[:200]


class OpenAiModel:
    """One model of one server. `base_url` ends before '/chat/completions', usually in '/v1'.

    Servers know different fields: the forms of a request are tried in their order, and the one that was not refused is
    kept. A model that thinks aloud all the same gets room for its thoughts.
    """

    backend = "openai"

    def __init__(self, base_url: str, model: str, *, timeout_s: float, api_key: str = "") -> None:
        self._model = model
        self._form = 0
        self._thinks = False
        self._http = httpx.AsyncClient(
            base_url=base_url.rstrip("/") + "/",
            timeout=httpx.Timeout(timeout_s, connect=CONNECT_TIMEOUT_S),
            headers={"authorization": f"Bearer {api_key}"} if api_key else {},
            trust_env=False,
        )
        self.name = f"{self.backend}:{model}"

    async def complete(self, prompt: Prompt) -> Completion:
        response = await self._post(prompt, FORMS[self._form])
        refused = response
        for form in range(self._form + 1, len(FORMS)):
            if response.status_code not in REFUSED_FORM:
                break
            response = await self._post(prompt, FORMS[form])
            self._form = form if response.is_success else self._form
        response = response if response.is_success else refused
        if not response.is_success:
            raise UpstreamError(SERVICE, response.status_code, _told(response) or f"HTTP {response.status_code}")
        try:
            completion = _Completion.model_validate_json(response.content).first()
        except ValidationError as error:
            detail = _told(response) or "the answer is not OpenAI's wire format"
            raise UpstreamError(SERVICE, response.status_code, detail) from error
        self._thinks = self._thinks or bool(completion.thoughts)
        return completion

    async def aclose(self) -> None:
        await self._http.aclose()

    async def _post(self, prompt: Prompt, form: _Form) -> httpx.Response:
        body: dict[str, Any] = {
            "model": self._model,
            "messages": [{"role": "system", "content": prompt.system}, {"role": "user", "content": _content(prompt)}],
            "temperature": prompt.temperature,
            "max_tokens": prompt.answer_tokens_max + self._thinks * THINKING_TOKENS_MAX,
            "response_format": _format(prompt, form),
        }
        if form.no_thinking:
            body["chat_template_kwargs"] = {"enable_thinking": False}
        try:
            return await self._http.post("chat/completions", json=body)
        except httpx.TimeoutException as error:
            raise ServiceTimeoutError(SERVICE, f"{self._model} did not answer in time") from error
        except httpx.HTTPError as error:
            raise UnavailableError(SERVICE, f"not reachable ({type(error).__name__})") from error


def _format(prompt: Prompt, form: _Form) -> dict[str, Any]:
    schema = dict(prompt.schema)
    if form.named_format:
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
    """What the server gave as its reason, in few words; empty where it gave none."""
    try:
        return _Trouble.model_validate_json(response.content).told()
    except ValidationError:
        return ""
