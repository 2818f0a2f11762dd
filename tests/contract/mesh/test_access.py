"""Keys, roles and refusals, at a service of three routes and a socket."""

import contextlib
import logging
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager
from pathlib import Path

import httpx
import pytest
from asgi_lifespan import LifespanManager
from fastapi import FastAPI, Request, WebSocket
from fastapi.testclient import TestClient
from pydantic import SecretStr
from pydantic_settings import SettingsConfigDict
from starlette.responses import StreamingResponse
from starlette.testclient import WebSocketDenialResponse
from starlette.websockets import WebSocketDisconnect
from structlog.testing import capture_logs

from contracts.access import CredentialFile, Principal, Role, sha256_of
from contracts.problem import Dependency, Problem
from mesh.access import NotDeclaredError, credentials, middleware, principal_of, public, requires_role
from mesh.access.rate_limit import FAILURES_A_MINUTE
from mesh.app import make_app
from mesh.http import ServiceClient
from mesh.settings import Port, ServiceSettings


class Settings(ServiceSettings):
    model_config = SettingsConfigDict(env_prefix="SAMPLE_", frozen=True)

    port: Port = 8000


@asynccontextmanager
async def nothing(_: FastAPI) -> AsyncIterator[None]:
    yield


async def dependencies(_: Request) -> Sequence[Dependency]:
    return []


def make(keys_file: Path | None) -> FastAPI:
    app = make_app(
        "sample",
        lifespan=nothing,
        dependencies=dependencies,
        settings=Settings(keys_file=keys_file),
        body_bytes_max=100,
    )

    @app.get("/looks")
    @requires_role(Role.VIEWER)
    async def looks(request: Request) -> str:
        principal = principal_of(request)
        return principal.name if principal is not None else "nobody"

    @app.post("/drives")
    @requires_role(Role.OPERATOR)
    async def drives(body: dict[str, str]) -> str:
        return "driven"

    @app.post("/stop")
    @public
    async def stop(request: Request) -> str:
        return "stopped" if principal_of(request) is None else "asked who"

    @app.websocket("/talk")
    @requires_role(Role.OPERATOR)
    async def talk(socket: WebSocket) -> None:
        await socket.accept()
        await socket.send_text("hello")
        await socket.close()

    return app


def write(file: Path, **roles: Role) -> None:
    """A key for each name; the key is the name said twice."""
    principals = tuple(Principal(name=name, role=role, key_sha256=sha256_of(name * 2)) for name, role in roles.items())
    file.write_text(CredentialFile(principals=principals).model_dump_json())


def damage(file: Path) -> None:
    file.write_text("{")


def remove(file: Path) -> None:
    file.unlink()


def key_of(name: str) -> dict[str, str]:
    return {"Authorization": f"Bearer {name * 2}"}


@pytest.fixture
def keys_file(tmp_path: Path) -> Path:
    write(tmp_path / "keys.json", vera=Role.VIEWER, otto=Role.OPERATOR)
    return tmp_path / "keys.json"


@pytest.fixture
async def client(keys_file: Path) -> AsyncIterator[httpx.AsyncClient]:
    async with httpx.AsyncClient(transport=httpx.ASGITransport(make(keys_file)), base_url="http://sample") as opened:
        yield opened


async def test_a_known_key_says_who_asks(client: httpx.AsyncClient) -> None:
    assert (await client.get("/looks", headers=key_of("vera"))).json() == "vera"


@pytest.mark.parametrize(
    ("headers", "challenge"),
    [
        ({}, "Bearer"),
        ({"Authorization": "Basic dmVyYTp2ZXJh"}, "Bearer"),
        ({"Authorization": "Bearer wrong"}, 'Bearer error="invalid_token"'),
        ({"Authorization": "Bearer"}, 'Bearer error="invalid_token"'),
        ({"Authorization": "Bearer \xe9\x00"}, 'Bearer error="invalid_token"'),
    ],
)
async def test_who_is_not_known_is_asked_for_a_key(
    client: httpx.AsyncClient, headers: dict[str, str], challenge: str
) -> None:
    encoded = {name: value.encode("latin-1") for name, value in headers.items()}
    answer = await client.get("/looks", headers=encoded)
    assert (answer.status_code, answer.headers["www-authenticate"]) == (401, challenge)
    assert Problem.model_validate_json(answer.content).title == "Who asks is not known"


async def test_a_role_that_is_too_low_is_refused_before_the_body_is_read(client: httpx.AsyncClient) -> None:
    answer = await client.post("/drives", content=b"{", headers=key_of("vera"))
    assert answer.status_code == 403
    assert Problem.model_validate_json(answer.content).detail == "vera is viewer; this needs operator"
    assert (await client.post("/drives", content=b"{", headers=key_of("otto"))).status_code == 422


