"""Redis pub/sub for facts: they may be lost, the newest wins, and a lost connection heals by itself."""

# redis-py ships no complete types for its asyncio client.
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUnknownArgumentType=false
# pyright: reportArgumentType=false

import asyncio
import contextlib
from collections.abc import AsyncGenerator, Awaitable, Callable
from typing import Protocol
from urllib.parse import urlsplit

import redis.asyncio as redis
import structlog
from prometheus_client import Counter
from pydantic import SecretStr, ValidationError
from redis.exceptions import RedisError

from contracts.access import bus_password_of
from contracts.problem import Dependency, DependencyState
from contracts.topics import M, Topic, traceparent_of
from mesh.tracing import following, traceparent

log = structlog.get_logger()

MALFORMED = Counter("bus_malformed_total", "messages that did not validate and were dropped", ["topic"])
UNPUBLISHED = Counter("bus_unpublished_total", "messages lost because Redis was away", ["topic"])

MESSAGE_BYTES_MAX = 4_000_000


def redis_dependency(bus: "Bus") -> Dependency:
    """Redis as a line of a service's `/ready`."""
    if bus.connected:
        return Dependency(name="redis", state=DependencyState.READY)
    return Dependency(name="redis", state=DependencyState.UNREACHABLE, detail="not reachable")


class Bus(Protocol):
    """What services need of a bus. A test may use an in-memory one; one suite runs over both."""

    @property
    def connected(self) -> bool: ...

    async def publish(self, topic: Topic[M], message: M) -> bool:
        """True when handed over; False when the bus is away (a fact is lost, nobody waits)."""
        ...

    async def last(self, topic: Topic[M]) -> M | None:
        """The newest value of a kept topic, or none."""
        ...

    async def listen(self, topic: Topic[M], handler: Callable[[M], Awaitable[None]]) -> None:
        """Calls `handler` with the kept value (if any) and then each message, until cancelled; each time inside the
        trace that the message was published in.
        """
        ...


class RedisBus:
    """`async with open_bus(url) as bus`. Payloads are plain JSON, so that `redis-cli subscribe` can read along."""

    def __init__(self, client: "redis.Redis") -> None:
        self._client = client
        self._connected = False

    @property
    def connected(self) -> bool:
        return self._connected

    async def watch(self) -> None:
        """Keeps `connected` true to life; runs as a background task."""
        while True:
            try:
                await self._client.ping()
            except (RedisError, OSError, TimeoutError):
                self._connected = False
            else:
                self._connected = True
            await asyncio.sleep(1.0)

    async def publish(self, topic: Topic[M], message: M) -> bool:
        data = topic.encode(message, traceparent())
        try:
            if topic.kept:
                async with self._client.pipeline(transaction=True) as pipe:
                    pipe.set(topic.kept_key, data)
                    pipe.publish(topic.name, data)
                    await pipe.execute()
            else:
                await self._client.publish(topic.name, data)
        except (RedisError, OSError, TimeoutError):
            self._connected = False
            UNPUBLISHED.labels(topic.name).inc()
            return False
        self._connected = True
        return True

    async def last(self, topic: Topic[M]) -> M | None:
        data = await self._client.get(topic.kept_key)
        return decode(topic, data) if data is not None else None

    async def _hand(self, topic: Topic[M], data: bytes, handler: Callable[[M], Awaitable[None]]) -> None:
        if (message := decode(topic, data)) is not None:
            with following(traceparent_of(data)):
                await handler(message)

    async def listen(self, topic: Topic[M], handler: Callable[[M], Awaitable[None]]) -> None:
        while True:
            try:
                async with self._client.pubsub(ignore_subscribe_messages=True) as pubsub:
                    await pubsub.subscribe(topic.name)
                    if topic.kept and (kept := await self._client.get(topic.kept_key)) is not None:
                        await self._hand(topic, kept, handler)
                    async for raw in pubsub.listen():
                        await self._hand(topic, raw["data"], handler)
            except (RedisError, OSError, TimeoutError) as error:
                log.warning("the bus is away; trying again", topic=topic.name, error=str(error))
                self._connected = False
                await asyncio.sleep(0.5)


def decode(topic: Topic[M], data: bytes) -> M | None:
    """The message, or none (counted) when it is malformed or too large."""
    if len(data) <= MESSAGE_BYTES_MAX:
        with contextlib.suppress(ValidationError):
            return topic.decode(data)
    MALFORMED.labels(topic.name).inc()
    log.warning("dropped a malformed message", topic=topic.name, bytes=len(data))
    return None


@contextlib.asynccontextmanager
async def open_bus(url: str, key: SecretStr | None = None) -> AsyncGenerator[RedisBus]:
    """Opens without waiting for Redis: `connected` says when it is there.

    A URL that names a user and no password gets the one that is made of the service's `key`.
    """
    place = urlsplit(url)
    named = place.username is not None and place.password is None
    client = redis.Redis.from_url(
        url,
        password=bus_password_of(key.get_secret_value()) if key is not None and named else None,
        socket_connect_timeout=1.0,
        socket_timeout=None,
        health_check_interval=5,
    )
    bus = RedisBus(client)
    watcher = asyncio.create_task(bus.watch(), name="bus-watch")
    try:
        yield bus
    finally:
        watcher.cancel()
        await asyncio.gather(watcher, return_exceptions=True)
        await client.aclose()
