"""Language and vision-language models served by Ollama."""

import json
from typing import Any

from clients.ollama_server import OllamaServer, RefusedError
from inference.ports import THINKING_TOKENS_MAX, Completion, Ending, Prompt


class OllamaModel:
    """One model of one Ollama server, its answers constrained to the schema by the server's own decoder.

    It is told not to think; a server that refuses that word is asked without it from then on, and a model that thinks
    all the same gets room for its thoughts.
    """

    backend = "ollama"

    def __init__(self, url: str, model: str, *, timeout_s: float) -> None:
        self._says_think = True
        self._thinks = False
        self._server = OllamaServer(url, model, timeout_s=timeout_s)
        self.name = f"{self.backend}:{model}"

    async def complete(self, prompt: Prompt) -> Completion:
        reply = await self._chat(prompt)
        thoughts = str(reply.message.thinking or "")
        self._thinks = self._thinks or bool(thoughts)
        ending = Ending.CUT_OFF if reply.done_reason == "length" else Ending.WHOLE
        return Completion(_text(reply.message), thoughts, ending)

    async def aclose(self) -> None:
        await self._server.aclose()

    async def _chat(self, prompt: Prompt) -> Any:
        try:
            return await self._asked(prompt, think=False if self._says_think else None)
        except RefusedError:
            if not self._says_think:
                raise
        reply = await self._asked(prompt, think=None)
        self._says_think = False
        return reply

    async def _asked(self, prompt: Prompt, *, think: bool | None) -> Any:
        user: dict[str, Any] = {"role": "user", "content": prompt.question}
        if prompt.images:
            user["images"] = list(prompt.images)
        tokens_max = prompt.answer_tokens_max + self._thinks * THINKING_TOKENS_MAX
        return await self._server.chat(
            [{"role": "system", "content": prompt.system}, user],
            think=think,
            format=dict(prompt.schema),
            options={"temperature": prompt.temperature, "num_predict": tokens_max},
        )


def _text(message: Any) -> str:
    """The words, or the fields of the tool call made in their place."""
    text = str(message.content or "")
    calls = message.tool_calls or ()
    return json.dumps(dict(calls[0].function.arguments)) if calls and not text.strip() else text
