"""An event loop whose time jumps to the next thing that is due: hours of waiting pass in no time, and always alike."""

import asyncio
import concurrent.futures
import selectors
from collections.abc import Callable, Coroutine
from typing import Any, TypeVar

T = TypeVar("T")

TURNS_MAX = 200_000
"""Turns of the loop without time passing before it counts as spinning."""


class NothingLeftError(RuntimeError):
    """Everybody waits and nothing is due: a hang."""


class SpinningError(RuntimeError):
    """The same instant goes on for ever: a hang of another kind."""


class SimulatedClock:
    """The port `mesh.clock.Clock` on the running loop's own time."""

    def now_s(self) -> float:
        return asyncio.get_running_loop().time()

    async def sleep(self, seconds: float) -> None:
        await asyncio.sleep(seconds)


class SimulatedTimeLoop(asyncio.SelectorEventLoop):
    """No sockets, no threads: work meant for a thread is done at once, in place."""

    def __init__(self, start_s: float = 1000.0) -> None:
        self.simulated_s = start_s
        super().__init__(_Jumping(self))
        self.set_default_executor(_InPlace(max_workers=1))

    def time(self) -> float:
        return self.simulated_s


class _Jumping(selectors.DefaultSelector):  # type: ignore[misc, valid-type]
    """Where the real one would wait, the clock is put forward."""

    def __init__(self, loop: SimulatedTimeLoop) -> None:
        super().__init__()
        self._loop = loop
        self._turns = 0

    def select(self, timeout: float | None = None) -> list[Any]:
        if timeout is None:
            raise NothingLeftError("everybody waits and nothing is due")
        if timeout > 0.0:
            self._loop.simulated_s += timeout
            self._turns = 0
        self._turns += 1
        if self._turns > TURNS_MAX:
            raise SpinningError(f"{TURNS_MAX} turns at {self._loop.simulated_s:.2f} s")
        return []


class _InPlace(concurrent.futures.ThreadPoolExecutor):
    """Runs what is submitted before `submit` returns."""

    def submit(self, fn: Callable[..., T], /, *args: Any, **kwargs: Any) -> "concurrent.futures.Future[T]":
        future: concurrent.futures.Future[T] = concurrent.futures.Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:  # noqa: BLE001 - handed to whoever asked
            future.set_exception(error)
        return future


def run_simulated(main: Callable[[], Coroutine[Any, Any, T]], *, start_s: float = 1000.0) -> T:
    """Runs to the end on a loop of its own. Raises `NothingLeftError`, `SpinningError` and whatever `main` raises."""
    loop = SimulatedTimeLoop(start_s)
    try:
        asyncio.set_event_loop(loop)
        return loop.run_until_complete(main())
    finally:
        left = asyncio.all_tasks(loop)
        for task in left:
            task.cancel()
        if left:
            loop.run_until_complete(asyncio.gather(*left, return_exceptions=True))
        asyncio.set_event_loop(None)
        loop.close()
