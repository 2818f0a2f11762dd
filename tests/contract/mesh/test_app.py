"""What every service answers alike: problems, health, readiness, metrics, limits."""

from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager

import httpx
import pytest
from fastapi import FastAPI, Request, WebSocket
from fastapi.responses import StreamingResponse
from fastapi.testclient import TestClient
from pydantic_settings import SettingsConfigDict
from starlette.websockets import WebSocketDisconnect

from contracts.base import Message
from contracts.problem import Dependency, Problem, Readiness
from mesh.access import Role, public, requires_role
from mesh.app import make_app
from mesh.errors import ConflictError, TooManyError
from mesh.http import ServiceClient
from mesh.settings import Port, ServiceSettings


class Word(Message):
    word: str


class Settings(ServiceSettings):
    model_config = SettingsConfigDict(env_prefix="SAMPLE_", frozen=True)

    port: Port = 8000
    origins_allowed: tuple[str, ...] = ("https://robot.lan",)


@asynccontextmanager
async def nothing(app: FastAPI) -> AsyncIterator[None]:
    yield


def make(*, ok: bool = True) -> FastAPI:
    async def dependencies(request: Request) -> Sequence[Dependency]:
        return [Dependency.of("redis", ok=ok, detail="" if ok else "away")]

    app = make_app("sample", lifespan=nothing, dependencies=dependencies, body_bytes_max=1000,
                   settings=Settings(), open_to_pages={"/open"})  # fmt: skip

    @app.post("/echo")
    @requires_role(Role.OPERATOR)
    async def echo(word: Word) -> Word:
        if word.word == "busy":
            raise ConflictError("busy with another word")
        if word.word == "full":
            raise TooManyError("the queue is full")
        if word.word == "broken":
            raise RuntimeError("a secret detail")
        return word

    @app.post("/open")
    @public
    async def stop() -> Word:
        return Word(word="stopped")

    @app.get("/stream")
    @requires_role(Role.OPERATOR)
    async def stream() -> StreamingResponse:
        async def parts() -> AsyncIterator[bytes]:
            yield b"a part"

        return StreamingResponse(parts())

    @app.websocket("/talk")
    @requires_role(Role.OPERATOR)
    async def talk(socket: WebSocket) -> None:
        await socket.accept()
        await socket.send_text("hello")
        await socket.close()

    return app


OWN, FOREIGN = "http://sample", "http://evil.example"


@pytest.mark.parametrize(
    ("origin", "status"),
    [(None, 200), (OWN, 200), ("https://robot.lan", 200), (FOREIGN, 403), ("http://sample:81", 403), ("null", 403)],
)
async def test_what_a_foreign_page_asks_for_is_refused(
    client: httpx.AsyncClient, origin: str | None, status: int
) -> None:
    headers = {"origin": origin} if origin else {}
    answer = await client.post("/echo", json={"word": "drive"}, headers=headers)
    assert answer.status_code == status
    assert (await client.get("/health", headers=headers)).status_code == 200
    assert (await client.post("/open", headers=headers)).status_code == 200


async def test_a_stream_passes_a_proxy_as_it_comes_and_nothing_else_is_said_to(client: httpx.AsyncClient) -> None:
    answers = [await client.get(path) for path in ("/stream", "/health")]
    assert [one.headers.get("x-accel-buffering") for one in answers] == ["no", None]


@pytest.mark.parametrize(
    ("origin", "host", "status"),
    [
        ("http://[::1]:8080", "[::1]:8080", 200),
        ("http://[::1]:8080", "[0:0::1]:8080", 200),
        ("http://[fe80::1]:8080", "[fe80::1%25eth0]:8080", 200),
        ("http://[::1]:8080", "[::2]:8080", 403),
        ("http://robot.local", "robot.local:80", 200),
        ("http://robot.local:80", "robot.local", 200),
        ("https://robot.local:443", "robot.local", 200),
        ("http://robot.local:443", "robot.local", 403),
        ("http://ROBOT.local:8080", "robot.local:8080", 200),
        ("http://robot.local:8080", "Robot.Local:8080", 200),
        ("http://robot.local.:8080", "robot.local:8080", 200),
        ("http://robot.local:8080", "robot.local.:8080", 200),
        ("HTTPS://Robot.lan:443/", "sample", 200),
        ("https://robot.lan:8443", "sample", 403),
        ("http://robot.lan", "sample", 403),
        ("null", "robot.local", 403),
        ("null", "null", 403),
        ("", "robot.local", 403),
        ("file://", "robot.local", 403),
        ("chrome-extension://robot.local", "robot.local", 403),
        ("http://robot.local@evil.example", "robot.local", 403),
        ("http://evil.example@robot.local", "robot.local", 403),
        ("http://robot.local/page", "robot.local", 403),
        ("http://robot.local http://evil.example", "robot.local", 403),
        ("http://robot.local:port", "robot.local", 403),
        ("http://[", "robot.local", 403),
        ("http://robot.local.evil.example", "robot.local", 403),
        ("http://robot.local", "", 403),
    ],
)
async def test_the_same_place_is_the_same_however_it_is_written(
    client: httpx.AsyncClient, origin: str, host: str, status: int
) -> None:
    answer = await client.post("/echo", json={"word": "drive"}, headers={"origin": origin, "host": host})
    assert answer.status_code == status


