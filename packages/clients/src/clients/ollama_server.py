"""A model of an Ollama server, whatever answers at its address: a bounded answer, or one of the mesh's errors."""

from collections.abc import AsyncIterator, Sequence
from typing import Any, Final, cast

import httpx
import ollama

from mesh.errors import ServiceTimeoutError, UnavailableError, UpstreamError

SERVICE: Final = "ollama"
CONNECT_S: Final = 3.0
ANSWER_BYTES_MAX: Final = 200_000
DETAIL_LETTERS_MAX: Final = 200
BAD_REQUEST: Final = 400
KEPT_LOADED: Final = "10m"


class RefusedError(UpstreamError):
    """The server does not know something of what it was asked with: an older server, or a model without it (400)."""


class OllamaServer:
    """No redirect is followed: it would carry the question, pictures too, to wherever the server says, and as a POST
    of the mesh's own to the services beside it.
    """

    def __init__(self, url: str, model: str, *, timeout_s: float) -> None:
        self._model = model
        # typed loosely: the client's own annotations are incomplete
        self._client: Any = ollama.AsyncClient(
            host=url,
            follow_redirects=False,
            timeout=httpx.Timeout(timeout_s, connect=CONNECT_S),
            headers={"Accept-Encoding": "identity"},
            trust_env=False,
            transport=BoundedTransport(),
        )

    async def chat(self, messages: Sequence[dict[str, Any]], *, options: dict[str, Any], **how: Any) -> Any:
        """Ollama's own reply. Raises `RefusedError`, `UpstreamError`, `UnavailableError`, `ServiceTimeoutError`.

        The client library reads what it did not write with few checks (an error that is no object, a reply that is a
        list): whatever it stumbles over is an answer that is not Ollama's.
        """
        try:
            return await self._client.chat(
                self._model, messages=list(messages), options=options, keep_alive=KEPT_LOADED, **how
            )
        except ollama.ResponseError as error:
            kind = RefusedError if error.status_code == BAD_REQUEST else UpstreamError
            raise kind(SERVICE, error.status_code, str(error.error)[:DETAIL_LETTERS_MAX]) from error
        except httpx.TimeoutException as error:
            raise ServiceTimeoutError(SERVICE, f"{self._model} did not answer in time") from error
        except (httpx.HTTPError, ConnectionError) as error:
            raise UnavailableError(SERVICE, f"not reachable ({type(error).__name__})") from error
        except Exception as error:
            raise UpstreamError(SERVICE, 200, "the answer is not Ollama's wire format") from error

    async def aclose(self) -> None:
        await self._client.close()


class BoundedTransport(httpx.AsyncHTTPTransport):
    """Of an answer no more than `ANSWER_BYTES_MAX` bytes are read, and of a compressed one, which nobody asked for,
    none: `httpx.ReadError`."""

    async def handle_async_request(self, request: httpx.Request) -> httpx.Response:
        response = await super().handle_async_request(request)
        encoding = response.headers.get("content-encoding", "identity")
        if encoding.strip().lower() != "identity":
            await response.aclose()
            raise httpx.ReadError(f"compressed ({encoding[:20]}), though it was asked for plain")
        response.stream = _Bounded(cast(httpx.AsyncByteStream, response.stream))
        return response


class _Bounded(httpx.AsyncByteStream):
    def __init__(self, stream: httpx.AsyncByteStream) -> None:
        self._stream = stream

    async def __aiter__(self) -> AsyncIterator[bytes]:
        left = ANSWER_BYTES_MAX
        async for chunk in self._stream:
            left -= len(chunk)
            if left < 0:
                raise httpx.ReadError(f"more than {ANSWER_BYTES_MAX} bytes")
            yield chunk

    async def aclose(self) -> None:
        await self._stream.aclose()
