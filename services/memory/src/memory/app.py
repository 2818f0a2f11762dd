"""Composition root: the only module that knows which parts are real."""

from collections.abc import AsyncGenerator, Callable, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from typing import TypedDict

from fastapi import FastAPI, Request

from contracts.problem import Dependency
from contracts.topics import ROBOT_DESCRIPTION
from memory.adapters.robot_bridge import RobotBridge
from memory.adapters.store import SqlStore
from memory.memory_service import MemoryService
from memory.ports import DepthAndMap, Store
from memory.retention import Retention
from memory.routes import get_memory, router
from memory.settings import Settings
from mesh.app import make_app
from mesh.bus import Bus, open_bus
from mesh.clock import Clock, SystemClock
from mesh.tasks import Tasks, end_this_process


class State(TypedDict):
    memory: MemoryService


def create_app(
    settings: Settings,
    *,
    bus: Bus | None = None,
    store: Store | None = None,
    senses: DepthAndMap | None = None,
    clock: Clock | None = None,
    on_death: Callable[[], None] = end_this_process,
) -> FastAPI:
    """The service; whatever is not given is the real thing that `settings` name. A store is closed at the end."""

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncGenerator[State]:
        async with AsyncExitStack() as stack:
            real_store = store if store is not None else SqlStore.from_settings(settings)
            stack.push_async_callback(real_store.aclose)
            real_bus = (
                bus
                if bus is not None
                else await stack.enter_async_context(open_bus(settings.redis_url, settings.own_key))
            )
            real_clock = clock if clock is not None else SystemClock()
            real_senses = senses if senses is not None else _senses(settings, real_clock)
            if real_senses is not None:
                stack.push_async_callback(real_senses.aclose)
            memory = MemoryService(settings, real_store, real_bus, real_clock, real_senses)
            stack.push_async_callback(memory.close)
            tasks = await stack.enter_async_context(Tasks(on_death=on_death))
            tasks.start("listen", memory.listen())
            tasks.start("look", memory.look_forever())
            tasks.start("hear-robot", memory.hear_robot())
            tasks.start("hear-description", real_bus.listen(ROBOT_DESCRIPTION, memory.describe))
            tasks.start("watch-map", memory.watch_map_forever())
            tasks.start("flush", memory.flush_forever())
            tasks.start("tidy", Retention(settings, real_store, real_clock, memory.writing).tidy_forever())
            yield {"memory": memory}

    async def dependencies(request: Request) -> Sequence[Dependency]:
        return await (await get_memory(request)).dependencies()

    app = make_app(
        "memory",
        lifespan=lifespan,
        dependencies=dependencies,
        settings=settings,
        body_bytes_max_at={"/import": settings.import_bytes_max, "/restore": None},
        description="Remembers where things were seen, notices what is gone, and tells where to look first.",
    )
    app.include_router(router)
    return app


def _senses(settings: Settings, clock: Clock) -> DepthAndMap | None:
    if not settings.robot_bridge_url:
        return None
    return RobotBridge(settings.robot_bridge_url, clock, key=settings.own_key, timeout_s=settings.senses_timeout_s)
