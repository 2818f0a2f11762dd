"""Composition root: the only module that knows which parts are real."""

from collections.abc import AsyncGenerator, Callable, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from typing import TypedDict

from fastapi import FastAPI, Request

from contracts.problem import Dependency
from memory.adapters.sqlite import SqliteStore
from memory.ports import Store
from memory.remembering import Memory
from memory.routes import get_memory, router
from memory.settings import Settings
from mesh.app import make_app
from mesh.bus import Bus, open_bus
from mesh.clock import Clock, SystemClock
from mesh.tasks import Tasks, end_this_process


class State(TypedDict):
    memory: Memory


def create_app(
    settings: Settings,
    *,
    bus: Bus | None = None,
    store: Store | None = None,
    clock: Clock | None = None,
    on_death: Callable[[], None] = end_this_process,
) -> FastAPI:
    """The service; whatever is not given is the real thing that `settings` name. A store is closed at the end."""

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncGenerator[State]:
        async with AsyncExitStack() as stack:
            real_store = store if store is not None else SqliteStore.from_settings(settings)
            stack.push_async_callback(real_store.aclose)
            real_bus = bus if bus is not None else await stack.enter_async_context(open_bus(settings.redis_url))
            memory = Memory(settings, real_store, real_bus, clock or SystemClock())
            stack.push_async_callback(memory.try_flush)
            tasks = await stack.enter_async_context(Tasks(on_death=on_death))
            tasks.start("listen", memory.listen())
            tasks.start("flush", memory.flush_forever())
            yield {"memory": memory}

    async def dependencies(request: Request) -> Sequence[Dependency]:
        return await get_memory(request).dependencies()

    app = make_app(
        "memory",
        lifespan=lifespan,
        dependencies=dependencies,
        description="Remembers from where things were seen, and tells where to look first.",
    )
    app.include_router(router)
    return app
