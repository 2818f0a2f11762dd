"""Real time: one thread owns the World and paces it against the wall clock; everybody else leaves it notes."""

import threading
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import CancelledError, Future
from dataclasses import dataclass
from typing import Final, TypeVar

import structlog

from contracts.geometry import Twist2D
from sim.world import World

T = TypeVar("T")
log = structlog.get_logger()

SLICE_S: Final = 0.025
LAG_MAX_S: Final = 0.3
_LAG_SKIPS_FRAMES_S: Final = 0.1
_FRAMES_SKIPPED_MAX: Final = 3
_WINDOW_S: Final = 10.0


@dataclass
class Duty:
    """Something done at a rate of simulated time: `run(world, stamp_ns)`."""

    name: str
    hz: float
    run: Callable[[World, int], None]
    costly: bool = False
    """A costly duty leaves out a turn now and then while the simulation is behind."""
    next_s: float = 0.0
    skipped: int = 0


@dataclass(frozen=True)
class Pace:
    """How well real time is kept: simulated seconds for each second of the wall clock."""

    factor: float = 1.0
    factor_recent: float = 1.0
    time_s: float = 0.0


class RealTime:
    """Runs a World in real time. `call` and `command` may be used from any thread; the World from none but its own.

    A velocity takes effect at the simulated moment that matches its arrival, also when the simulation is briefly
    behind. A lag beyond `LAG_MAX_S` is dropped and shows in the factor.
    """

    def __init__(self, make_world: Callable[[], World], set_up: Callable[[World], list[Duty]]) -> None:
        """Both run in the World's thread. The World is closed there at the end."""
        self._make_world = make_world
        self._set_up = set_up
        self._notes: deque[tuple[Callable[[World], object], Future[object]]] = deque(maxlen=1000)
        self._twists: deque[tuple[float, Twist2D]] = deque(maxlen=50)
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._guarded, name="world")
        self._pace = Pace()
        self._origin_s = 0.0
        self._on_death: Callable[[], None] = lambda: None
        self.base_is_busy = False
        """Set in the World's thread while the base minds itself (docking) and takes no velocity."""
        self.running = threading.Event()
        self.error: Exception | None = None

    def start(self, *, on_death: Callable[[], None]) -> None:
        """`on_death` is called from the World's thread when it ends by an error, kept in `error`."""
        self._on_death = on_death
        self._thread.start()

    def stop(self) -> None:
        """Ends the thread; a World that is still being built is waited for."""
        self._stop.set()
        if self._thread.ident is not None:
            self._thread.join()

    @property
    def pace(self) -> Pace:
        return self._pace

    def behind_s(self, world: World) -> float:
        """How far the World is behind the wall clock, s: a slice, and any lag. For work run by `call`."""
        return max(0.0, time.monotonic() - self._origin_s - world.time_s)

    def command(self, twist: Twist2D) -> None:
        """A velocity that has just arrived on `cmd_vel`."""
        self._twists.append((time.monotonic(), twist))

    def call(self, work: Callable[[World], T]) -> "Future[T]":
        """Runs `work` in the World's thread between two steps."""
        future: Future[T] = Future()
        if self._stop.is_set():
            future.cancel()
            return future
        self._notes.append((work, future))  # type: ignore[arg-type]
        return future

    def ask(self, work: Callable[[World], object], *, timeout_s: float = 5.0) -> bool:
        """As `call`, and waits for it; false when the World is not there to do it."""
        try:
            self.call(work).result(timeout=timeout_s)
        except (TimeoutError, CancelledError):
            return False
        return True

    def _guarded(self) -> None:
        try:
            self._run()
        except Exception as error:
            log.exception("the simulated world died")
            self.error = error
            self._on_death()

    def _run(self) -> None:
        world = self._make_world()
        try:
            duties = self._set_up(world)
            self._pace_world(world, duties)
        finally:
            for _, future in self._notes:
                future.cancel()
            world.close()

    def _pace_world(self, world: World, duties: list[Duty]) -> None:
        """`_origin_s` is the monotonic time at which the simulated clock stood, or would have stood, at zero."""
        to_epoch_s = time.time() - time.monotonic()
        began_s = time.monotonic()
        begun_s = world.time_s
        self._origin_s = began_s - begun_s
        window: deque[tuple[float, float]] = deque([(began_s, begun_s)])
        self.running.set()
        while not self._stop.is_set():
            slice_end_s = self._origin_s + world.time_s + SLICE_S
            ahead_s = slice_end_s - time.monotonic()  # a slice runs once it is over: nothing is stamped in the future
            if ahead_s > 0:
                self._stop.wait(ahead_s)
                continue
            if -ahead_s > LAG_MAX_S:
                self._origin_s += -ahead_s - LAG_MAX_S
            self._do_notes(world)
            self._apply_twists(world, until_s=self._origin_s + world.time_s)
            world.advance(SLICE_S)
            stamp_ns = int((to_epoch_s + self._origin_s + world.time_s) * 1e9)
            self._do_duties(world, duties, stamp_ns, lag_s=-ahead_s)
            now_s = time.monotonic()
            if now_s - window[-1][0] > 0.5:
                window.append((now_s, world.time_s))
                while now_s - window[0][0] > _WINDOW_S:
                    window.popleft()
            recent_s = max(now_s - window[0][0], SLICE_S)
            self._pace = Pace(
                factor=(world.time_s - begun_s) / max(now_s - began_s, SLICE_S),
                factor_recent=(world.time_s - window[0][1]) / recent_s,
                time_s=world.time_s,
            )

    def _do_notes(self, world: World) -> None:
        while self._notes:
            work, future = self._notes.popleft()
            if not future.set_running_or_notify_cancel():
                continue
            try:
                future.set_result(work(world))
            except Exception as error:  # noqa: BLE001 - handed to whoever asked
                future.set_exception(error)

    def _apply_twists(self, world: World, *, until_s: float) -> None:
        newest: Twist2D | None = None
        while self._twists and self._twists[0][0] <= until_s:
            newest = self._twists.popleft()[1]
        if newest is not None and not self.base_is_busy:
            world.command(newest.linear_x, newest.angular_z)

    def _do_duties(self, world: World, duties: list[Duty], stamp_ns: int, *, lag_s: float) -> None:
        for duty in duties:
            if world.time_s < duty.next_s:
                continue
            late = duty.costly and lag_s > _LAG_SKIPS_FRAMES_S
            if late and duty.skipped < _FRAMES_SKIPPED_MAX:
                duty.skipped += 1
            else:
                duty.skipped = 0
                duty.run(world, stamp_ns)
            duty.next_s = max(duty.next_s + 1.0 / duty.hz, world.time_s)