async def test_a_page_with_two_origins_is_foreign(client: httpx.AsyncClient) -> None:
    headers = [("origin", OWN), ("origin", FOREIGN), ("content-type", "application/json")]
    assert (await client.post("/echo", content='{"word": "drive"}', headers=headers)).status_code == 403


@pytest.mark.parametrize("origin", [None, OWN])
def test_a_socket_opens_for_programs_and_the_own_page(origin: str | None) -> None:
    with (
        TestClient(make(), base_url=OWN) as client,
        client.websocket_connect("ws://sample/talk", headers={"origin": origin} if origin else {}) as socket,
    ):
        assert socket.receive_text() == "hello"


def test_a_socket_does_not_open_for_a_foreign_page() -> None:
    with TestClient(make(), base_url=OWN) as client, pytest.raises(WebSocketDisconnect) as refused:  # noqa: SIM117
        with client.websocket_connect("ws://sample/talk", headers={"origin": FOREIGN}):
            pass
    assert refused.value.code == 1008


@pytest.fixture
async def client() -> AsyncIterator[httpx.AsyncClient]:
    transport = httpx.ASGITransport(make(), raise_app_exceptions=False)
    async with httpx.AsyncClient(transport=transport, base_url="http://sample") as opened:
        yield opened


@pytest.mark.parametrize(
    ("body", "status"),
    [
        (b"{", 422),
        (b'{"word": 1}', 422),
        (b'{"word": "x", "more": 1}', 422),
        (b'{"word": "busy"}', 409),
        (b'{"word": "full"}', 429),
        (b'{"word": "broken"}', 500),
        (b'{"word": "' + b"x" * 2000 + b'"}', 413),
    ],
)
async def test_what_cannot_be_done_is_a_clear_problem(client: httpx.AsyncClient, body: bytes, status: int) -> None:
    answer = await client.post("/echo", content=body, headers={"content-type": "application/json"})
    assert answer.status_code == status
    assert answer.headers["content-type"] == "application/problem+json"
    told = Problem.model_validate_json(answer.content)
    assert told.status == status
    assert "secret" not in answer.text


async def test_a_body_without_a_length_is_limited_too(client: httpx.AsyncClient) -> None:
    async def chunks() -> AsyncIterator[bytes]:
        for _ in range(10):
            yield b"x" * 500

    answer = await client.post("/echo", content=chunks(), headers={"content-type": "application/json"})
    assert answer.status_code == 413


async def test_an_unknown_route_is_a_problem_too(client: httpx.AsyncClient) -> None:
    answer = await client.get("/nowhere")
    assert (answer.status_code, answer.headers["content-type"]) == (404, "application/problem+json")


async def test_ready_names_each_dependency() -> None:
    for ok, status in ((True, 200), (False, 503)):
        async with httpx.AsyncClient(transport=httpx.ASGITransport(make(ok=ok)), base_url="http://sample") as client:
            answer = await client.get("/ready")
            assert answer.status_code == status
            assert Readiness.model_validate_json(answer.content).dependencies[0].name == "redis"
            assert (await client.get("/health")).status_code == 200
            assert "python_info" in (await client.get("/metrics")).text


async def test_the_service_client_speaks_to_such_an_app() -> None:
    client = ServiceClient("sample", "http://sample", transport=httpx.ASGITransport(make()))
    assert await client.post("/echo", Word(word="hello"), Word) == Word(word="hello")
    assert (await client.dependency()).ok
    await client.aclose()


async def test_the_documentation_comes_from_this_process(client: httpx.AsyncClient) -> None:
    page = (await client.get("/docs")).text
    assert "http://" not in page
    assert "https://" not in page
    for asset in ("swagger-ui-bundle.js", "swagger-ui.css"):
        assert asset in page
        assert (await client.get(f"/static-offline-docs/{asset}")).status_code == 200
