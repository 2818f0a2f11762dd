"""The ear's ports in memory, and the services it asks behind real HTTP: what they were told is kept."""

import asyncio
import contextlib
from collections.abc import AsyncGenerator, AsyncIterator, Sequence
from dataclasses import dataclass, field

from fastapi import FastAPI, Query, WebSocket, WebSocketDisconnect

from contracts.asking import About, Answer, Question
from contracts.colours import Colour
from contracts.intent import Intent, Understand, Understood, WantedAction
from contracts.mission import (
    EventKind,
    Heard,
    Mission,
    MissionEvent,
    MissionState,
    MissionStatus,
    Outcome,
    StartMission,
)
from contracts.reading import Mood
from contracts.robot import EmergencyStop, EmergencyStopReply, EmergencyStopRequest
from contracts.speech import Hearing, SpeakRequest, Transcript
from contracts.vision import Target
from ear.ports import Line
from mesh.errors import UnavailableError, UpstreamError

RUNNING = Mission(
    id="m1",
    command="find the red bottle",
    target=Target(label="bottle", colour=Colour.RED, description="red bottle"),
    state=MissionState.MEMORY_NAV,
    started_s=1.0,
)
FOUND = RUNNING.model_copy(update={"outcome": Outcome.FOUND, "state": MissionState.IDLE})


def transcript(text: str, hot: str | None = None, *, stop: bool = False) -> Transcript:
    return Transcript(
        text=text,
        hot_text=text if hot is None else hot,
        agree=hot is None,
        stop=stop,
        no_speech=not text,
        language="en",
        duration_s=1.0,
        took_ms=1.0,
        engine="fake",
    )


def understood(command: str) -> Understood:
    return Understood(intent=Intent(action=WantedAction.FIND, command=command, mood=Mood.FIND))


class FakeSource:
    def __init__(self) -> None:
        self.given: asyncio.Queue[bytes | None] = asyncio.Queue()

    async def chunks(self) -> AsyncIterator[bytes]:
        while (chunk := await self.given.get()) is not None:
            yield chunk


class FakeLoudspeaker:
    """Plays until `quiet` is set, where `waits`."""

    def __init__(self) -> None:
        self.played: list[bytes] = []
        self.waits = False
        self.quiet = asyncio.Event()

    async def play(self, wav: bytes) -> None:
        self.played.append(wav)
        if self.waits:
            await self.quiet.wait()


class FakeWakeWord:
    """The word is in a chunk that begins with `WORD`."""

    WORD = b"\x01\x00"

    def __init__(self) -> None:
        self.told: list[bytes] = []
        self.forgot = 0

    def heard(self, samples: bytes) -> bool:
        self.told.append(samples)
        return samples.startswith(self.WORD)

    def forget(self) -> None:
        self.forgot += 1


def _set() -> asyncio.Event:
    event = asyncio.Event()
    event.set()
    return event


@dataclass
class FakeEars:
    sent: list[bytes] = field(default_factory=list[bytes])
    told: "asyncio.Queue[Hearing | UnavailableError]" = field(default_factory=asyncio.Queue)

    async def send(self, samples: bytes) -> None:
        self.sent.append(samples)

    async def end(self) -> None: ...

    async def hearings(self) -> AsyncIterator[Hearing]:
        while True:
            hearing = await self.told.get()
            if isinstance(hearing, UnavailableError):
                raise hearing
            yield hearing
            if hearing.final:
                return

    def tell(self, said: Transcript, *, final: bool = True) -> None:
        self.told.put_nowait(Hearing(final=final, stop=said.stop, transcript=said))


@dataclass
class FakeSpeech:
    lines: list[FakeEars] = field(default_factory=list[FakeEars])
    spoken: list[str] = field(default_factory=list[str])
    read: list[bytes] = field(default_factory=list[bytes])
    short: Transcript = field(default_factory=lambda: transcript(""))
    away: bool = False
    closes: asyncio.Event = field(default_factory=_set)
    """Until it is set, no line comes to its close."""
    reads: asyncio.Event = field(default_factory=_set)
    """Until it is set, no short saying comes back."""

    @contextlib.asynccontextmanager
    async def listen(self, hot_words: Sequence[str]) -> AsyncGenerator[FakeEars]:
        if self.away:
            raise UnavailableError("speech", "not reachable")
        self.lines.append(FakeEars())
        yield self.lines[-1]
        await self.closes.wait()

    async def transcribe(self, samples: bytes) -> Transcript:
        self.read.append(samples)
        await self.reads.wait()
        return self.short

    async def speak(self, request: SpeakRequest) -> bytes:
        if self.away:
            raise UnavailableError("speech", "not reachable")
        self.spoken.append(request.text)
        return request.text.encode()


