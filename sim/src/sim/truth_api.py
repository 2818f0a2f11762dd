"""Ground truth and scoring over HTTP, apart from all that the robot senses. For scoring only: no service may ask."""

import asyncio
import contextlib
from collections.abc import AsyncGenerator, Callable
from concurrent.futures import CancelledError
from typing import Annotated, Protocol, TypeVar

from fastapi import FastAPI, Query, Request

from contracts.base import Message
from contracts.geometry import Pose2D, Twist2D
from contracts.problem import Dependency
from mesh.access import Role, requires_role
from mesh.app import make_app
from mesh.errors import NotFoundError, UnavailableError
from sim.home import Home
from sim.ros.realtime import RealTime
from sim.scoring import NothingToScoreError, Score, score
from sim.world import World

T = TypeVar("T")


class Pacing(Message):
    """Simulated seconds for each second of the wall clock: 1 = real time is kept."""

    factor: float
    factor_recent: float
    """Over the last ten seconds."""
    time_s: float
    """Simulated seconds since the world began."""


class TruthReply(Message):
    pose: Pose2D
    twist: Twist2D
    path_length_m: float
    time_s: float
    """Simulated seconds since the world began, at this look."""
    now_s: float
    """The simulated moment that the wall clock stands at: `time_s` and what the simulation is behind."""
    moved_at_s: float
    """The newest such time at which the robot moved."""
    collisions: int
    touching: tuple[str, ...]
    e_stop_on: bool
    real_time: Pacing
    last_audio: tuple[tuple[int, float], ...]
    """(Hz, s) of each note of the newest tune on `cmd_audio`."""


class Robot(Protocol):
    """What the truth interface needs of the simulated robot's process."""

    @property
    def realtime(self) -> RealTime: ...

    def open(self, *, on_death: Callable[[], None]) -> None: ...

    def close(self) -> None: ...

    def last_audio(self) -> tuple[tuple[int, float], ...]: ...


def create_app(robot: Robot, home: Home, *, on_death: Callable[[], None]) -> FastAPI:
    """The app opens the robot when it starts and closes it when it ends."""

    @contextlib.asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncGenerator[None]:
        try:
            await asyncio.to_thread(robot.open, on_death=on_death)
            yield
        finally:
            await asyncio.to_thread(robot.close)

    async def dependencies(_: Request) -> list[Dependency]:
        running = robot.realtime.running.is_set()
        return [Dependency.of("world", ok=running, detail="" if running else "the home is still being built")]

    async def ask(work: Callable[[World], T]) -> T:
        if not robot.realtime.running.is_set():
            raise UnavailableError("world", "the home is still being built")
        try:
            return await asyncio.wait_for(asyncio.wrap_future(robot.realtime.call(work)), timeout=5.0)
        except (TimeoutError, CancelledError) as error:
            raise UnavailableError("world", "did not answer in time") from error

    app = make_app("sim", lifespan=lifespan, dependencies=dependencies, description=__doc__ or "")

    @app.get("/truth")
    @requires_role(Role.VIEWER)
    async def truth() -> TruthReply:  # pyright: ignore[reportUnusedFunction]
        """Where the robot really is and how it got there."""

        def look(world: World) -> TruthReply:
            found, pace = world.truth, robot.realtime.pace
            return TruthReply(
                pose=found.pose,
                twist=found.twist,
                path_length_m=found.path_length_m,
                time_s=found.stamp_s,
                now_s=found.stamp_s + robot.realtime.behind_s(world),
                moved_at_s=found.moved_at_s,
                collisions=found.collisions,
                touching=found.touching,
                e_stop_on=world.e_stop_on,
                real_time=Pacing(factor=pace.factor, factor_recent=pace.factor_recent, time_s=pace.time_s),
                last_audio=robot.last_audio(),
            )

        return await ask(look)

    @app.get("/score")
    @requires_role(Role.VIEWER)
    async def score_now(  # pyright: ignore[reportUnusedFunction]
        kind: Annotated[str, Query(min_length=1, max_length=64)],
        colour: Annotated[str | None, Query(max_length=32)] = None,
    ) -> Score:
        """Does the robot, where it stands now, count as having found the thing?"""
        try:
            return await ask(lambda world: score(world, kind, colour))
        except NothingToScoreError as error:
            raise NotFoundError(str(error)) from error

    @app.get("/home")
    @requires_role(Role.VIEWER)
    async def whole_home() -> Home:  # pyright: ignore[reportUnusedFunction]
        """The home as it was generated or loaded: rooms, walls, doors, furniture, things, dock."""
        return home

    return app
