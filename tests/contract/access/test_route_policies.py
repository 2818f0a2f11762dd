"""Asks every route, socket and mount of every service, with every role and with none."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import access_page
import pytest
from fastapi import FastAPI
from starlette.types import Receive, Scope, Send

from contracts.access import CALLERS, CredentialFile, Principal, Role, sha256_of
from contracts.topics import ALL_TOPICS, RECORDER
from mesh.access.policies import ANY, SOCKET, RoutePolicy, route_policies
from support.source import ROOT

WHO = (None, *Role)
ROW = re.compile(r"\| (\S+) \| `(/\S*)` \| (\*\*open\*\*|\w+) \|")


@pytest.fixture(scope="module")
def keys(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A key of each role; the key is the role's name."""
    file = tmp_path_factory.mktemp("keys") / "keys.json"
    principals = tuple(Principal(name=role.value, role=role, key_sha256=sha256_of(role.value)) for role in Role)
    file.write_text(CredentialFile(principals=principals).model_dump_json())
    return file


@pytest.fixture(scope="module", params=CALLERS)
def service(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope="module")
def app(service: str, keys: Path) -> FastAPI:
    """The real app behind its real middleware; what stands behind it only says that it was reached."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setenv(f"{service.upper()}_KEYS_FILE", str(keys))
        patched.setenv(f"{service.upper()}_KEY", "its own")
        made = access_page.app_of(service)
    made.router.middleware_stack = reached
    return made


async def reached(scope: Scope, receive: Receive, send: Send) -> None:
    if scope["type"] == "websocket":
        await send({"type": "websocket.accept"})
    else:
        await send({"type": "http.response.start", "status": 204, "headers": []})
        await send({"type": "http.response.body"})


async def answer_to(app: FastAPI, method: str, path: str, role: Role | None, *, origin: str = "") -> str:
    """What is answered: 'in', the status of the refusal, or the code a socket is closed with."""
    answers: list[Any] = []
    said = {"host": "robot.local", "authorization": role and f"Bearer {role}", "origin": origin}
    headers = [(name.encode(), value.encode()) for name, value in said.items() if value]
    scope: Scope = {
        "type": "websocket" if method == SOCKET else "http",
        "path": path,
        "raw_path": path.encode(),
        "query_string": b"",
        "root_path": "",
        "headers": headers,
        "client": ("10.0.0.9", 4711),
        "server": ("robot.local", 8000),
        "scheme": "http",
        "extensions": {"websocket.http.response": {}},
        **({} if method == SOCKET else {"method": method}),
    }

    async def receive() -> Any:
        return {"type": "http.request", "body": b"", "more_body": False}

    async def send(message: Any) -> None:
        answers.append(message)

    await app(scope, receive, send)
    begun = answers[0]
    told = begun.get("status", begun.get("code", 204))
    return "in" if told == 204 else str(told)


def asked_by(policy: RoutePolicy) -> tuple[str, ...]:
    """A mount takes sockets too: NiceGUI's is one."""
    return ("GET", "POST", SOCKET) if policy.method == ANY else (policy.method,)


def expected(policy: RoutePolicy, role: Role | None) -> str:
    if policy.role is None or (role is not None and role.may(policy.role)):
        return "in"
    return "401" if role is None else "403"


def told(service: str) -> list[tuple[str, str, str]]:
    (section,) = re.findall(rf"\n## {service}\n(.*?)(?=\n## )", access_page.PAGE.read_text(), re.DOTALL)
    return ROW.findall(section)


async def test_every_route_answers_whom_the_table_names_and_nobody_else(app: FastAPI, service: str) -> None:
    policies = route_policies(app.routes)
    assert [(one.method, one.path, str(one.role or "**open**")) for one in policies] == told(service)
    requests = [(policy, method, role) for policy in policies for method in asked_by(policy) for role in WHO]
    found = [(*one, await answer_to(app, one[1], re.sub(r"\{\w+\}", "1", one[0].path), one[2])) for one in requests]
    assert found == [(*one, expected(one[0], one[2])) for one in requests]


async def test_another_page_changes_nothing_through_the_browser_of_somebody_who_may_everything(app: FastAPI) -> None:
    """The cookie comes along with a link from anywhere (SameSite=Lax); more than reading needs our Origin, too."""
    requests = [
        (method, policy.path) for policy in route_policies(app.routes) for method in asked_by(policy) if policy.role
    ]
    found = {
        (
            *one,
            await answer_to(app, one[0], re.sub(r"\{\w+\}", "1", one[1]), Role.ADMIN, origin="http://another.example"),
        )
        for one in requests
    }
    assert found == {(*one, {"GET": "in", "HEAD": "in", SOCKET: "1008"}.get(one[0], "403")) for one in requests}


async def test_what_is_not_there_tells_a_stranger_nothing(app: FastAPI) -> None:
    assert await answer_to(app, "GET", "/nowhere/at/all", None) == "401"
    assert await answer_to(app, "GET", "/nowhere/at/all", Role.VIEWER) == "in"


def test_the_page_is_as_the_routes_declare() -> None:
    assert access_page.PAGE.read_text(encoding="utf-8") == access_page.page(), "run tools/access_page.py"


def test_only_what_stops_tells_that_it_lives_or_lets_in_is_open() -> None:
    opened = {
        (name, one.method, one.path) for name in CALLERS for one in access_page.policies(name) if one.role is None
    }
    common = {"/health", "/ready", "/openapi.json", "/docs", "/docs/oauth2-redirect", "/static-offline-docs/{path}"}
    assert {one for one in opened if one[2] not in common} == {
        ("coordinator", "POST", "/actions/stop"),
        ("robot_bridge", "POST", "/emergency-stop"),
        ("robot_bridge", "POST", "/emergency-stop/"),
        ("ui", "GET", "/login"),
        ("ui", "POST", "/login"),
        ("ui", "GET", "/stop"),
        ("ui", "POST", "/stop"),
        ("ui", "POST", "/stop/"),
    }


def test_a_viewer_changes_nothing() -> None:
    """What a viewer may post asks, or takes its own leave; `/ask` obeys a stop, and 'go on' only of an operator.
    `/actions` and `/mcp` ask for each action's own role (`tests/contract/coordinator/test_actions.py`, `test_mcp.py`).
    """
    asks = {"/actions", "/mcp", "/ask", "/understand", "/recall", "/depth", "/localize", "/navigation/path", "/logout"}
    policies = [one for name in CALLERS for one in access_page.policies(name) if one.role is Role.VIEWER]
    assert {one.path for one in policies if one.method not in {"GET", "HEAD", SOCKET, ANY}} == asks


@pytest.mark.parametrize("topic", ALL_TOPICS, ids=lambda one: one.name)
def test_a_topic_is_published_and_heard_by_whom_it_names(topic: Any) -> None:
    """As the source says it: who calls `publish` or `listen` with it."""
    name = re.escape(topic.name.replace(".", "_").upper())

    def using(word: str) -> set[str]:
        pattern = re.compile(rf"\b{word}\(\s*{name}\b")
        return {one for one in CALLERS for file in _sources(one) if pattern.search(file.read_text(encoding="utf-8"))}

    assert using("publish") == {topic.publisher}
    assert using("(?:listen|last)") | {RECORDER} == set(topic.listeners)


def _sources(service: str) -> Iterator[Path]:
    return (ROOT / "services" / service / "src").rglob("*.py")
