"""The load of `bench.stop`: viewers of the camera's stream, requests for the state, a stream of velocities."""

import argparse
import asyncio
import contextlib
import json
import time
from dataclasses import dataclass

import httpx
import websockets

from contracts.causes import Refusal


@dataclass(frozen=True)
class Bridge:
    """`key`: none where it asks for none."""

    port: int
    key: str | None
    host: str = "127.0.0.1"

    @property
    def headers(self) -> dict[str, str]:
        return {} if self.key is None else {"Authorization": f"Bearer {self.key}"}

    def get(self, path: str) -> bytes:
        lines = (f"GET {path} HTTP/1.1", "Host: bridge", *(f"{name}: {value}" for name, value in self.headers.items()))
        return "\r\n".join([*lines, "", ""]).encode()


async def watch(bridge: Bridge, counts: dict[str, int]) -> None:
    """Reads `/camera/stream` as fast as it comes."""
    reader, writer = await asyncio.open_connection(bridge.host, bridge.port)
    writer.write(bridge.get("/camera/stream"))
    try:
        while chunk := await reader.read(1 << 16):
            counts["stream_bytes"] += len(chunk)
    finally:
        writer.close()


async def ask(bridge: Bridge, period_s: float, counts: dict[str, int]) -> None:
    """`GET /state` on one kept connection, one each `period_s`; one that is late is left out."""
    reader, writer = await asyncio.open_connection(bridge.host, bridge.port)
    request = bridge.get("/state")
    next_s = time.monotonic()
    try:
        while True:
            writer.write(request)
            head = await reader.readuntil(b"\r\n\r\n")
            length = next(line for line in head.lower().split(b"\r\n") if line.startswith(b"content-length:"))
            await reader.readexactly(int(length.split(b":")[1]))
            counts["states"] += 1
            next_s = max(next_s + period_s, time.monotonic())
            await asyncio.sleep(next_s - time.monotonic())
    finally:
        writer.close()


async def drive(bridge: Bridge, hz: float, counts: dict[str, int]) -> None:
    """Velocities with the epoch of the moment, as teleoperation sends them."""
    epoch = 0
    async with websockets.connect(
        f"ws://{bridge.host}:{bridge.port}/velocity", additional_headers=bridge.headers
    ) as socket:
        while True:
            twist = {"linear_x": 0.2}
            body = {"twist": twist, "source": "load", "epoch": epoch, "duration_s": 0.3, "priority": 4}
            await socket.send(json.dumps(body))
            reply = json.loads(await socket.recv())
            counts["velocities"] += 1
            if reply["refusal"] == Refusal.OLD_EPOCH:
                epoch = await _epoch(bridge)
            await asyncio.sleep(1.0 / hz)


async def _epoch(bridge: Bridge) -> int:
    url = f"http://{bridge.host}:{bridge.port}"
    async with httpx.AsyncClient(base_url=url, headers=bridge.headers, trust_env=False) as http:
        return int((await http.get("/emergency-stop")).json()["epoch"])


async def load(bridge: Bridge, viewers: int, states_hz: float, velocity_hz: float) -> None:
    askers = 4
    counts = {"stream_bytes": 0, "states": 0, "velocities": 0}
    began_s = time.monotonic()
    work = [watch(bridge, counts) for _ in range(viewers)]
    work += [ask(bridge, askers / states_hz, counts) for _ in range(askers)]
    work.append(drive(bridge, velocity_hz, counts))
    tasks = [asyncio.create_task(each) for each in work]
    loop = asyncio.get_running_loop()
    stopped = loop.create_future()
    loop.add_signal_handler(15, lambda: stopped.done() or stopped.set_result(None))
    await asyncio.wait([stopped, *tasks], return_when=asyncio.FIRST_COMPLETED)
    died = [task.exception() for task in tasks if task.done()]
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)
    with contextlib.suppress(BrokenPipeError):
        report = {"seconds": round(time.monotonic() - began_s, 1), "died": [repr(error) for error in died], **counts}
        print(json.dumps(report))  # noqa: T201 - read by bench.stop


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--port", type=int, required=True)
    parser.add_argument("--key", help="where the bridge has keys")
    parser.add_argument("--viewers", type=int, default=4)
    parser.add_argument("--states-hz", type=float, default=100.0)
    parser.add_argument("--velocity-hz", type=float, default=20.0)
    arguments = parser.parse_args()
    asyncio.run(
        load(Bridge(arguments.port, arguments.key), arguments.viewers, arguments.states_hz, arguments.velocity_hz)
    )


if __name__ == "__main__":
    main()