async def test_wrong_keys_are_answered_no_more_after_a_while_and_right_ones_always(client: httpx.AsyncClient) -> None:
    wrong = [await client.get("/looks", headers={"Authorization": f"Bearer {n}"}) for n in range(FAILURES_A_MINUTE + 1)]
    assert [one.status_code for one in wrong] == [401] * FAILURES_A_MINUTE + [429]
    assert (await client.get("/looks", headers=key_of("vera"))).status_code == 200


async def test_a_stop_is_open_and_compares_no_key(client: httpx.AsyncClient, monkeypatch: pytest.MonkeyPatch) -> None:
    def compared(key: str) -> str:
        raise AssertionError("a stop waits for no key")

    await client.get("/looks")
    monkeypatch.setattr(credentials, "sha256_of", compared)
    assert (await client.post("/stop", headers=key_of("vera"))).json() == "stopped"
    with pytest.raises(AssertionError):
        await client.get("/looks", headers=key_of("vera"))


async def test_without_keys_everybody_may_everything() -> None:
    async with httpx.AsyncClient(transport=httpx.ASGITransport(make(None)), base_url="http://sample") as open_client:
        assert (await open_client.get("/looks")).json() == "anybody"
        assert (await open_client.post("/drives", json={})).status_code == 200


def test_a_socket_asks_for_a_key_before_it_opens(keys_file: Path) -> None:
    with TestClient(make(keys_file), base_url="http://sample") as opened:
        with opened.websocket_connect("ws://sample/talk", headers=key_of("otto")) as socket:
            assert socket.receive_text() == "hello"
        with pytest.raises(WebSocketDenialResponse) as refused, opened.websocket_connect("ws://sample/talk"):
            pass
        assert refused.value.status_code == 401


async def test_a_service_with_an_undeclared_route_does_not_start(keys_file: Path) -> None:
    app = make(keys_file)
    app.get("/forgotten")(dependencies)
    with pytest.raises(NotDeclaredError, match="GET /forgotten"):
        async with LifespanManager(app):
            pass


async def test_a_revoked_key_ends_without_a_restart_and_a_broken_file_changes_nothing(
    client: httpx.AsyncClient, keys_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(credentials, "LOOK_S", 0.0)
    assert (await client.get("/looks", headers=key_of("vera"))).status_code == 200
    damage(keys_file)
    assert (await client.get("/looks", headers=key_of("vera"))).status_code == 200
    write(keys_file, otto=Role.OPERATOR)
    assert (await client.get("/looks", headers=key_of("vera"))).status_code == 401
    remove(keys_file)
    assert (await client.get("/looks", headers=key_of("otto"))).status_code == 200


@pytest.mark.parametrize(("content", "why"), [("{", "no file of keys"), (None, "No such file")])
def test_a_service_does_not_start_with_a_file_of_keys_that_cannot_be_read(
    tmp_path: Path, content: str | None, why: str
) -> None:
    file = tmp_path / "keys.json"
    if content is not None:
        file.write_text(content)
    with pytest.raises(SystemExit, match=f"SAMPLE_KEYS_FILE: .*{why}"):
        make(file)


@pytest.mark.parametrize("harm", [damage, remove])
async def test_a_broken_file_of_keys_is_told_once_and_read_when_it_is_whole_again(
    client: httpx.AsyncClient, keys_file: Path, monkeypatch: pytest.MonkeyPatch, harm: Callable[[Path], None]
) -> None:
    monkeypatch.setattr(credentials, "LOOK_S", 0.0)
    harm(keys_file)
    with capture_logs() as told:
        for _ in range(3):
            assert (await client.get("/looks", headers=key_of("vera"))).status_code == 200
        assert [one["event"] for one in told] == ["the keys stay as they were"]
        write(keys_file, vera=Role.VIEWER)
        await client.get("/looks", headers=key_of("vera"))
    assert [one["log_level"] for one in told] == ["error", "info"]


async def test_a_service_says_who_it_is_with_its_own_key(keys_file: Path, tmp_path: Path) -> None:
    (tmp_path / "otto.key").write_text("ottootto\n")
    settings = Settings(key_file=tmp_path / "otto.key")
    client = ServiceClient(
        "sample", "http://sample", key=settings.own_key, transport=httpx.ASGITransport(make(keys_file))
    )
    assert (await client.call("GET", "/looks")).text == '"otto"'


def test_a_services_own_key_that_cannot_be_read_is_named() -> None:
    with pytest.raises(SystemExit, match=r"SAMPLE_KEY_FILE: /nowhere"):
        _ = Settings(key_file=Path("/nowhere")).own_key


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "10.0.0.7", "127.0.0.1,10.0.0.7", "robot.local"])
def test_without_keys_a_service_stays_on_this_machine(monkeypatch: pytest.MonkeyPatch, host: str) -> None:
    monkeypatch.setenv("SAMPLE_HOST", host)
    with pytest.raises(SystemExit, match=r"SAMPLE_HOST=.* without keys: .*SAMPLE_KEYS_FILE"):
        Settings.read()


