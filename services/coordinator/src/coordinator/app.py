"""The composition root: the only place that knows which twins are real."""

import contextlib
from collections.abc import AsyncGenerator, Callable, Sequence
from typing import TypedDict

from fastapi import FastAPI, Request

from contracts.problem import Dependency
from coordinator.adapters.inference import InferenceEyes
from coordinator.adapters.memory import MemoryService
from coordinator.adapters.robot_bridge import BridgeRobot
from coordinator.adapters.sqlite_log import SqliteLog
from coordinator.commands.mission_service import Missions
from coordinator.execution.dispatcher import Dispatcher
from coordinator.execution.look_reporter import Looks
from coordinator.execution.mission_runner import Runner
from coordinator.ports import Eyes, Memory, MissionLog, Robot
from coordinator.questions.question_service import Asking
from coordinator.queue.mission_queue import Queue
from coordinator.routes import get_missions, router
from coordinator.settings import Settings
from mesh.app import make_app
from mesh.bus import Bus, open_bus
from mesh.clock import Clock, SystemClock
from mesh.tasks import Tasks, end_this_process
from vocabulary.moods import read


class State(TypedDict):
    missions: Missions
    asking: Asking


def create_app(
    settings: Settings,
    *,
    bus: Bus | None = None,
    robot: Robot | None = None,
    eyes: Eyes | None = None,
    memory: Memory | None = None,
    log: MissionLog | None = None,
    clock: Clock | None = None,
    on_death: Callable[[], None] = end_this_process,
) -> FastAPI:
    """The service; whatever is not given is the real thing that `settings` name. It starts IDLE: nothing resumes."""

    read("find the cup")  # the tables are read now, not with the first stop

    @contextlib.asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncGenerator[State]:
        async with contextlib.AsyncExitStack() as stack:
            the_bus = bus if bus is not None else await stack.enter_async_context(open_bus(settings.redis_url))
            the_clock = clock if clock is not None else SystemClock()
            the_robot = robot if robot is not None else _robot(settings, stack)
            the_eyes = eyes if eyes is not None else _eyes(settings, stack)
            the_memory = memory if memory is not None else _memory(settings, stack)
            tasks = await stack.enter_async_context(Tasks(on_death=on_death))
            the_log = log if log is not None else await _log(settings, stack, tasks, the_clock)
            queue = Queue(settings.queue_max)
            looks = Looks(the_memory, the_clock, hfov_rad=settings.camera_hfov_rad)
            runner = Runner(settings=settings, bus=the_bus, robot=the_robot, eyes=the_eyes, log_=the_log,
                            looks=looks, queue=queue, clock=the_clock, tasks=tasks)  # fmt: skip
            dispatcher = Dispatcher(settings=settings, runner=runner, queue=queue, memory=the_memory, clock=the_clock)
            runner.start()
            tasks.start("dispatch", dispatcher.run())
            missions = Missions(settings=settings, bus=the_bus, robot=the_robot, eyes=the_eyes, memory=the_memory,
                                log_=the_log, clock=the_clock, runner=runner, queue=queue,
                                dispatcher=dispatcher)  # fmt: skip
            asking = Asking(settings=settings, memory=the_memory, eyes=the_eyes, log_=the_log, runner=runner,
                            clock=the_clock)  # fmt: skip
            yield {"missions": missions, "asking": asking}

    async def dependencies(request: Request) -> Sequence[Dependency]:
        return await (await get_missions(request)).dependencies()

    app = make_app(
        "coordinator",
        lifespan=lifespan,
        dependencies=dependencies,
        body_bytes_max=settings.body_bytes_max,
        description="Decides: missions, the state machine, the search and the approach.",
    )
    app.include_router(router)
    return app


async def _log(settings: Settings, stack: contextlib.AsyncExitStack, tasks: Tasks, clock: Clock) -> SqliteLog:
    log = SqliteLog(settings)
    await log.open(clock.now_s())
    stack.push_async_callback(log.aclose)
    tasks.start("write-history", log.write_forever())
    return log


def _robot(settings: Settings, stack: contextlib.AsyncExitStack) -> BridgeRobot:
    robot = BridgeRobot(
        settings.robot_bridge_url,
        timeout_s=settings.call_timeout_s,
        heartbeat_s=settings.heartbeat_s,
        reconnect_s=settings.reconnect_s,
    )
    stack.push_async_callback(robot.aclose)
    return robot


def _eyes(settings: Settings, stack: contextlib.AsyncExitStack) -> InferenceEyes:
    eyes = InferenceEyes(
        settings.inference_url,
        timeout_s=settings.call_timeout_s,
        parse_timeout_s=settings.parse_timeout_s,
        reason_timeout_s=settings.reason_timeout_s,
    )
    stack.push_async_callback(eyes.aclose)
    return eyes


def _memory(settings: Settings, stack: contextlib.AsyncExitStack) -> MemoryService:
    memory = MemoryService(settings.memory_url, timeout_s=settings.recall_timeout_s)
    stack.push_async_callback(memory.aclose)
    return memory
