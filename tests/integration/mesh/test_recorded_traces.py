"""A service in a process of its own records spans where the environment says so, to the last one, and ends in time."""

import asyncio
import json
import os
import signal
import sys
import time
from pathlib import Path

import httpx

from support.redis_server import free_port
from support.waiting import until_true

SERVICE = """
import sys
from contextlib import asynccontextmanager
from fastapi import APIRouter
from mesh.access import public
from mesh.app import make_app
from mesh.server import serve
from mesh.tracing import TracedRoute, configure_tracing

@asynccontextmanager
async def nothing(app):
    yield

async def dependencies(request):
    return []

router = APIRouter(route_class=TracedRoute)

@router.post("/work")
@public
async def work() -> dict[str, str]:
    return {}

configure_tracing("sample")
app = make_app("sample", lifespan=nothing, dependencies=dependencies)
app.include_router(router)
serve(app, host="127.0.0.1", port=int(sys.argv[1]))
"""
OTHERS = {"traceparent": "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01"}


async def worked_and_ended(environment: dict[str, str]) -> float:
    """Seconds from SIGTERM to the end of a service that has handled one traced request."""
    port = free_port()
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-c", SERVICE, str(port), env={**os.environ, **environment}
    )
    async with httpx.AsyncClient(base_url=f"http://127.0.0.1:{port}", trust_env=False) as http:

        async def answers() -> bool:
            try:
                return (await http.post("/work", headers=OTHERS)).is_success
            except httpx.TransportError:
                return False

        await until_true(answers)
    asked_s = time.monotonic()
    process.send_signal(signal.SIGTERM)
    async with asyncio.timeout(20.0):
        await process.wait()
    return time.monotonic() - asked_s


async def test_the_last_span_is_in_the_file_when_the_service_has_ended(tmp_path: Path) -> None:
    await worked_and_ended({"ATOM_TRACES": str(tmp_path)})
    (line,) = [json.loads(one) for one in (tmp_path / "sample.jsonl").read_text().splitlines()]
    assert (line["name"], line["trace_id"]) == ("POST /work", "0af7651916cd43dd8448eb211c80319c")


async def test_a_collector_that_never_answers_holds_up_no_end() -> None:
    """192.0.2.0/24 is nobody's: packets there are lost."""
    took_s = await worked_and_ended({"OTEL_EXPORTER_OTLP_ENDPOINT": "http://192.0.2.1:4318"})
    assert took_s < 5.0