@pytest.mark.parametrize("host", ["127.0.0.1", "::1", "localhost", "127.0.0.1,::1", "127.0.0.2"])
def test_on_this_machine_alone_it_needs_none(host: str) -> None:
    assert Settings(host=host).host == host


async def test_no_key_is_told_in_logs_answers_or_settings(
    client: httpx.AsyncClient, caplog: pytest.LogCaptureFixture, capfd: pytest.CaptureFixture[str]
) -> None:
    planted = "planted-8f1c"
    settings = Settings(key=SecretStr(planted))
    caller = ServiceClient("sample", "http://sample", key=settings.own_key, transport=client._transport)
    with caplog.at_level(logging.DEBUG):
        answers = [await caller.http.request(method, path) for method, path in (("GET", "/looks"), ("POST", "/drives"))]
        answers.append(await client.get("/metrics", headers=key_of("vera")))
    said = capfd.readouterr()
    everything = "".join(
        [caplog.text, said.out, said.err, repr(settings), str(settings.model_dump()), repr(caller.http)]
    )
    assert planted not in everything + "".join(one.text + str(one.headers) for one in answers)
    assert "a wrong key" in caplog.text + said.out + said.err


async def test_the_document_says_who_may(keys_file: Path) -> None:
    document = make(keys_file).openapi()
    assert document["components"]["securitySchemes"]["key"]["scheme"] == "bearer"
    drives, stop = document["paths"]["/drives"]["post"], document["paths"]["/stop"]["post"]
    assert (drives["security"], drives["x-required-role"]) == ([{"key": []}], "operator")
    assert (stop["security"], stop.get("x-required-role")) == ([], None)


@pytest.mark.parametrize(
    ("host", "status"),
    [
        ("10.0.0.7:8001", 200), ("[::1]:8001", 200), ("localhost", 200), ("coordinator:8001", 200),
        ("robot.local", 200), ("robot.lan:8001", 200), ("evil.example", 421), ("robot.local.evil.example", 421),
        ("10.0.0.7.evil.example", 421), ("", 421), ("robot.local, evil.example", 421),
    ],
)  # fmt: skip
async def test_a_name_that_anybody_may_buy_is_not_answered(host: str, status: int) -> None:
    async with httpx.AsyncClient(transport=httpx.ASGITransport(make(None)), base_url="http://sample") as client:
        assert (await client.get("/looks", headers={"host": host})).status_code == status


def test_an_open_socket_ends_with_the_key_it_was_opened_with(keys_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(credentials, "LOOK_S", 0.0)
    app = make(keys_file)
    heard: list[str] = []

    @app.websocket("/listens")
    @requires_role(Role.OPERATOR)
    async def listens(socket: WebSocket) -> None:
        await socket.accept()
        async for word in socket.iter_text():
            heard.append(word)
            await socket.send_text("heard")
        heard.append("the end")

    with (
        TestClient(app, base_url="http://sample") as opened,
        opened.websocket_connect("ws://sample/listens", headers=key_of("otto")) as socket,
    ):
        socket.send_text("first")
        assert socket.receive_text() == "heard"
        write(keys_file, otto=Role.VIEWER)
        socket.send_text("second")
    assert heard == ["first", "the end"]


async def test_a_stream_ends_with_the_key_it_was_opened_with(keys_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(credentials, "LOOK_S", 0.0)
    monkeypatch.setattr(middleware, "LOOK_S", 0.0)
    app = make(keys_file)

    async def parts() -> AsyncIterator[str]:
        yield "first "
        write(keys_file, otto=Role.OPERATOR)
        yield "second "
        yield "third "

    @app.get("/stream")
    @requires_role(Role.VIEWER)
    async def stream() -> StreamingResponse:
        return StreamingResponse(parts())

    async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url="http://sample") as opened:
        assert (await opened.get("/stream", headers=key_of("vera"))).text == "first "


def test_a_socket_that_only_tells_ends_with_the_key_it_was_opened_with(
    keys_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(credentials, "LOOK_S", 0.0)
    monkeypatch.setattr(middleware, "LOOK_S", 0.0)
    app = make(keys_file)

    @app.websocket("/tells")
    @requires_role(Role.VIEWER)
    async def tells(socket: WebSocket) -> None:
        await socket.accept()
        with contextlib.suppress(WebSocketDisconnect):
            await socket.send_text("first")
            write(keys_file, otto=Role.OPERATOR)
            await socket.send_text("second")

    with (
        TestClient(app, base_url="http://sample") as opened,
        opened.websocket_connect("ws://sample/tells", headers=key_of("vera")) as socket,
    ):
        assert socket.receive_text() == "first"
        with pytest.raises(WebSocketDisconnect) as ended:
            socket.receive_text()
    assert ended.value.code == 1008
