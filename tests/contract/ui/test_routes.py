"""The routes beside the page."""

import asyncio
import re

import httpx
import pytest

from contracts.robot import EmergencyStopReply
from support.threads import every_worker_busy
from support.ui_world import FIRST_ZERO_MS, UiWorld


async def test_stop_reaches_the_robot_and_tells_the_measured_time(client: httpx.AsyncClient, world: UiWorld) -> None:
    answer = await client.post("/stop")
    reply = EmergencyStopReply.model_validate_json(answer.content)
    assert reply.state.latched
    assert reply.first_zero_ms == FIRST_ZERO_MS
    assert [stop.reason for stop in world.robot.stops] == ["STOP pressed on the page"]


async def test_stop_needs_neither_redis_nor_any_service_but_the_bridge(
    client: httpx.AsyncClient, world: UiWorld
) -> None:
    world.bus.connected = False
    for service in (world.missions, world.inference, world.memory):
        service.away = True
    assert (await client.post("/stop?how=escape")).status_code == 200
    assert [stop.reason for stop in world.robot.stops] == ["Esc pressed on the page"]


async def test_whether_a_stop_would_arrive_is_told_with_whether_the_robot_is_stopped(
    client: httpx.AsyncClient, world: UiWorld
) -> None:
    await client.post("/stop")
    assert (await client.get("/stop")).json() == {"latched": True}, "a stranger is not told by whom and why"


async def test_a_page_whose_key_is_revoked_knows_that_a_stop_arrives_and_not_whether_the_robot_is_stopped(
    client: httpx.AsyncClient, world: UiWorld
) -> None:
    world.robot.knows_the_page = False
    answer = await client.get("/stop")
    assert (answer.status_code, answer.json()) == (200, {"latched": None})


async def test_while_a_stop_would_not_arrive_the_answer_says_why(client: httpx.AsyncClient, world: UiWorld) -> None:
    world.robot.away = True
    answer = await client.get("/stop")
    assert answer.status_code == 503
    assert answer.json()["detail"] == "robot_bridge: not reachable"
    assert answer.headers["content-type"] == "application/problem+json"


async def test_many_pages_that_ask_at_once_ask_the_bridge_once(client: httpx.AsyncClient, world: UiWorld) -> None:
    answers = await asyncio.gather(*(client.get("/stop") for _ in range(20)))
    assert [one.status_code for one in answers] == [200] * 20
    assert world.robot.asked.count("stop answers") == 1


async def test_a_plain_form_is_answered_with_a_page_that_says_whether_the_robot_stopped(
    client: httpx.AsyncClient, world: UiWorld
) -> None:
    browser = {"accept": "text/html,application/xhtml+xml", "content-type": "application/x-www-form-urlencoded"}
    page = await client.post("/stop?how=form", headers=browser)
    assert page.status_code == 200
    assert page.headers["content-type"].startswith("text/html")
    assert "The robot is stopped." in page.text
    assert "First zero velocity after 2.4 ms." in page.text
    assert world.robot.stops[-1].reason == "STOP pressed on the page, without its script"
    world.robot.away = True
    page = await client.post("/stop?how=form", headers=browser)
    assert page.status_code == 503
    assert "STOP DID NOT REACH THE ROBOT" in page.text
    assert "curl -X POST http://ROBOT:8004/emergency-stop" in page.text
    assert '<form method="post" action="stop?how=form">' in page.text


async def test_stop_below_a_prefix_stays_open_to_every_page(client: httpx.AsyncClient, world: UiWorld) -> None:
    elsewhere = {"origin": "http://evil.example", "x-forwarded-prefix": "/robot"}
    assert (await client.post("/robot/stop", headers=elsewhere)).status_code == 200
    assert (await client.post("/robot/place/halt", headers=elsewhere)).status_code == 403
    assert len(world.robot.stops) == 1


@pytest.mark.parametrize(
    "body", [b"", b"{", b"\xff" * 100, b'{"reason": 7}', b"x" * 5_000_000], ids=["none", "torn", "noise", "odd", "huge"]
)
async def test_nothing_in_the_request_keeps_stop_from_stopping(
    client: httpx.AsyncClient, world: UiWorld, body: bytes
) -> None:
    assert (await client.post("/stop?how=[]&x=%00", content=body)).status_code == 200
    assert len(world.robot.stops) == 1


@pytest.mark.timeout(30)
async def test_stop_needs_no_worker_thread(client: httpx.AsyncClient, world: UiWorld) -> None:
    with every_worker_busy():
        assert (await client.post("/stop")).status_code == 200
    assert len(world.robot.stops) == 1


async def test_a_stop_that_cannot_reach_the_robot_says_so(client: httpx.AsyncClient, world: UiWorld) -> None:
    world.robot.away = True
    answer = await client.post("/stop")
    assert answer.status_code == 503
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.json()["detail"] == "robot_bridge: not reachable"


