"""Composition root: the bridge's app from its settings, a bus and a robot."""

import asyncio
import contextlib
from collections.abc import AsyncGenerator, Callable, Sequence
from typing import TypedDict

import structlog
from fastapi import FastAPI, Request

from contracts.problem import Dependency
from mesh.app import make_app
from mesh.bus import Bus, open_bus
from mesh.clock import Clock, SystemClock
from mesh.errors import UnavailableError
from mesh.tasks import Tasks, end_this_process
from robot_bridge.arm.port import RobotArm
from robot_bridge.bridge import Bridge, open_bridge
from robot_bridge.metrics import measure
from robot_bridge.ports import LiveView, Robot
from robot_bridge.routes import routers
from robot_bridge.routes.stop import STOP_PATHS
from robot_bridge.settings import Settings

log = structlog.get_logger()


class State(TypedDict):
    bridge: Bridge


def create_app(
    settings: Settings,
    *,
    bus: Bus | None = None,
    robot: Robot | None = None,
    clock: Clock | None = None,
    live_view: LiveView | None = None,
    arm: RobotArm | None = None,
    on_death: Callable[[], None] = end_this_process,
) -> FastAPI:
    """The real bus and the real robot unless others are given; nothing is opened before the app starts.

    A given robot has the given arm, the real one what the settings say.
    """

    @contextlib.asynccontextmanager
    async def lifespan(_: FastAPI) -> AsyncGenerator[State]:
        async with contextlib.AsyncExitStack() as stack:
            the_bus = (
                bus
                if bus is not None
                else await stack.enter_async_context(open_bus(settings.redis_url, settings.own_key))
            )
            tasks = await stack.enter_async_context(Tasks(on_death=on_death))
            the_clock = clock if clock is not None else SystemClock()
            the_robot, the_arm = (robot, arm) if robot is not None else _ros_robot(settings, the_clock, on_death)
            view = live_view if live_view is not None else await _live_view(settings)
            if view is not None:
                stack.push_async_callback(asyncio.to_thread, view.close)  # once the robot stands
            bridge = await stack.enter_async_context(
                open_bridge(settings, the_robot, the_bus, the_clock, tasks, live_view=view, arm=the_arm)
            )
            yield {"bridge": bridge}

    app = make_app(
        "robot_bridge",
        lifespan=lifespan,
        dependencies=_dependencies,
        settings=settings,
        measure=_measure,
        body_bytes_max=settings.body_bytes_max,
        body_bytes_max_at=dict.fromkeys(STOP_PATHS),
        open_to_pages=STOP_PATHS,
        description="The one hand on the robot: what moves it, and what it senses.",
    )
    for router in routers():
        app.include_router(router)
    return app


async def _dependencies(request: Request) -> Sequence[Dependency]:
    bridge: Bridge = request.state.bridge
    return bridge.dependencies()


async def _measure(request: Request) -> None:
    measure(request.state.bridge)


async def _live_view(settings: Settings) -> LiveView | None:
    """None where none is wanted, or none can be had: the log says why, and the robot is served all the same."""
    if (port := settings.foxglove_port) is None:
        return None
    try:
        from robot_bridge.adapters.foxglove import open_foxglove

        return await asyncio.to_thread(open_foxglove, port)
    except ImportError as error:
        log.error("no live view: pip install 'atom-robot-bridge[foxglove]'", error=str(error))  # noqa: TRY400
    except UnavailableError as error:
        log.error("no live view", error=str(error))  # noqa: TRY400
    return None


def _ros_robot(settings: Settings, clock: Clock, on_death: Callable[[], None]) -> tuple[Robot, RobotArm | None]:
    from robot_bridge.adapters.ros import RosRobot  # the only way to rclpy; a test with a fake robot never takes it

    robot = RosRobot(settings, clock, on_death=on_death)
    return robot, robot.arm
