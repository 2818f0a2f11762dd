"""An event loop whose time jumps to the next thing that is due: hours of waiting pass in no time, and always alike."""

import asyncio
import selectors
from collections.abc import Callable, Coroutine, Mapping
from functools import partial
from typing import Any, TypeVar

T = TypeVar("T")

TURNS_MAX = 200_000
"""Turns of the loop without time passing before it counts as spinning."""


TOOK_S = {"models": 0.05, "database-writer": 0.002, "database-reader": 0.002}
"""How long a service's threads take, by their names, s: about what they take on one core of this machine."""


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
    """No sockets, no threads: work meant for a thread is done at once, in place.

    `took_s` says by an executor's thread names how long its work takes on this clock; what is not named takes no time.
    """

    def __init__(self, start_s: float = 1000.0, took_s: Mapping[str, float] | None = None) -> None:
        self.simulated_s = start_s
        self._took_s = took_s or {}
        super().__init__(_Jumping(self))

    def time(self) -> float:
        return self.simulated_s

    def jump(self, timeout_s: float) -> None:
        """To the very moment that is due next."""
        due: list[asyncio.TimerHandle] = self.__dict__["_scheduled"]  # its own heap: adding up timeouts would round
        self.simulated_s = max(self.simulated_s, due[0].when()) if due else self.simulated_s + timeout_s

    def call_soon_threadsafe(self, callback: Callable[..., object], *args: Any, context: Any = None) -> asyncio.Handle:
        """There is one thread."""
        return self.call_soon(callback, *args, context=context)

    def run_in_executor(self, executor: Any, func: Callable[..., T], *args: Any) -> "asyncio.Future[T]":  # type: ignore[override]
        future: asyncio.Future[T] = self.create_future()
        named = str(getattr(executor, "_thread_name_prefix", ""))
        try:
            value = func(*args)
        except Exception as error:  # noqa: BLE001 - handed to whoever asked
            settle = partial(_settle, future.set_exception, future, error)
        else:
            settle = partial(_settle, future.set_result, future, value)
        took_s = self._took_s.get(named, 0.0)
        if took_s > 0.0:
            self.call_later(took_s, settle)
        else:
            settle()
        return future


def _settle(setter: Callable[[Any], None], future: "asyncio.Future[Any]", value: Any) -> None:
    if not future.done():
        setter(value)


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
            self._loop.jump(timeout)
            self._turns = 0
        self._turns += 1
        if self._turns > TURNS_MAX:
            raise SpinningError(f"{TURNS_MAX} turns at {self._loop.simulated_s:.2f} s")
        return []


def run_simulated(
    main: Callable[[], Coroutine[Any, Any, T]], *, start_s: float = 1000.0, took_s: Mapping[str, float] | None = None
) -> T:
    """Runs to the end on a loop of its own. Raises `NothingLeftError`, `SpinningError` and whatever `main` raises."""
    loop = SimulatedTimeLoop(start_s, took_s)
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