async def test_the_map_is_a_picture(client: httpx.AsyncClient) -> None:
    answer = await client.get("/live/map.png")
    assert answer.headers["content-type"] == "image/png"
    assert answer.content.startswith(b"\x89PNG")


async def test_without_a_map_the_bridge_is_named(client: httpx.AsyncClient, world: UiWorld) -> None:
    world.robot.away = True
    answer = await client.get("/live/map.png")
    assert answer.status_code == 503
    assert "robot_bridge" in answer.json()["detail"]


async def test_ready_names_redis_and_every_service(client: httpx.AsyncClient, world: UiWorld) -> None:
    assert (await client.get("/ready")).status_code == 200
    world.bus.connected = False
    world.memory.away = True
    answer = await client.get("/ready")
    assert answer.status_code == 503
    assert [one["name"] for one in answer.json()["dependencies"] if one["state"] != "ready"] == ["redis", "memory"]


async def test_health_answers_while_everything_is_away(client: httpx.AsyncClient, world: UiWorld) -> None:
    for service in (world.missions, world.inference, world.memory, world.robot):
        service.away = True
    assert (await client.get("/health")).json() == {"status": "ok", "service": "ui"}


async def test_a_huge_body_is_refused(client: httpx.AsyncClient, world: UiWorld) -> None:
    assert (await client.post("/place/go", content=b"x" * 1_000_000)).status_code == 413


async def test_the_page_asks_for_nothing_from_outside(client: httpx.AsyncClient) -> None:
    page = (await client.get("/")).text
    assert "ATOM" in page
    assert 'src="http' not in page
    assert 'href="http' not in page
    style = await client.get("/assets/ui.css")
    assert "url(http" not in style.text


@pytest.mark.parametrize(
    "said",
    [
        "//evil",
        '/"><script>alert(1)</script>',
        "/..",
        "/a/../b",
        f"/{'x' * 4000}",
        "/';alert(1)//",
        "javascript:x",
        "/%22",
    ],
)
@pytest.mark.parametrize("header", ["x-forwarded-prefix", "x-ingress-path"])
async def test_a_hostile_prefix_leaves_the_page_as_it_is(client: httpx.AsyncClient, header: str, said: str) -> None:
    page = await client.get("/", headers={header: said})
    assert page.status_code == 200
    assert said not in page.text
    assert "<base" not in page.text
    assert 'src="/_nicegui/' in page.text


async def test_below_a_prefix_every_address_of_the_page_lies_below_it(client: httpx.AsyncClient) -> None:
    for path in ("/", "/robot", "/robot/"):
        page = (await client.get(path, headers={"x-forwarded-prefix": "/robot"})).text
        assert '<base href="/robot/">' in page
        addresses = re.findall(r"""(?:src|href|action)=["']([^"']*)""", page)
        assert [one for one in addresses if one.startswith("/") and not one.startswith("/robot/")] == []
        assert '"/_nicegui' not in page


async def test_the_documentation_lies_below_the_prefix_too(client: httpx.AsyncClient) -> None:
    page = (await client.get("/docs", headers={"x-forwarded-prefix": "/robot"})).text
    assert "/robot/openapi.json" in page
    assert (await client.get("/robot/openapi.json", headers={"x-forwarded-prefix": "/robot"})).status_code == 200


async def test_the_documentation_is_served_from_here(client: httpx.AsyncClient) -> None:
    assert "https://" not in (await client.get("/docs")).text


async def test_memory_is_exported_as_a_file(client: httpx.AsyncClient) -> None:
    answer = await client.get("/memory/export")
    assert "attachment" in answer.headers["content-disposition"]
    assert answer.content


async def test_a_crop_comes_from_the_missions_records(client: httpx.AsyncClient, world: UiWorld) -> None:
    assert (await client.get("/crops/m-1/0")).content.startswith(b"\xff\xd8")
    world.missions.away = True
    assert (await client.get("/crops/m-1/0")).status_code == 503


async def test_a_moment_that_is_not_kept_is_not_found(client: httpx.AsyncClient) -> None:
    assert (await client.get("/album/m-1/3")).status_code == 404
    assert (await client.get("/things/3")).status_code == 404


@pytest.mark.parametrize(
    "click",
    [
        {"x_px": -1.0, "y_px": 3.0, "version": "v"},
        {"x_px": 1e9, "y_px": 3.0, "version": "v"},
        {"x_px": "left", "y_px": 3.0, "version": "v"},
        {"x_px": 1.0, "y_px": 3.0, "version": "another map"},
        {},
    ],
)
async def test_a_click_that_makes_no_sense_moves_nothing(
    client: httpx.AsyncClient, world: UiWorld, click: dict[str, object]
) -> None:
    for what in ("go", "look"):
        answer = await client.post(f"/place/{what}", json=click)
        assert answer.status_code == 422
        assert answer.headers["content-type"] == "application/problem+json"
    assert (world.robot.goals, world.robot.turns) == ([], [])
