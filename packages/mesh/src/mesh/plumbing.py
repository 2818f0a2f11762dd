"""What every service's lifespan opens, and in which order it closes again."""

import contextlib
from collections.abc import AsyncGenerator, Callable
from dataclasses import dataclass

from mesh.bus import Bus, open_bus
from mesh.clock import Clock, SystemClock
from mesh.tasks import Tasks


@dataclass(frozen=True, slots=True)
class Plumbing:
    """`stack` closes what a service opens itself: after its tasks have ended, before the bus goes."""

    bus: Bus
    clock: Clock
    tasks: Tasks
    stack: contextlib.AsyncExitStack


@contextlib.asynccontextmanager
async def open_plumbing(
    redis_url: str, *, bus: Bus | None, clock: Clock | None = None, on_death: Callable[[], None]
) -> AsyncGenerator[Plumbing]:
    """The real bus and the system's clock unless others are given; those that are given stay open."""
    async with contextlib.AsyncExitStack() as outer:
        the_bus = bus if bus is not None else await outer.enter_async_context(open_bus(redis_url))
        stack = await outer.enter_async_context(contextlib.AsyncExitStack())
        tasks = await outer.enter_async_context(Tasks(on_death=on_death))
        yield Plumbing(the_bus, clock if clock is not None else SystemClock(), tasks, stack)
