"""Language and vision-language models served by Ollama."""

import json
from typing import Any

import httpx
import ollama

from inference.ports import CONNECT_TIMEOUT_S, THINKING_TOKENS_MAX, Completion, Ending, Prompt
from mesh.errors import ServiceTimeoutError, UnavailableError, UpstreamError

SERVICE = "ollama"
REFUSED_FIELD = 400


class OllamaModel:
    """One model of one Ollama server, its answers constrained to the schema by the server's own decoder.

    It is told not to think; a server that refuses that word is asked without it from then on, and a model that thinks
    all the same gets room for its thoughts.
    """

    backend = "ollama"

    def __init__(self, url: str, model: str, *, timeout_s: float) -> None:
        self._model = model
        self._says_think = True
        self._thinks = False
        # typed loosely: the client's own annotations are incomplete
        self._client: Any = ollama.AsyncClient(
            host=url, timeout=httpx.Timeout(timeout_s, connect=CONNECT_TIMEOUT_S), trust_env=False
        )
        self.name = f"{self.backend}:{model}"

    async def complete(self, prompt: Prompt) -> Completion:
        try:
            reply = await self._chat(prompt)
        except ollama.ResponseError as error:
            raise UpstreamError(SERVICE, error.status_code, error.error) from error
        except httpx.TimeoutException as error:
            raise ServiceTimeoutError(SERVICE, f"{self._model} did not answer in time") from error
        except (httpx.HTTPError, ConnectionError) as error:
            raise UnavailableError(SERVICE, f"not reachable ({type(error).__name__})") from error
        except ValueError as error:  # a body that is not JSON, or not a chat reply
            raise UpstreamError(SERVICE, 200, "the answer is not Ollama's wire format") from error
        thoughts = str(reply.message.thinking or "")
        self._thinks = self._thinks or bool(thoughts)
        ending = Ending.CUT_OFF if reply.done_reason == "length" else Ending.WHOLE
        return Completion(_text(reply.message), thoughts, ending)

    async def aclose(self) -> None:
        await self._client.close()

    async def _chat(self, prompt: Prompt) -> Any:
        try:
            return await self._asked(prompt, think=False if self._says_think else None)
        except ollama.ResponseError as error:
            if error.status_code != REFUSED_FIELD or not self._says_think:
                raise
        reply = await self._asked(prompt, think=None)
        self._says_think = False
        return reply

    async def _asked(self, prompt: Prompt, *, think: bool | None) -> Any:
        user: dict[str, Any] = {"role": "user", "content": prompt.question}
        if prompt.images:
            user["images"] = list(prompt.images)
        tokens_max = prompt.answer_tokens_max + self._thinks * THINKING_TOKENS_MAX
        return await self._client.chat(
            self._model,
            messages=[{"role": "system", "content": prompt.system}, user],
            think=think,
            format=dict(prompt.schema),
            options={"temperature": prompt.temperature, "num_predict": tokens_max},
            keep_alive="10m",
        )


def _text(message: Any) -> str:
    """The words, or the fields of the tool call made in their place."""
    text = str(message.content or "")
    calls = message.tool_calls or ()
    return json.dumps(dict(calls[0].function.arguments)) if calls and not text.strip() else text
