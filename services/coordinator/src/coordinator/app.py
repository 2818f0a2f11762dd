"""The composition root: the only place that knows which twins are real."""

import contextlib
from collections.abc import AsyncGenerator, Callable, Sequence
from contextlib import aclosing
from importlib.metadata import version
from typing import TypedDict

from fastapi import FastAPI, Request

from contracts.problem import Dependency
from coordinator.action_routes import router as actions_router
from coordinator.adapters import mcp_server
from coordinator.adapters.camera import CameraClient
from coordinator.adapters.camera_eye import CameraEye
from coordinator.adapters.exploration_journal import ExplorationJournal
from coordinator.adapters.inference import InferenceClient
from coordinator.adapters.mcp_resources import Resources
from coordinator.adapters.memory import MemoryClient
from coordinator.adapters.ollama_pilot import OllamaPilot
from coordinator.adapters.robot_bridge import RobotBridgeClient
from coordinator.adapters.sqlite_log import SqliteLog
from coordinator.commands.action_service import ActionService
from coordinator.commands.command_reader import CommandReader
from coordinator.commands.dispatcher import Dispatcher
from coordinator.commands.journal_service import JournalService
from coordinator.commands.mission_service import MissionService
from coordinator.execution.explorer import ExplorationNeeds
from coordinator.execution.look_reporter import LookReporter
from coordinator.execution.mission_runner import MissionRunner
from coordinator.execution.newest_view import NewestView
from coordinator.exploration.rules import ExplorationRules
from coordinator.exploration_ports import CopiedJournal, ExploringRobot, Journal
from coordinator.exploration_routes import router as exploration_router
from coordinator.ports import Camera, Inference, Memory, MissionLog
from coordinator.questions.question_service import QuestionService
from coordinator.queue.mission_queue import MissionQueue
from coordinator.routes import get_missions, router
from coordinator.settings import Settings
from mesh.app import make_app
from mesh.bus import Bus, open_bus
from mesh.clock import Clock, SystemClock
from mesh.tasks import Tasks, end_this_process
from vocabulary.moods import read


class State(TypedDict):
    missions: MissionService
    questions: QuestionService
    actions: ActionService
    mcp: mcp_server.McpServer
    journals: JournalService


def create_app(
    settings: Settings,
    *,
    bus: Bus | None = None,
    robot: ExploringRobot | None = None,
    inference: Inference | None = None,
    memory: Memory | None = None,
    camera: Camera | None = None,
    log: MissionLog | None = None,
    journal: CopiedJournal | None = None,
    clock: Clock | None = None,
    on_death: Callable[[], None] = end_this_process,
) -> FastAPI:
    """The service; whatever is not given is the real thing that `settings` name. It starts IDLE: nothing resumes."""

    read("find the cup")  # the tables are read now, not with the first stop

    @contextlib.asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncGenerator[State]:
        async with contextlib.AsyncExitStack() as stack:
            closing = stack.enter_async_context
            the_bus = bus if bus is not None else await closing(open_bus(settings.redis_url, settings.own_key))
            the_clock = clock if clock is not None else SystemClock()
            the_robot = robot if robot is not None else await closing(aclosing(RobotBridgeClient(settings)))
            the_inference = inference if inference is not None else await closing(aclosing(InferenceClient(settings)))
            the_memory = memory if memory is not None else await closing(aclosing(MemoryClient(settings)))
            the_camera = camera if camera is not None else await closing(aclosing(CameraClient(settings)))
            tasks = await closing(Tasks(on_death=on_death))
            the_log = log if log is not None else await _log(settings, stack, tasks, the_clock)
            the_journal = journal if journal is not None else await _journal(settings, stack, tasks)
            queue = MissionQueue(settings.queue_max)
            looks = LookReporter(the_memory, the_clock)
            runner = MissionRunner(
                settings=settings,
                bus=the_bus,
                robot=the_robot,
                inference=the_inference,
                log_=the_log,
                looks=looks,
                exploring=await _exploring(settings, stack, the_robot, the_camera, the_journal),
                queued=queue.records,
                clock=the_clock,
                tasks=tasks,
            )
            dispatcher = Dispatcher(settings=settings, runner=runner, queue=queue, memory=the_memory, clock=the_clock)
            runner.start()
            tasks.start("dispatch", dispatcher.run())
            reader = CommandReader(settings=settings, inference=the_inference, memory=the_memory)
            missions = MissionService(
                settings=settings,
                bus=the_bus,
                robot=the_robot,
                inference=the_inference,
                memory=the_memory,
                log_=the_log,
                clock=the_clock,
                runner=runner,
                queue=queue,
                dispatcher=dispatcher,
                reader=reader,
            )
            questions = QuestionService(
                settings=settings,
                memory=the_memory,
                inference=the_inference,
                log_=the_log,
                runner=runner,
                clock=the_clock,
            )
            view = NewestView(the_bus, the_clock)
            view.start(tasks)
            actions = ActionService(missions=missions, questions=questions, view=view, robot=the_robot)
            resources = Resources(missions=missions, robot=the_robot, memory=the_memory, camera=the_camera)
            mcp = mcp_server.McpServer(actions, resources, version=version("atom-coordinator"))
            await closing(mcp.running())
            yield {
                "missions": missions,
                "questions": questions,
                "actions": actions,
                "mcp": mcp,
                "journals": JournalService(settings, missions, the_journal),
            }

    async def dependencies(request: Request) -> Sequence[Dependency]:
        return await (await get_missions(request)).dependencies()

    async def measure(request: Request) -> None:
        (await get_missions(request)).measure()

    app = make_app(
        "coordinator",
        lifespan=lifespan,
        dependencies=dependencies,
        settings=settings,
        measure=measure,
        body_bytes_max=settings.body_bytes_max,
        body_bytes_max_at={"/restore": None, "/exploration/restore": None},
        description="Decides: missions, the state machine, the search and the approach.",
    )
    app.include_router(router)
    app.include_router(actions_router)
    app.include_router(exploration_router)
    app.router.routes.append(mcp_server.route())
    return app


async def _log(settings: Settings, stack: contextlib.AsyncExitStack, tasks: Tasks, clock: Clock) -> SqliteLog:
    log = SqliteLog(settings)
    await log.open(clock.now_s())
    stack.push_async_callback(log.aclose)
    tasks.start("write-history", log.write_forever())
    return log


async def _journal(settings: Settings, stack: contextlib.AsyncExitStack, tasks: Tasks) -> ExplorationJournal:
    journal = ExplorationJournal(settings.exploration_file, busy_timeout_s=settings.busy_timeout_s)
    stack.push_async_callback(journal.aclose)
    tasks.start("write-exploration", journal.write_forever())
    return journal


async def _exploring(
    settings: Settings, stack: contextlib.AsyncExitStack, robot: ExploringRobot, camera: Camera, journal: Journal
) -> ExplorationNeeds:
    """With a model only where one is set."""
    if not settings.exploration_model:
        return ExplorationNeeds(settings=settings, robot=robot, journal=journal)
    shown = camera if settings.exploration_pictures else None
    pilot = await stack.enter_async_context(
        aclosing(OllamaPilot(settings, timeout_s=ExplorationRules().asking.answer_s, camera=shown))
    )
    return ExplorationNeeds(settings=settings, robot=robot, journal=journal, pilot=pilot, eye=CameraEye(camera))
