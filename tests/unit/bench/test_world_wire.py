"""A request without a socket meets the routes as one from the network does, and a caller may give up."""

import asyncio
import contextlib
from collections import Counter
from collections.abc import AsyncGenerator

import pytest
from fastapi import FastAPI, Request, WebSocket

from bench.world.clock import run_simulated
from bench.world.wire import Wire, open_socket, served
from contracts.problem import Health
from mesh.errors import ServiceTimeoutError, UpstreamError
from mesh.http import ServiceClient

gone: list[float] = []


def app() -> FastAPI:
    @contextlib.asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncGenerator[dict[str, str]]:
        yield {"name": "kept by the lifespan"}

    made = FastAPI(lifespan=lifespan)

    @made.get("/health")
    async def health(request: Request) -> Health:
        return Health(service=request.state.name)

    @made.get("/slow")
    async def slow(request: Request) -> None:
        while (await request.receive())["type"] != "http.disconnect":
            pass
        gone.append(asyncio.get_running_loop().time())

    @made.websocket("/echo")
    async def echo(socket: WebSocket) -> None:
        await socket.accept()
        await socket.send_text(f"heard {await socket.receive_text()}")

    return made


def test_an_answer_comes_with_what_the_lifespan_opened_and_is_counted() -> None:
    calls: Counter[str] = Counter()

    async def main() -> Health:
        async with served("sample", app(), calls) as sample:
            return await ServiceClient("sample", "http://sample", transport=Wire("bench", sample)).get(
                "/health", Health
            )

    assert run_simulated(main).service == "kept by the lifespan"
    assert calls == {"bench GET sample/health": 1}


def test_a_caller_that_gives_up_is_gone_for_the_service() -> None:
    async def main() -> None:
        async with served("sample", app(), Counter()) as sample:
            client = ServiceClient("sample", "http://sample", timeout_s=5.0, transport=Wire("bench", sample))
            with pytest.raises(ServiceTimeoutError):
                await client.call("GET", "/slow")
            await asyncio.sleep(1.0)

    gone.clear()
    run_simulated(main, start_s=100.0)
    assert gone == [105.0]


def test_what_is_not_there_is_told_as_over_the_network() -> None:
    async def main() -> None:
        async with served("sample", app(), Counter()) as sample:
            await ServiceClient("sample", "http://sample", transport=Wire("bench", sample)).call("GET", "/nowhere")

    with pytest.raises(UpstreamError):
        run_simulated(main)


def test_a_socket_carries_words_both_ways() -> None:
    async def main() -> str:
        async with served("sample", app(), Counter()) as sample, open_socket(sample, "ws://sample/echo") as socket:
            await socket.send("beat")
            return await socket.recv()

    assert run_simulated(main) == "heard beat"
