"""The stop stops first, whatever the request looks like, and what is kept of it."""

import asyncio
import json
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import httpx
import pytest

from contracts.robot import EmergencyStop, EmergencyStopAction, EmergencyStopEvent, EmergencyStopReply
from robot_bridge.navigation.goal_executor import GoalExecutor
from robot_bridge.safety.emergency_stop import LatchFile
from robot_bridge.settings import Settings
from support.bridge_behaviour import Rig
from support.threads import every_worker_busy
from support.toy_robot import ToyRobot
from support.waiting import until

from .conftest import Served, serving


async def too_much() -> AsyncIterator[bytes]:
    for _ in range(400):
        yield b" " * 10_000


@pytest.mark.parametrize(
    "content",
    [b"", b"\xff{{{", b'{"reason": 7}', b" " * 20_000_000, b'{"reason": "' + b"x" * 50_000 + b'"}', too_much()],
    ids=["none", "no JSON", "no text", "20 MB", "a long reason", "no declared length"],
)
async def test_it_stops_whatever_the_body_is(rig: Rig, content: Any) -> None:
    await rig.velocity(duration_s=2.0)
    await until(lambda: rig.toy.has_driven, timeout_s=30.0)
    response = await rig.client.post("/emergency-stop", content=content)
    assert response.status_code == 200
    assert response.json()["state"]["latched"]
    assert rig.toy.at_rest
    assert (await rig.client.get("/emergency-stop")).json()["latched"]


@pytest.mark.parametrize("headers", [{}, {"Origin": "http://another.example"}, {"Authorization": "Bearer wrong"}])
async def test_a_slash_too_many_stops_too(rig: Rig, headers: dict[str, str]) -> None:
    answer = await rig.client.post("/emergency-stop/", content=b" " * 20_000_000, headers=headers)
    assert answer.status_code == 200
    assert (await rig.client.get("/emergency-stop")).json()["latched"]


async def test_a_stop_whose_body_is_on_its_way_claims_no_reason(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robot_bridge.routes.stop.BODY_WAIT_S", 60.0)
    meanwhile: list[EmergencyStop] = []

    async def body() -> AsyncIterator[bytes]:
        meanwhile.append(EmergencyStop.model_validate_json((await rig.client.get("/emergency-stop")).content))
        yield b'{"reason": "smoke"}'

    answer = EmergencyStopReply.model_validate_json((await rig.client.post("/emergency-stop", content=body())).content)
    assert [(stop.latched, stop.reason) for stop in meanwhile] == [(True, "")]
    assert answer.state.reason == "smoke"


@pytest.mark.parametrize("content", [b"", b'{"reason": ""}'])
async def test_a_stop_that_gives_no_reason_was_requested(rig: Rig, content: bytes) -> None:
    assert (await rig.client.post("/emergency-stop", content=content)).json()["state"]["reason"] == "requested"


async def raw(served: Served, request: bytes) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
    host, port = served.address.split(":")
    reader, writer = await asyncio.open_connection(host, int(port))
    writer.write(request)
    await writer.drain()
    return reader, writer


HEAD = b"POST /emergency-stop HTTP/1.1\r\nHost: bridge\r\n"


async def test_it_stops_though_the_body_never_comes(served: Served) -> None:
    _, writer = await raw(served, HEAD + b"Content-Length: 500\r\n\r\n{")
    await until(lambda: served.toy.base_stop is True, timeout_s=30.0)
    writer.close()


async def test_it_stops_though_the_client_is_gone_before_the_answer(served: Served) -> None:
    _, writer = await raw(served, HEAD + b"Content-Length: 500\r\n\r\n{")
    writer.transport.abort()
    await until(lambda: served.toy.base_stop is True, timeout_s=30.0)


async def test_a_declared_body_over_every_limit_is_not_waited_for(served: Served) -> None:
    reader, writer = await raw(served, HEAD + b"Content-Length: 999999999999\r\n\r\n" + b" " * 20_000)
    status = await asyncio.wait_for(reader.readline(), 30.0)
    assert status.split()[1] == b"200"
    assert served.toy.base_stop is True
    writer.close()


async def test_it_stops_while_every_worker_thread_is_busy(rig: Rig) -> None:
    with every_worker_busy():
        assert (await rig.client.post("/emergency-stop")).json()["state"]["latched"]


async def test_a_fault_in_what_follows_the_zeros_does_not_keep_the_latch_from_the_disk(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(GoalExecutor, "stop", Mock(side_effect=RuntimeError("a fault")))
    with pytest.raises(RuntimeError, match="a fault"):
        await rig.client.post("/emergency-stop")
    assert LatchFile(rig.settings.state_dir).load(now_s=0.0).latched


async def history(http: httpx.AsyncClient, query: str = "") -> list[EmergencyStopEvent]:
    answer = (await http.get(f"/emergency-stop/history{query}")).json()
    return [EmergencyStopEvent.model_validate_json(json.dumps(event)) for event in answer]


async def test_who_stopped_it_when_and_why_is_kept_over_restarts(tmp_path: Path) -> None:
    settings = Settings(state_dir=tmp_path)
    async with serving(settings, ToyRobot()) as first, httpx.AsyncClient(base_url=f"http://{first.address}") as http:
        await http.post("/emergency-stop", json={"reason": "smoke", "by": "a person"})
        await http.post("/emergency-stop/reset", json={"reason": "aired", "by": "a person"})
        await http.post("/emergency-stop", json={"reason": "fire", "by": "another"})
        assert [event.reason for event in await history(http, "?limit=2")] == ["fire", "aired"]
    async with serving(settings, ToyRobot()) as second, httpx.AsyncClient(base_url=f"http://{second.address}") as http:
        restored, *before = await history(http)
    assert [(e.action, e.epoch, e.by, e.reason) for e in before] == [
        (EmergencyStopAction.STOPPED, 2, "another", "fire"),
        (EmergencyStopAction.RESET, 1, "a person", "aired"),
        (EmergencyStopAction.STOPPED, 1, "a person", "smoke"),
    ]
    assert (restored.action, restored.epoch) == (EmergencyStopAction.RESTORED, 2)
    stamps_s = [event.stamp_s for event in (restored, *before)]
    assert stamps_s == sorted(stamps_s, reverse=True)


async def test_a_disk_that_would_lose_the_latch_is_told_before_the_first_stop(served: Served, tmp_path: Path) -> None:
    async def missing(http: httpx.AsyncClient) -> dict[str, str]:
        return {
            each["name"]: each["detail"]
            for each in (await http.get("/ready")).json()["dependencies"]
            if each["state"] != "ready"
        }

    nowhere = Settings(state_dir=tmp_path / "file" / "state")
    (tmp_path / "file").write_text("no folder")
    async with serving(nowhere, ToyRobot()) as other, httpx.AsyncClient(base_url=f"http://{other.address}") as http:
        assert (await missing(http))["latch"] == "cannot be stored: Not a directory"
        assert (await http.post("/emergency-stop")).json()["state"]["latched"]
    async with httpx.AsyncClient(base_url=f"http://{served.address}") as http:
        assert "latch" not in await missing(http)


@pytest.mark.parametrize("limit", ["0", "201", "many"])
async def test_a_senseless_length_of_history_is_malformed(rig: Rig, limit: str) -> None:
    assert (await rig.client.get(f"/emergency-stop/history?limit={limit}")).status_code == 422
