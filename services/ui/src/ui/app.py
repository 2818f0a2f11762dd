"""The composition root: the only place that knows which twins are real."""

import contextlib
from collections.abc import AsyncGenerator, Callable, Sequence
from contextlib import aclosing
from typing import TypedDict

from fastapi import FastAPI, Request

from clients.speech import SpeechClient
from contracts.problem import Dependency
from mesh.app import make_app
from mesh.bus import Bus, open_bus
from mesh.clock import Clock, SystemClock
from mesh.http import ServiceClient
from mesh.tasks import Tasks, end_this_process
from ui import i18n, page
from ui.adapters.coordinator import CoordinatorClient
from ui.adapters.memory import MemoryClient
from ui.adapters.robot_bridge import RobotBridgeClient
from ui.desk import Desk
from ui.page_socket import PageSocketErrors
from ui.ports import Memory, Missions, Robot, Speech
from ui.prefix import BelowPrefix
from ui.routes import routers
from ui.routes.deps import desk_of
from ui.routes.log_in import LOG_IN_PATH
from ui.routes.stop import STOP_PATHS
from ui.sessions import PageSessions
from ui.settings import Settings


class State(TypedDict):
    desk: Desk
    sessions: PageSessions | None


def create_app(
    settings: Settings,
    *,
    bus: Bus | None = None,
    robot: Robot | None = None,
    inference: ServiceClient | None = None,
    missions: Missions | None = None,
    memory: Memory | None = None,
    speech: Speech | None = None,
    clock: Clock | None = None,
    on_death: Callable[[], None] = end_this_process,
) -> FastAPI:
    """The service; whatever is not given is the real thing that `settings` name. NiceGUI allows one a process."""

    i18n.use(i18n.load(settings.texts_file))
    sessions = _sessions(settings)

    @contextlib.asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncGenerator[State]:
        async with contextlib.AsyncExitStack() as stack:
            closing = stack.enter_async_context
            desk = Desk(
                settings=settings,
                bus=bus if bus is not None else await closing(open_bus(settings.redis_url, settings.own_key)),
                robot=robot if robot is not None else await closing(aclosing(RobotBridgeClient(settings))),
                inference=inference
                if inference is not None
                else await closing(
                    aclosing(
                        ServiceClient(
                            "inference", settings.inference_url, key=settings.own_key, timeout_s=settings.call_timeout_s
                        )
                    )
                ),
                missions=missions if missions is not None else await closing(aclosing(CoordinatorClient(settings))),
                memory=memory if memory is not None else await closing(aclosing(MemoryClient(settings))),
                speech=speech
                if speech is not None or not settings.speech_url
                else await closing(aclosing(SpeechClient(settings))),
                clock=clock if clock is not None else SystemClock(),
            )
            stack.push_async_callback(desk.frames.close)
            desk.start(await closing(Tasks(on_death=on_death)))
            yield {"desk": desk, "sessions": sessions}

    async def dependencies(request: Request) -> Sequence[Dependency]:
        return await desk_of(request).dependencies()

    app = make_app(
        "ui",
        lifespan=lifespan,
        dependencies=dependencies,
        settings=settings,
        authenticate_session=sessions.authenticate if sessions is not None else None,
        log_in_at=LOG_IN_PATH.removeprefix("/"),
        body_bytes_max=settings.body_bytes_max,
        body_bytes_max_at={
            "/memory/import": settings.import_bytes_max,
            **dict.fromkeys(STOP_PATHS),
        },  # a stop reads none
        open_to_pages=STOP_PATHS,
        description="Shows: the operator's web page.",
    )
    for router in routers():
        app.include_router(router)
    page.mount(app, language=settings.language)
    app.add_middleware(PageSocketErrors)
    app.add_middleware(BelowPrefix, prefix=settings.prefix)
    return app


def _sessions(settings: Settings) -> PageSessions | None:
    """None without keys: anybody may. Raises `SystemExit` where the page has no key of its own to sign with."""
    if settings.keys_file is None:
        return None
    if settings.own_key is None:
        raise SystemExit("UI_KEYS_FILE needs UI_KEY or UI_KEY_FILE: the page's own key, which signs who is logged in")
    return PageSessions(settings.own_key, settings.session_s)
