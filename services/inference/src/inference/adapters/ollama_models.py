"""Language and vision-language models served by Ollama."""

from typing import Any

import httpx
import ollama

from inference.ports import CONNECT_TIMEOUT_S, Prompt
from mesh.errors import ServiceTimeoutError, UnavailableError, UpstreamError

SERVICE = "ollama"


class OllamaModel:
    """One model of one Ollama server, its answers constrained to the schema by the server's own decoder."""

    backend = "ollama"

    def __init__(self, url: str, model: str, *, timeout_s: float) -> None:
        self._model = model
        # typed loosely: the client's own annotations are incomplete
        self._client: Any = ollama.AsyncClient(
            host=url, timeout=httpx.Timeout(timeout_s, connect=CONNECT_TIMEOUT_S), trust_env=False
        )
        self.name = f"{self.backend}:{model}"

    async def complete(self, prompt: Prompt) -> str:
        user: dict[str, Any] = {"role": "user", "content": prompt.question}
        if prompt.images:
            user["images"] = list(prompt.images)
        try:
            reply = await self._client.chat(
                self._model,
                messages=[{"role": "system", "content": prompt.system}, user],
                format=dict(prompt.schema),
                options={"temperature": prompt.temperature, "num_predict": prompt.answer_tokens_max},
                keep_alive="10m",
            )
        except ollama.ResponseError as error:
            raise UpstreamError(SERVICE, error.status_code, error.error) from error
        except httpx.TimeoutException as error:
            raise ServiceTimeoutError(SERVICE, f"{self._model} did not answer in time") from error
        except (httpx.HTTPError, ConnectionError) as error:
            raise UnavailableError(SERVICE, f"not reachable ({type(error).__name__})") from error
        except ValueError as error:  # a body that is not JSON, or not a chat reply
            raise UpstreamError(SERVICE, 200, "the answer is not Ollama's wire format") from error
        return str(reply.message.content or "")

    async def aclose(self) -> None:
        await self._client.close()
