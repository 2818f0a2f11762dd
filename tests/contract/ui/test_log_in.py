"""Who is at the page: logging in, what a cookie is worth, and what each may do there."""

import asyncio
import re
import threading
from collections.abc import AsyncIterator
from pathlib import Path

import httpx
import pytest
from asgi_lifespan import LifespanManager
from pwdlib import PasswordHash
from pydantic import SecretStr

from contracts.access import CredentialFile, Principal, Role, sha256_of
from mesh.access import credentials
from mesh.access.rate_limit import FAILURES_A_MINUTE
from support.ui_world import UiWorld, fresh_nicegui
from ui import sessions
from ui.app import create_app
from ui.operator_actions import OperatorActions
from ui.sessions import COOKIE
from ui.settings import Settings

PASSWORD, KEY = "correct horse battery", "a key of otto's own"
BROWSER = {"accept": "text/html,application/xhtml+xml"}
HASHED = PasswordHash.recommended().hash(PASSWORD)


def write(file: Path, *principals: Principal) -> None:
    file.write_text(CredentialFile(principals=principals).model_dump_json())


VERA = Principal(name="vera", role=Role.VIEWER, password=HASHED)
OTTO = Principal(name="otto", role=Role.OPERATOR, key_sha256=sha256_of(KEY))


@pytest.fixture
def keys_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(credentials, "LOOK_S", 0.0)
    write(tmp_path / "keys.json", VERA, OTTO)
    return tmp_path / "keys.json"


@pytest.fixture
async def client(world: UiWorld, keys_file: Path) -> AsyncIterator[httpx.AsyncClient]:
    fresh_nicegui()
    app = create_app(
        Settings(keys_file=keys_file, key=SecretStr("the page's own key"), session_s=60),
        bus=world.bus,
        robot=world.robot,
        inference=world.inference.client(),
        missions=world.missions,
        memory=world.memory,
        on_death=lambda: None,
    )
    async with (
        LifespanManager(app) as managed,
        httpx.AsyncClient(transport=httpx.ASGITransport(managed.app), base_url="http://ui") as opened,
    ):
        yield opened


async def log_in(client: httpx.AsyncClient, name: str, secret: str) -> httpx.Response:
    return await client.post("/login", data={"name": name, "secret": secret})


async def test_a_browser_without_a_cookie_is_sent_to_the_form_and_a_program_is_told(client: httpx.AsyncClient) -> None:
    answer = await client.get("/", headers=BROWSER)
    assert (answer.status_code, answer.headers["location"]) == (303, "login")
    deeper = await client.get("/memory/export", headers=BROWSER)
    assert (deeper.status_code, deeper.headers["location"]) == (303, "../login")
    assert (await client.get("/")).status_code == 401
    form = await client.get("/login", headers=BROWSER)
    assert form.status_code == 200
    assert 'action="stop?how=form"' in form.text


@pytest.mark.parametrize(("name", "secret"), [("vera", PASSWORD), ("otto", KEY), (" vera ", PASSWORD), ("", KEY)])
async def test_a_name_with_its_password_or_key_gets_a_cookie_that_opens_the_page(
    client: httpx.AsyncClient, name: str, secret: str
) -> None:
    answer = await log_in(client, name, secret)
    assert (answer.status_code, answer.headers["location"]) == (303, "./")
    said = answer.headers["set-cookie"].lower()
    assert all(word in said for word in ("httponly", "samesite=lax", "max-age=60", "path=/"))
    assert secret not in answer.headers["set-cookie"]
    page = await client.get("/", headers=BROWSER)
    assert page.status_code == 200
    assert f"{name.strip() or 'otto'} (" in page.text


async def test_behind_a_proxy_with_tls_the_cookie_is_sent_over_tls_alone(client: httpx.AsyncClient) -> None:
    behind = {"x-forwarded-proto": "https", "x-forwarded-prefix": "/robot"}
    answer = await client.post("/login", data={"name": "otto", "secret": KEY}, headers=behind)
    said = answer.headers["set-cookie"].lower()
    assert "; secure" in said
    assert "path=/robot;" in said


@pytest.mark.parametrize(
    ("name", "secret"),
    [("vera", "wrong"), ("vera", ""), ("vera", KEY), ("otto", PASSWORD), ("nobody", PASSWORD), ("", ""), ("otto", "")],
)
async def test_what_does_not_fit_gets_none(client: httpx.AsyncClient, name: str, secret: str) -> None:
    answer = await log_in(client, name, secret)
    assert answer.status_code == 401
    assert "set-cookie" not in answer.headers
    assert "do not fit" in answer.text


async def test_after_too_many_wrong_answers_the_right_one_has_to_wait_too(client: httpx.AsyncClient) -> None:
    wrong = [(await log_in(client, "otto", f"guess {number}")).status_code for number in range(FAILURES_A_MINUTE)]
    assert wrong == [401] * FAILURES_A_MINUTE
    assert (await log_in(client, "vera", PASSWORD)).status_code == 429


