"""The memory service over a store in a dict and a bus in memory."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import httpx
import pytest
from asgi_lifespan import LifespanManager
from fastapi import FastAPI

from mesh.http import ServiceClient
from support.bus import MemoryBus
from support.described import described_bus
from support.memory_store import FakeStore


@pytest.fixture
def store() -> FakeStore:
    return FakeStore()


@pytest.fixture
def bus() -> MemoryBus:
    return described_bus()


@asynccontextmanager
async def served(app: FastAPI) -> AsyncIterator[ServiceClient]:
    """A client of the app, for as long as the block lasts."""
    async with LifespanManager(app) as manager:
        client = ServiceClient("memory", "http://memory", transport=httpx.ASGITransport(manager.app))
        try:
            yield client
        finally:
            await client.aclose()
