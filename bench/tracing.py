"""What tracing costs a request: `python -m bench.tracing`, or `make bench-trace`. Writes out/bench/tracing.json.

One service calls itself over a socket, client and server in one process, so that both ends count. *untraced*: the
call is part of no trace, as most are. *off*: it is, and nobody records, as a service does by default. *on*: spans are
written to a file, as with `ATOM_TRACES`. Each way in processes of its own, in turns; the median of the rounds counts.
`cpu_ms` is processor time a request, which a busy computer does not blur.
"""

import argparse
import asyncio
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import AsyncGenerator, Sequence
from contextlib import asynccontextmanager, nullcontext
from pathlib import Path
from typing import Any

import uvicorn
from fastapi import APIRouter, FastAPI

from bench.results import quiet, save
from contracts.problem import Dependency, Health
from mesh.access import public
from mesh.app import make_app
from mesh.http import ServiceClient
from mesh.tracing import TracedRoute, Tracer, configure_tracing

WAYS = ("untraced", "off", "on")
FIGURES = ("p50_ms", "p99_ms", "cpu_ms")
TRACER = Tracer("bench.tracing")


def service() -> FastAPI:
    router = APIRouter(route_class=TracedRoute)

    @router.post("/work")
    @public
    async def work() -> Health:
        return Health(service="bench")

    @asynccontextmanager
    async def nothing(_: FastAPI) -> AsyncGenerator[None]:
        yield

    async def dependencies(_: object) -> Sequence[Dependency]:
        return ()

    app = make_app("bench", lifespan=nothing, dependencies=dependencies)
    app.include_router(router)
    return app


async def measured(way: str, requests: int, port: int) -> dict[str, float]:
    server = uvicorn.Server(uvicorn.Config(service(), port=port, log_level="error"))
    serving = asyncio.create_task(server.serve())
    while not server.started:  # noqa: ASYNC110 - uvicorn has no event of its own
        await asyncio.sleep(0.01)
    client = ServiceClient("bench", f"http://127.0.0.1:{port}")
    with nullcontext() if way == "untraced" else TRACER.command("bench"):
        await timed(client, requests // 10)  # warm afterwards
        began_cpu_s = time.process_time()
        took_ms = await timed(client, requests)
        cpu_ms = (time.process_time() - began_cpu_s) * 1000.0 / requests
    await client.aclose()
    server.should_exit = True
    await serving
    return {"p50_ms": took_ms[len(took_ms) // 2], "p99_ms": took_ms[int(len(took_ms) * 0.99)], "cpu_ms": cpu_ms}


async def timed(client: ServiceClient, requests: int) -> list[float]:
    """ms of each request, sorted."""
    took_ms: list[float] = []
    for _ in range(requests):
        began_s = time.perf_counter()
        await client.post("/work", None, Health)
        took_ms.append((time.perf_counter() - began_s) * 1000.0)
    return sorted(took_ms)


def child(way: str, requests: int, port: int) -> None:
    quiet()
    if way == "on":
        configure_tracing("bench")
    sys.stdout.write(json.dumps(asyncio.run(measured(way, requests, port))) + "\n")


def one_round(way: str, requests: int, port: int) -> dict[str, float]:
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "ATOM_TRACES": folder if way == "on" else ""}
        numbers = ["--requests", str(requests), "--port", str(port)]
        command = [sys.executable, "-m", "bench.tracing", "--child", way, *numbers]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
        told: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
        return told


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--requests", type=int, default=1000)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--port", type=int, default=8790)
    parser.add_argument("--child", choices=WAYS)
    parser.add_argument("--out", type=Path, default=Path("out/bench/tracing.json"))
    options = parser.parse_args()
    if options.child:
        child(options.child, options.requests, options.port)
        return 0
    rounds = [{way: one_round(way, options.requests, options.port) for way in WAYS} for _ in range(options.rounds)]
    found: dict[str, Any] = {
        way: {name: round(statistics.median(one[way][name] for one in rounds), 3) for name in FIGURES} for way in WAYS
    }
    for way in WAYS[1:]:
        for name in FIGURES:
            ratio = statistics.median(one[way][name] / one["untraced"][name] for one in rounds)
            found[way][name.replace("_ms", "_ratio")] = round(ratio, 3)
    save(options.out, found | {"requests": options.requests, "rounds": rounds})
    sys.stdout.write(json.dumps(found, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
