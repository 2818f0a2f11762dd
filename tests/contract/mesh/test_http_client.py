"""How the service client names what can go wrong between two services."""

import httpx
import pytest

from contracts.problem import Dependency, DependencyState, Health, Readiness
from mesh import http
from mesh.errors import MeshError, ServiceTimeoutError, UnavailableError, UpstreamError
from mesh.http import ServiceClient


def answering(*answers: httpx.Response | Exception) -> tuple[ServiceClient, list[httpx.Request]]:
    seen: list[httpx.Request] = []
    waiting = list(answers)

    async def handler(request: httpx.Request) -> httpx.Response:
        seen.append(request)
        answer = waiting.pop(0) if len(waiting) > 1 else waiting[0]
        if isinstance(answer, Exception):
            raise answer
        return answer

    return ServiceClient("memory", "http://memory", transport=httpx.MockTransport(handler)), seen


HEALTHY = httpx.Response(200, json={"status": "ok", "service": "memory"})


@pytest.mark.parametrize(
    ("answer", "error"),
    [
        (httpx.ConnectError("refused"), UnavailableError),
        (httpx.ReadTimeout("slow"), ServiceTimeoutError),
        (httpx.RemoteProtocolError("died"), UnavailableError),
        (httpx.Response(409, json={"detail": "busy"}), UpstreamError),
        (httpx.Response(503, json={"detail": "loading"}), UnavailableError),
        (httpx.Response(500, text="<html>"), UpstreamError),
        (httpx.Response(200, text="not json"), UpstreamError),
        (httpx.Response(200, json={"service": 3}), UpstreamError),
    ],
)
async def test_each_failure_has_a_name_and_names_the_service(
    answer: httpx.Response | Exception, error: type[MeshError]
) -> None:
    client, _ = answering(answer)
    with pytest.raises(error, match="memory"):
        await client.post("/health", None, Health)


async def test_reads_are_tried_again_and_writes_never() -> None:
    client, seen = answering(httpx.ConnectError("refused"), HEALTHY)
    assert (await client.get("/health", Health)).service == "memory"
    assert len(seen) == 2
    client, seen = answering(httpx.ConnectError("refused"), HEALTHY)
    with pytest.raises(UnavailableError):
        await client.post("/health", None, Health)
    assert len(seen) == 1


@pytest.mark.parametrize("status", [401, 429])
async def test_who_is_refused_reads_no_more_for_a_while_and_writes_all_the_same(
    status: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    client, seen = answering(httpx.Response(status, json={"detail": "this key is not known"}), HEALTHY)
    for _ in range(3):
        with pytest.raises(UpstreamError, match="this key is not known") as refused:
            await client.get("/health", Health)
        assert refused.value.upstream_status == status
    assert len(seen) == 1
    await client.post("/health", None, Health)
    assert len(seen) == 2
    monkeypatch.setattr(http, "REFUSED_WAIT_S", 0.0)
    assert (await client.get("/health", Health)).service == "memory"


@pytest.mark.parametrize(
    ("answers", "detail"),
    [
        ((httpx.Response(200),), ""),
        ((httpx.Response(503),), "not ready"),
        ((httpx.ConnectError("refused"),), "not reachable (ConnectError)"),
        ((httpx.ReadTimeout("waits for a dependency that hangs"), HEALTHY), "not ready in time"),
        ((httpx.ReadTimeout("hangs"),), "not reachable (ReadTimeout)"),
    ],
)
async def test_a_service_that_waits_for_another_is_told_from_one_that_hangs(
    answers: tuple[httpx.Response | Exception, ...], detail: str
) -> None:
    client, _ = answering(*answers)
    found = await client.dependency()
    assert (found.ok, found.detail) == (detail == "", detail)


async def test_what_a_ready_service_warns_of_is_handed_on() -> None:
    lines = (
        Dependency.of("models", ok=True, detail="loaded"),
        Dependency(name="ollama:small", state=DependencyState.WARNING, detail="answers, but never as asked"),
    )
    ready = Readiness(ready=True, service="inference", dependencies=lines)
    client, _ = answering(httpx.Response(200, content=ready.model_dump_json()))
    found = await client.dependency()
    assert (found.state, found.detail) == (DependencyState.WARNING, "ollama:small: answers, but never as asked")
