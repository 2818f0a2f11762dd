"""A consumer's client on a line that notes what it asks and is answered, or that plays the committed answers."""

import asyncio
import base64
import contextlib
import json
from collections.abc import AsyncGenerator, Awaitable, Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, Final, TypeVar

import httpx
from api_consumers import Example

from bench.world.wire import Served, Socket, Wire, open_socket

T = TypeVar("T")

IDS: Final = ("id", "session_id", "validation_id")
"""Fields whose values later requests name."""
SOCKET: Final = "SOCKET"
"""For a method: a WebSocket is opened, and its greeting is the answer."""
SAID: Final = ("x-stamp-s", "x-pose", "x-width", "x-height")
"""Headers of an answer that are part of it."""


def body_of(content: bytes, kind: str) -> dict[str, Any]:
    """A body as it is written into an example."""
    if not content:
        return {}
    if "json" in kind and "ndjson" not in kind:
        return {"type": kind, "json": json.loads(content)}
    if kind.startswith(("image/", "audio/")):
        return {"type": kind, "base64": base64.b64encode(content).decode()}
    return {"type": kind, "text": content.decode()}


def bytes_of(body: dict[str, Any]) -> bytes:
    if "json" in body:
        return json.dumps(body["json"]).encode()
    return base64.b64decode(body["base64"]) if "base64" in body else body.get("text", "").encode()


def request_of(request: httpx.Request) -> dict[str, Any]:
    asked = {"method": request.method, "path": request.url.path, "query": dict(request.url.params)}
    return asked | {"body": body_of(request.content, request.headers.get("content-type", ""))}


def answer_of(response: httpx.Response) -> dict[str, Any]:
    headers = {name: response.headers[name] for name in SAID if name in response.headers}
    kind = response.headers.get("content-type", "")
    return {"status": response.status_code, "headers": headers, "body": body_of(response.content, kind)}


class Line(httpx.AsyncBaseTransport):
    """What a client is given for a transport, and what it asks by name."""

    def __init__(self) -> None:
        self.call = ""
        self.exchanged: list[dict[str, Any]] = []

    async def ask(self, call: Awaitable[T]) -> T:
        self.call = call.__name__  # type: ignore[attr-defined]
        return await call

    async def ask_in_thread(self, call: Callable[..., T], *args: Any, **more: Any) -> T:
        self.call = call.__name__
        return await asyncio.to_thread(call, *args, **more)

    def note(self, request: dict[str, Any], answer: dict[str, Any]) -> None:
        self.exchanged.append({"call": self.call, "request": request, "answer": answer})

    @contextlib.asynccontextmanager
    async def socket(self, address: str) -> AsyncGenerator[Any]:
        """Opens a WebSocket; what the provider says first is an answer like another."""
        raise NotImplementedError
        yield


async def asked(provider: Served, request: dict[str, Any], *, until: contextlib.AsyncExitStack) -> dict[str, Any]:
    """The answer to a request as an example holds it; a socket stays open `until` then."""
    url = httpx.URL(f"http://{provider.name}{request['path']}", params=request["query"])
    if request["method"] == SOCKET:
        socket = await until.enter_async_context(open_socket(provider, str(url.copy_with(scheme="ws"))))
        return _greeting(await socket.recv())
    body = request["body"]
    headers = {"content-type": body["type"]} if body else {}
    asking = httpx.Request(request["method"], url, headers=headers, content=bytes_of(body))
    return answer_of(await Wire("example", provider).handle_async_request(asking))


class Recorded(Line):
    """To the running provider."""

    def __init__(self, consumer: str, provider: Served) -> None:
        super().__init__()
        self._provider = provider
        self._wire = Wire(consumer, provider)

    async def handle_async_request(self, request: httpx.Request) -> httpx.Response:
        response = await self._wire.handle_async_request(request)
        self.note(request_of(request), answer_of(response))
        return response

    @contextlib.asynccontextmanager
    async def socket(self, address: str) -> AsyncGenerator[Any]:
        async with open_socket(self._provider, address) as socket:
            greeting = await socket.recv()
            socket.inbox.put_nowait({"type": "websocket.receive", "text": greeting})
            self.call = "hold_session"
            self.note(_opening(address), _greeting(greeting))
            yield socket


