"""A call from one service to another is of one trace, and says how it went."""

from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager

import httpx
import pytest
from fastapi import APIRouter, FastAPI

from contracts.base import Message
from mesh.access import public
from mesh.app import make_app
from mesh.errors import ConflictError, UnavailableError, UpstreamError
from mesh.http import ServiceClient
from mesh.tracing import TracedRoute, Tracer, trace_id
from support.spans import Spans, id_of, parent_of, recorded_spans, trace_of

TRACER = Tracer("sample.tests")


class Told(Message):
    trace_id: str


@asynccontextmanager
async def nothing(app: FastAPI) -> AsyncIterator[None]:
    yield


def client() -> ServiceClient:
    traced, plain = APIRouter(prefix="/things", route_class=TracedRoute), APIRouter()

    @traced.get("/{thing}")
    @public
    async def read(thing: str) -> Told:
        if thing == "gone":
            raise UnavailableError("database", "it is locked")
        if thing == "busy":
            raise ConflictError("not now")
        return Told(trace_id=trace_id())

    @plain.post("/stop")
    @public
    async def stop() -> Told:
        return Told(trace_id=trace_id())

    async def dependencies(_: object) -> list[object]:
        return []

    app = make_app("sample", lifespan=nothing, dependencies=dependencies)  # pyright: ignore[reportArgumentType]
    app.include_router(traced)
    app.include_router(plain)
    return ServiceClient("sample", "http://sample", transport=httpx.ASGITransport(app))


@pytest.fixture
def spans() -> Iterator[Spans]:
    with recorded_spans() as spans:
        yield spans


async def test_the_handler_is_inside_the_callers_trace(spans: Spans) -> None:
    with TRACER.command("a command"):
        told, here = await client().get("/things/cup", Told), trace_id()
    call, served = spans.one("GET to sample"), spans.one("GET /things/{thing}")
    assert told.trace_id == here == trace_of(call) == trace_of(served)
    assert (parent_of(call), parent_of(served)) == (id_of(spans.one("a command")), id_of(call))
    assert [one.attributes["http.response.status_code"] for one in (call, served) if one.attributes] == [200, 200]


async def test_a_call_outside_a_trace_brings_none(spans: Spans) -> None:
    assert (await client().get("/things/cup", Told)).trace_id == ""
    assert spans.names() == []


async def test_a_router_that_does_not_ask_for_it_is_left_alone(spans: Spans) -> None:
    with TRACER.command("a command"):
        await client().post("/stop", None, Told)
    assert spans.names() == ["POST to sample", "a command"]


async def test_a_refusal_is_an_answer_and_a_fault_is_a_failure(spans: Spans) -> None:
    with TRACER.command("a command"):
        with pytest.raises(UpstreamError):
            await client().get("/things/busy", Told)
        with pytest.raises(UnavailableError):
            await client().call("GET", "/things/gone")
    served = [one for one in spans.all() if one.name == "GET /things/{thing}"]
    assert [one.attributes["http.response.status_code"] for one in served if one.attributes] == [409, 503]
    assert [one.status.description for one in served] == [None, "database: it is locked"]
