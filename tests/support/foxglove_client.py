"""A client of Foxglove's WebSocket protocol, foxglove.sdk.v1, as the app is one.

https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md
"""

import asyncio
import contextlib
import json
import struct
from collections.abc import AsyncIterator
from dataclasses import dataclass, field
from typing import Any, Final

from websockets.asyncio.client import ClientConnection, connect
from websockets.typing import Subprotocol

SUBPROTOCOL: Final = Subprotocol("foxglove.sdk.v1")
MESSAGE: Final = struct.Struct("<BIQ")
"""Opcode, subscription, nanoseconds; then the message."""
SILENCE_S: Final = 3.0
"""Longer than what is said again needs."""


@dataclass
class FoxgloveClient:
    """Takes in what it is told only while one of its methods waits."""

    socket: ClientConnection
    channels: dict[str, dict[str, Any]] = field(default_factory=dict)
    info: dict[str, Any] = field(default_factory=dict)
    statuses: list[dict[str, Any]] = field(default_factory=list)
    heard: list[tuple[str, int, bytes]] = field(default_factory=list)
    """Topic, log time in ns, data."""

    async def take(self) -> None:
        said = await self.socket.recv()
        if isinstance(said, bytes):
            opcode, channel, log_ns = MESSAGE.unpack_from(said)
            assert opcode == 1
            (topic,) = [name for name, each in self.channels.items() if each["id"] == channel]
            self.heard.append((topic, log_ns, said[MESSAGE.size :]))
            return
        told = json.loads(said)
        match told["op"]:
            case "serverInfo":
                self.info = told
            case "advertise":
                self.channels |= {each["topic"]: each for each in told["channels"]}
            case _:
                self.statuses.append(told)

    async def send(self, **message: Any) -> None:
        await self.socket.send(json.dumps(message))

    async def advertised(self, *topics: str, timeout_s: float = 30.0) -> None:
        async with asyncio.timeout(timeout_s):
            while not set(topics) <= self.channels.keys():
                await self.take()

    async def subscribe(self, *topics: str) -> None:
        """Each under its channel's own number."""
        wanted = [{"id": self.channels[topic]["id"], "channelId": self.channels[topic]["id"]} for topic in topics]
        await self.send(op="subscribe", subscriptions=wanted)

    async def next_of(self, topic: str, timeout_s: float = 30.0) -> bytes:
        """The next message not yet taken in. While nothing comes it subscribes again: the SDK tells of a channel a
        moment before it takes a subscription of it (`advertise_channels` in its connected_client.rs), and a client
        that is quicker is refused."""
        known = len(self.heard)
        async with asyncio.timeout(timeout_s):
            while True:
                for found, _, data in self.heard[known:]:
                    if found == topic:
                        return data
                known = len(self.heard)
                try:
                    async with asyncio.timeout(SILENCE_S):
                        await self.take()
                except TimeoutError:
                    await self.subscribe(topic)


@contextlib.asynccontextmanager
async def foxglove_client(port: int, *, origin: str | None = None) -> AsyncIterator[FoxgloveClient]:
    address = f"ws://127.0.0.1:{port}"
    async with connect(address, subprotocols=[SUBPROTOCOL], origin=origin, max_size=None, proxy=None) as socket:  # pyright: ignore[reportArgumentType]
        client = FoxgloveClient(socket)
        async with asyncio.timeout(30.0):
            while not client.info:
                await client.take()
        yield client