@dataclass
class FakeCoordinator:
    means: Understood = field(default_factory=lambda: understood("find the red bottle"))
    running: Mission | None = None
    state: MissionState = MissionState.IDLE
    queue: tuple[Mission, ...] = ()
    away: bool = False
    understands: asyncio.Event = field(default_factory=_set)
    """Until it is set, a reading has no answer; the next are of a status, a record of a mission, and a hold."""
    says_how_it_is: asyncio.Event = field(default_factory=_set)
    tells: asyncio.Event = field(default_factory=_set)
    obeys: asyncio.Event = field(default_factory=_set)
    asked: list[tuple[str, ...]] = field(default_factory=list[tuple[str, ...]])
    commands: list[str] = field(default_factory=list[str])
    holds: list[float] = field(default_factory=list[float])
    held: list[str] = field(default_factory=list[str])
    """Which mission each of the holds was for."""
    refuses: str = ""
    happened: "asyncio.Queue[MissionEvent | Line]" = field(default_factory=asyncio.Queue)

    async def understand(self, readings: Sequence[str]) -> Understood:
        self.asked.append(tuple(readings))
        await self.understands.wait()
        return self.means

    async def start(self, command: str) -> Mission | Heard:
        if self.refuses:
            raise UpstreamError("coordinator", 409, self.refuses)
        self.commands.append(command)
        return RUNNING

    async def ask(self, question: str) -> Answer:
        return Answer(answer="It is in the kitchen.", about=About.DOING, phrased_by="template")

    async def status(self) -> MissionStatus:
        """As it is when it is asked, however late it answers."""
        status = MissionStatus(stamp_s=1.0, state=self.state, mission=self.running, queue=self.queue)
        await self.says_how_it_is.wait()
        if self.away:
            raise UnavailableError("coordinator", "not reachable")
        return status

    async def mission(self, mission_id: str) -> Mission:
        await self.tells.wait()
        return FOUND

    async def hold(self, mission_id: str, *, for_s: float) -> Mission:
        self.holds.append(for_s)
        self.held.append(mission_id)
        await self.obeys.wait()
        if self.away:
            raise UnavailableError("coordinator", "no answer in time")
        return RUNNING.model_copy(update={"id": mission_id, "paused": for_s > 0.0})

    async def events(self) -> AsyncIterator[MissionEvent | Line]:
        yield Line.OPEN
        while True:
            yield await self.happened.get()

    def happens(self, kind: EventKind, now_s: float, state: MissionState = MissionState.IDLE) -> None:
        self.happened.put_nowait(
            MissionEvent(id=1, mission_id="m1", stamp_s=now_s, state=state, kind=kind, text=kind.value)
        )


@dataclass
class FakeRobot:
    stops: list[str] = field(default_factory=list[str])
    deaf: int = 0
    """So many stops get no answer."""

    async def emergency_stop(self, request: EmergencyStopRequest) -> EmergencyStopReply:
        if self.deaf:
            self.deaf -= 1
            raise UnavailableError("robot_bridge", "not reachable")
        self.stops.append(request.reason)
        return stop_reply()


def stop_reply() -> EmergencyStopReply:
    return EmergencyStopReply(state=EmergencyStop(latched=True, epoch=1, reason="said", by="ear", since_s=1.0))


def served_coordinator(coordinator: FakeCoordinator, robot: FakeRobot) -> FastAPI:
    """The routes of coordinator and robot_bridge that the ear asks, with the contracts' types."""
    app = FastAPI()

    @app.post("/understand")
    async def understand(body: Understand) -> Understood:
        return await coordinator.understand(body.readings)

    @app.post("/missions", status_code=201)
    async def start(body: StartMission) -> Mission | Heard:
        return await coordinator.start(body.command)

    @app.post("/ask")
    async def ask(body: Question) -> Answer:
        return await coordinator.ask(body.question)

    @app.get("/state")
    async def state() -> MissionStatus:
        return await coordinator.status()

    @app.get("/missions/{mission_id}")
    async def mission(mission_id: str) -> Mission:
        return await coordinator.mission(mission_id)

    @app.post("/missions/{mission_id}/pause")
    async def pause(mission_id: str, for_s: float = Query()) -> Mission:
        return await coordinator.hold(mission_id, for_s=for_s)

    @app.post("/emergency-stop")
    async def emergency_stop(body: EmergencyStopRequest) -> EmergencyStopReply:
        return await robot.emergency_stop(body)

    @app.websocket("/events")
    async def events(socket: WebSocket) -> None:
        await socket.accept()
        with contextlib.suppress(WebSocketDisconnect, RuntimeError):
            async for event in coordinator.events():
                if isinstance(event, Line):
                    continue
                await socket.send_text(event.model_dump_json())

    return app