async def test_many_wrong_answers_at_once_get_no_more_tries_than_one_after_the_other(
    client: httpx.AsyncClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    tried: list[str] = []
    monkeypatch.setattr(sessions, "VERIFIED_AT_ONCE", 100)
    monkeypatch.setattr(PasswordHash, "verify", lambda _, secret, hashed: tried.append(secret))
    answers = await asyncio.gather(*(log_in(client, "vera", f"guess {number}") for number in range(30)))
    assert len(tried) == FAILURES_A_MINUTE
    assert sorted(one.status_code for one in answers) == [401] * FAILURES_A_MINUTE + [429] * (30 - FAILURES_A_MINUTE)


async def test_right_answers_use_nothing_up(client: httpx.AsyncClient) -> None:
    for _ in range(FAILURES_A_MINUTE + 1):
        assert (await log_in(client, "otto", KEY)).status_code == 303


async def test_while_two_passwords_are_compared_another_is_not_and_costs_no_try_and_a_key_is_let_in(
    client: httpx.AsyncClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    compared, go_on = threading.Semaphore(0), threading.Event()

    def verify(_: PasswordHash, secret: str, hashed: str) -> bool:
        compared.release()
        return go_on.wait(30.0)

    monkeypatch.setattr(PasswordHash, "verify", verify)
    first = [asyncio.create_task(log_in(client, "vera", PASSWORD)) for _ in range(2)]
    try:
        for _ in first:
            assert await asyncio.to_thread(compared.acquire, timeout=5.0)
        others = [await log_in(client, "vera", PASSWORD) for _ in range(2 * FAILURES_A_MINUTE)]
        assert {(one.status_code, one.headers["retry-after"]) for one in others} == {(429, "1")}
        assert (await log_in(client, "otto", KEY)).status_code == 303
    finally:
        go_on.set()
    assert [one.status_code for one in await asyncio.gather(*first)] == [303, 303]


async def test_a_cookie_that_was_changed_is_worth_nothing(client: httpx.AsyncClient) -> None:
    await log_in(client, "vera", PASSWORD)
    cookie = str(client.cookies[COOKIE])
    client.cookies.clear()
    for forged in ("x" + cookie[1:], cookie[:-1], "otto", '["otto",""]', cookie.split(".", maxsplit=1)[0]):
        assert (await client.get("/", headers={"cookie": f"{COOKIE}={forged}"})).status_code == 401
    assert (await client.get("/", headers={"cookie": f"{COOKIE}={cookie}"})).status_code == 200


@pytest.mark.parametrize(
    "then",
    [(OTTO,), (VERA.model_copy(update={"password": PasswordHash.recommended().hash("another password")}), OTTO)],
    ids=["revoked", "another password"],
)
async def test_a_session_ends_with_what_it_began_with(
    client: httpx.AsyncClient, keys_file: Path, then: tuple[Principal, ...]
) -> None:
    await log_in(client, "vera", PASSWORD)
    assert (await client.get("/")).status_code == 200
    write(keys_file, *then)
    assert (await client.get("/")).status_code == 401


async def test_logging_out_takes_the_cookie_back(client: httpx.AsyncClient) -> None:
    await log_in(client, "vera", PASSWORD)
    assert (await client.post("/logout")).status_code == 303
    assert (await client.get("/")).status_code == 401


async def test_a_viewer_looks_and_stops_and_does_nothing_else(client: httpx.AsyncClient, world: UiWorld) -> None:
    await log_in(client, "vera", PASSWORD)
    assert (await client.post("/place/go", json={"x": 1.0, "y": 1.0})).status_code == 403
    assert (await client.post("/stop")).status_code == 200
    assert len(world.robot.stops) == 1


async def test_a_stop_needs_no_cookie_and_a_forged_one_does_no_harm(client: httpx.AsyncClient, world: UiWorld) -> None:
    assert (await client.post("/stop", headers={"cookie": f"{COOKIE}=forged"})).status_code == 200
    assert (await client.get("/stop")).status_code == 200
    assert (await client.post("/stop/", headers={"origin": "http://another.example"})).status_code == 200
    assert len(world.robot.stops) == 2


def test_a_page_with_keys_and_no_key_of_its_own_does_not_start(keys_file: Path) -> None:
    with pytest.raises(SystemExit, match="UI_KEY"):
        create_app(Settings(keys_file=keys_file))


ACTS = sorted(
    name for name, act in vars(OperatorActions).items() if not name.startswith("_") and hasattr(act, "__wrapped__")
)
OPEN = {"emergency_stop", "ask", "command", "refused"}


def test_every_act_of_the_page_says_who_may() -> None:
    acts = {name for name, act in vars(OperatorActions).items() if callable(act) and not name.startswith("_")}
    assert acts == {*ACTS, *OPEN}


@pytest.mark.parametrize("act", ACTS)
@pytest.mark.parametrize(("who", "told"), [(VERA, "yours is viewer"), (None, "not logged in")])
async def test_an_act_is_refused_before_anything_is_asked(act: str, who: Principal | None, told: str) -> None:
    words = {"by": "page"} if act == "reset" else {}
    given = {"go": (1.0, 1.0), "look": (1.0, 1.0)}.get(act, ("1",) if re.search("forget|import|queue", act) else ())
    result = await getattr(OperatorActions(None, lambda: who), act)(*given, **words)  # type: ignore[arg-type]
    assert not result.ok
    assert told in result.text