class Played(Line):
    """To the committed examples: answers each request with its own, and notes what was asked instead of it."""

    def __init__(self, played: list[Example]) -> None:
        super().__init__()
        self._left = iter(played)

    async def handle_async_request(self, request: httpx.Request) -> httpx.Response:
        example = next(self._left)
        self.note(request_of(request), example.answer)
        body = example.answer["body"]
        headers = example.answer["headers"] | ({"content-type": body["type"]} if body else {})
        return httpx.Response(example.answer["status"], headers=headers, content=bytes_of(body), request=request)

    @contextlib.asynccontextmanager
    async def socket(self, address: str) -> AsyncGenerator[Any]:
        example = next(self._left)
        self.call = "hold_session"
        self.note(_opening(address), example.answer)
        socket = Socket()
        socket.inbox.put_nowait({"type": "websocket.receive", "text": json.dumps(example.answer["body"]["json"])})
        yield socket


class InThread(httpx.BaseTransport):
    """A line for a client that does not know asyncio."""

    def __init__(self, line: Line) -> None:
        self._line = line
        self._loop = asyncio.get_running_loop()

    def handle_request(self, request: httpx.Request) -> httpx.Response:
        request.read()
        response = asyncio.run_coroutine_threadsafe(self._line.handle_async_request(request), self._loop).result()
        return httpx.Response(response.status_code, headers=response.headers, content=response.content)


def _opening(address: str) -> dict[str, Any]:
    url = httpx.URL(address)
    return {"method": SOCKET, "path": url.path, "query": dict(url.params), "body": {}}


def _greeting(text: str) -> dict[str, Any]:
    return {"status": 101, "headers": {}, "body": body_of(text.encode(), "application/json")}


@dataclass
class Ids:
    """What the ids of the committed answers are called today."""

    today: dict[str, str] = field(default_factory=dict[str, str])

    def learn(self, committed: Any, answered: Any) -> None:
        match committed, answered:
            case dict(), dict():
                for key in committed.keys() & answered.keys():
                    if key in IDS and isinstance(committed[key], str):
                        self.today[committed[key]] = answered[key]
                    self.learn(committed[key], answered[key])
            case list(), list():
                for one, other in zip(committed, answered, strict=False):
                    self.learn(one, other)
            case _:
                pass

    def put_in(self, request: dict[str, Any]) -> dict[str, Any]:
        text = json.dumps(request)
        for committed, today in self.today.items():
            text = text.replace(committed, today)
        return json.loads(text)


BY_THE_MOMENT = frozenset({"looked_share", "distance_remaining_m", "explored_m2"})
"""Whether these are known yet depends on how fast the machine is: null is as good as a number."""


def lacking(example: Any, answered: Any) -> Iterator[str]:
    """What an example's answer has and another answer has not, or has as something no example shows.

    Nothing matches everything: null is null, an empty list is empty. Where an example holds several things in a list,
    each of an answer's is held to all of them together: one may have no colour only where another had none.
    """
    yield from _unlike([example], answered, "")


def _unlike(shown: list[Any], answered: Any, path: str) -> Iterator[str]:
    match answered:
        case dict():
            like = [one for one in shown if isinstance(one, dict)]
            for key in {key for one in like for key in one if all(key in other for other in like)} - answered.keys():
                yield f"{_field(path, key)} is missing"
            for key, value in answered.items():
                known = [one[key] for one in like if key in one]
                if known and not (key in BY_THE_MOMENT and None in {value, *known}):
                    yield from _unlike(known, value, _field(path, key))
        case list():
            like = [one for one in shown if isinstance(one, list)]
            items = [item for one in like for item in one]
            if like and not answered and all(like):
                yield f"{path} is empty"
            elif like and answered and not items:
                yield f"{path} is not empty"
            for other in answered if items else []:
                yield from _unlike(items, other, f"{path}[]")
        case _:
            like = [one for one in shown if _kind(one) == _kind(answered)]
    if not like:
        yield f"{path} is {_kind(answered)}, not {' or '.join(sorted({_kind(one) for one in shown}))}"


def _field(path: str, key: str) -> str:
    return f"{path}.{key}" if path else key


def _kind(value: Any) -> str:
    """Of JSON, where a whole number is a number."""
    match value:
        case None:
            return "null"
        case bool():
            return "boolean"
        case int() | float():
            return "number"
        case str():
            return "string"
        case list():
            return "list"
        case _:
            return "object"
