"""Fakes of everything the page talks to, and a small home for them to tell of."""

import asyncio
import io
import math
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from typing import Any, Final

import httpx
import numpy as np
from nicegui import app as nicegui_app
from PIL import Image, ImageDraw

from contracts.actions import Action, ActionReply
from contracts.asking import About, Answer
from contracts.belief import ChosenView, NoBelief, SearchBelief
from contracts.causes import GoalCause, Refusal
from contracts.geometry import Point3D, Pose2D, Twist2D
from contracts.intent import Choice, Intent, Understood, WantedAction
from contracts.laser import LaserScan
from contracts.memory import ImportReply, LabelCount, ObjectState, RememberedObject, View
from contracts.mission import Heard, Mission, MissionEvent, MissionState, MissionStatus, Outcome
from contracts.motion import BaseEnd, BaseReply, EndedMotion, MotionEnd, RotateReply, RotateRequest
from contracts.problem import Dependency, DependencyState
from contracts.reading import Mood
from contracts.robot import (
    Battery,
    EmergencyStop,
    EmergencyStopReply,
    EmergencyStopRequest,
    Goal,
    GoalRequest,
    GoalStatus,
    Map,
    NavigationState,
    PathReply,
    PathRequest,
    RobotState,
    SensorState,
    SensorStatus,
    VelocityReply,
    VelocityRequest,
)
from contracts.rooms import NamedBy, NamedRoom, RoomGrid, RoomsReply
from contracts.speech import Hearing, SpeakRequest, Transcript
from contracts.vision import Target, Verdict, Vote
from geometry import probability_grids
from geometry.grids import OccupancyGrid, encode
from mesh.errors import UnavailableError, UpstreamError
from mesh.http import ServiceClient
from speech.sound import to_wav
from support.bus import MemoryBus
from support.described import described_bus
from ui.overlay import CameraFrame

STARTED_S: Final = 1_800_000_000.0
FIRST_ZERO_MS: Final = 2.4


def home_map(width: int = 180, height: int = 150) -> Map:
    """Four rooms with doors, 5 cm cells, unknown all round."""
    cells = np.full((height, width), -1, np.int8)
    cells[15:135, 15:165] = 0
    for wall in (np.s_[15:18, 15:165], np.s_[132:135, 15:165], np.s_[15:135, 15:18], np.s_[15:135, 162:165]):
        cells[wall] = 100
    cells[72:75, 15:165] = 100
    cells[15:135, 88:91] = 100
    for door in (np.s_[72:75, 40:58], np.s_[72:75, 120:138], np.s_[40:58, 88:91], np.s_[96:114, 88:91]):
        cells[door] = 0
    for table in (np.s_[25:40, 110:140], np.s_[100:118, 30:52], np.s_[20:32, 22:34]):
        cells[table] = 100
    return packed(cells, Pose2D(x=-4.5, y=-3.75, yaw=0.0))


def packed(cells: np.ndarray, origin: Pose2D, resolution_m: float = 0.05) -> Map:
    return encode(OccupancyGrid(cells.astype(np.int8), resolution_m, origin))


def robot_state(pose: Pose2D | None = None, *, stop: EmergencyStop | None = None, docked: bool = False) -> RobotState:
    names = ("battery", "depth", "map", "odom", "pose", "rgb", "scan")
    return RobotState(
        stamp_s=STARTED_S,
        pose=pose or Pose2D(x=-2.0, y=-1.5, yaw=0.6),
        twist=Twist2D(linear_x=0.2),
        battery=Battery(percentage=87.0),
        docked=docked,
        navigation=NavigationState.IDLE,
        emergency_stop=stop or EmergencyStop(latched=False, epoch=0),
        sensors={
            name: SensorStatus(state=SensorState.STALE if name == "depth" else SensorState.FRESH, age_s=0.1)
            for name in names
        },
    )


def votes() -> tuple[Vote, ...]:
    return (
        Vote(voter="detector", verdict=Verdict.YES, score=0.81, threshold=0.3),
        Vote(voter="clip", verdict=Verdict.YES, score=0.62, threshold=0.45),
        Vote(voter="vlm", verdict=Verdict.ABSTAIN, reason="no vision-language model"),
    )


def mission(command: str = "find the red bottle", **changes: Any) -> Mission:
    values: dict[str, object] = {
        "id": "m-1",
        "command": command,
        "target": Target(label="bottle", description="red bottle"),
        "state": MissionState.SCANNING,
        "started_s": STARTED_S,
        "metres_driven_m": 6.4,
    }
    return Mission.model_validate(values | changes)


def status(of: Mission | None = None, **changes: object) -> MissionStatus:
    values: dict[str, object] = {
        "stamp_s": STARTED_S + 42.0,
        "state": of.state if of is not None else MissionState.IDLE,
        "mission": of,
        "progress": "turning to the next of 8 headings" if of is not None else "",
    }
    return MissionStatus.model_validate(values | changes)


def search_belief(mission_id: str = "m-1", **changes: Any) -> SearchBelief:
    """Of the home of `home_map`: half of it in a corner, 20 % that it is not here, the rest spread over the floor."""
    cells = np.zeros((50, 60))
    cells[5:45, 5:55] = 0.3 / 2000
    cells[8:12, 40:45] += 0.5 / 20
    values: dict[str, Any] = {
        "stamp_s": STARTED_S + 42.0,
        "mission_id": mission_id,
        "grid": probability_grids.encode(cells, resolution_m=0.15, origin=Pose2D(x=-4.5, y=-3.75, yaw=0.0)),
        "absent": 0.2,
        "view": ChosenView(pose=Pose2D(x=1.0, y=-1.0, yaw=-0.6), headings=(-0.6, 0.1), gain=0.45, seconds=12.0),
        "why": "2 looks 3.1 m away, near the sink: 45% to see it, in 12 s; 80% that it is here",
    }
    return SearchBelief.model_validate(values | changes)


def event(number: int, text: str, **changes: object) -> MissionEvent:
    values: dict[str, object] = {
        "id": number,
        "mission_id": "m-1",
        "stamp_s": STARTED_S + number,
        "state": MissionState.SCANNING,
        "kind": "state",
        "text": text,
    }
    return MissionEvent.model_validate(values | changes)


@dataclass
class Service:
    name: str
    away: bool = False

    async def dependency(self) -> Dependency:
        if self.away:
            detail = "not reachable (ConnectError)"
            return Dependency(name=self.name, state=DependencyState.UNREACHABLE, detail=detail)
        return Dependency.of(self.name, ok=True)

    def answer(self) -> None:
        if self.away:
            raise UnavailableError(self.name, "not reachable")


@dataclass
class FakeRobot(Service):
    name: str = "robot_bridge"
    stops: list[EmergencyStopRequest] = field(default_factory=list)
    resets: list[EmergencyStopRequest] = field(default_factory=list)
    asked: list[str] = field(default_factory=list)
    grid: Map = field(default_factory=home_map)
    stop: EmergencyStop = field(default_factory=lambda: EmergencyStop(latched=False, epoch=0))
    frames: int = 0
    scans: int = 0
    nothing_new: bool = False
    no_way: str = ""
    goals: list[GoalRequest] = field(default_factory=list)
    turns: list[float] = field(default_factory=list)
    velocities: list[VelocityRequest] = field(default_factory=list)
    lines_open: int = 0
    knows_the_page: bool = True

    async def emergency_stop(self, request: EmergencyStopRequest) -> EmergencyStopReply:
        self.answer()
        self.stops.append(request)
        self.stop = EmergencyStop(latched=True, epoch=len(self.stops), reason=request.reason, by=request.by)
        return EmergencyStopReply(state=self.stop, first_zero_ms=FIRST_ZERO_MS)

    async def reset(self, request: EmergencyStopRequest) -> EmergencyStopReply:
        self.answer()
        self.resets.append(request)
        self.stop = EmergencyStop(latched=False, epoch=self.stop.epoch, reason=request.reason, by=request.by)
        return EmergencyStopReply(state=self.stop)

    async def state(self) -> RobotState:
        self.answer()
        self.asked.append("state")
        return robot_state(stop=self.stop)

    async def map(self) -> Map:
        self.answer()
        self.asked.append("map")
        return self.grid

    async def stop_state(self) -> EmergencyStop:
        self.answer()
        if not self.knows_the_page:
            raise UpstreamError(self.name, 401, "this key is not known")
        return self.stop

    async def stop_answers(self) -> None:
        self.asked.append("stop answers")
        self.answer()

    async def frame(self, *, after_s: float | None, wait_s: float) -> CameraFrame | None:
        """Every ask is answered by another frame, as a camera would."""
        self.answer()
        if self.nothing_new:
            return None
        self.frames += 1
        return CameraFrame(STARTED_S + self.frames, camera_jpeg(self.frames), 250, 250, Pose2D(x=0.0, y=0.0, yaw=0.0))

    async def scan(self) -> LaserScan:
        self.answer()
        points = tuple((2.0 * math.cos(i / 10), 2.0 * math.sin(i / 10)) for i in range(62))
        self.scans += 1
        return LaserScan(stamp_s=STARTED_S + self.scans, pose=Pose2D(x=-2.0, y=-1.5, yaw=0.6), points_m=points)

    async def go(self, request: GoalRequest) -> Goal:
        self.answer()
        self.goals.append(request)
        if self.no_way:
            return Goal(
                id="g", pose=request.candidates[0].pose, status=GoalStatus.REJECTED, cause=GoalCause.REJECTED,
                error_msg=self.no_way, stamp_s=STARTED_S,
            )  # fmt: skip
        return Goal(id="g", pose=request.candidates[0].pose, status=GoalStatus.EXECUTING, stamp_s=STARTED_S)

    async def cancel_goal(self, goal_id: str) -> Goal:
        self.answer()
        self.asked.append(f"cancel {goal_id}")
        return Goal(id=goal_id, pose=Pose2D(x=0.0, y=0.0, yaw=0.0), status=GoalStatus.CANCELED, stamp_s=STARTED_S)

    async def path(self, request: PathRequest) -> PathReply:
        self.answer()
        return PathReply(reachable=True, length_m=1.0, poses=(Pose2D(x=-2.0, y=-1.5, yaw=0.0), request.goal))

    async def rotate(self, request: RotateRequest) -> RotateReply:
        self.answer()
        self.turns.append(request.angle_rad)
        return RotateReply(end=MotionEnd.COMPLETED, turned_rad=request.angle_rad)

    async def end_motion(self) -> EndedMotion:
        self.answer()
        self.asked.append("end motion")
        return EndedMotion()

    async def celebrate(self) -> BaseReply:
        self.answer()
        self.asked.append("celebrate")
        return BaseReply(end=BaseEnd.COMPLETED)

    @asynccontextmanager
    async def wheels(self) -> AsyncIterator["FakeWheels"]:
        self.answer()
        line = FakeWheels(self)
        self.lines_open += 1
        try:
            yield line
        finally:
            self.lines_open -= 1

    async def dock(self) -> BaseReply:
        self.answer()
        self.asked.append("dock")
        return BaseReply(end=BaseEnd.COMPLETED)

    async def undock(self) -> BaseReply:
        self.answer()
        self.asked.append("undock")
        return BaseReply(end=BaseEnd.GAVE_UP, text=BaseEnd.GAVE_UP.sentence)


@dataclass
class FakeEars:
    """Says the prepared readings: all but the last when sound comes, the last when it ends."""

    speech: "FakeSpeech"
    heard: bytearray = field(default_factory=bytearray)
    ended: asyncio.Event = field(default_factory=asyncio.Event)
    begun: asyncio.Event = field(default_factory=asyncio.Event)
    held: bool = False

    async def not_held(self) -> None:
        self.held = False

    async def send(self, samples: bytes) -> None:
        self.heard += samples
        self.begun.set()

    async def end(self) -> None:
        self.begun.set()
        self.ended.set()

    async def hearings(self) -> AsyncIterator[Hearing]:
        await self.begun.wait()
        *partial, final = self.speech.readings
        for one in partial:
            yield one
        if not self.speech.ends_by_itself:
            await self.ended.wait()
        self.speech.answer()
        yield final


@dataclass
class FakeSpeech(Service):
    name: str = "speech"
    readings: tuple[Hearing, ...] = ()
    ends_by_itself: bool = False
    ears: list[FakeEars] = field(default_factory=list)
    hot_words: list[str] = field(default_factory=list)
    spoken: list[str] = field(default_factory=list)

    @asynccontextmanager
    async def listen(self, hot_words: Sequence[str], *, held: bool = False) -> AsyncIterator[FakeEars]:
        self.answer()
        self.hot_words = list(hot_words)
        self.ears.append(FakeEars(self, held=held))
        yield self.ears[-1]

    async def speak(self, request: SpeakRequest) -> bytes:
        self.answer()
        self.spoken.append(request.text)
        return to_wav(np.zeros(2400, np.float32), 24_000)


def hearing(text: str, hot: str | None = None, *, final: bool = True, stop: bool = False) -> Hearing:
    """A reading as the speech service tells it."""
    hot = text if hot is None else hot
    return Hearing(
        final=final,
        stop=stop,
        transcript=Transcript(
            text=text, hot_text=hot, agree=text == hot, stop=stop, no_speech=not text, language="en", duration_s=1.0,
            took_ms=300.0, engine="fake",
        ),
    )  # fmt: skip


@dataclass
class FakeWheels:
    """Refuses what the bridge would: another epoch's requests, and all while stopped."""

    robot: FakeRobot

    async def send(self, request: VelocityRequest) -> VelocityReply:
        self.robot.answer()
        if self.robot.stop.latched or request.epoch != self.robot.stop.epoch:
            return VelocityReply(accepted=False, sent=Twist2D(), refusal=Refusal.OLD_EPOCH, reason="the epoch is over")
        self.robot.velocities.append(request)
        return VelocityReply(accepted=True, sent=request.twist)


@dataclass
class FakeInference:
    """Says that it is ready, unless it is away."""

    away: bool = False

    def client(self) -> ServiceClient:
        return ServiceClient("inference", "http://inference", transport=httpx.MockTransport(self._answer))

    def _answer(self, request: httpx.Request) -> httpx.Response:
        if self.away:
            raise httpx.ConnectError("away", request=request)
        return httpx.Response(200, json={"service": "inference", "ready": True, "dependencies": []})


def camera_jpeg(number: int) -> bytes:
    """A room with a bottle and a box round it, as inference would send."""
    image = Image.new("RGB", (480, 502), (214, 207, 196))
    draw = ImageDraw.Draw(image)
    draw.rectangle((0, 300, 480, 480), fill=(150, 122, 95))
    draw.rectangle((60, 250, 420, 330), fill=(120, 92, 66))
    sway = 6 * math.sin(number / 3)
    draw.rounded_rectangle((215 + sway, 150, 255 + sway, 250), 12, fill=(190, 30, 36))
    draw.rectangle((205 + sway, 140, 265 + sway, 254), outline=(230, 30, 30), width=3)
    draw.rectangle((0, 480, 480, 502), fill=(20, 20, 20))
    draw.text((8, 485), "Looking for: red bottle", fill=(255, 255, 255))
    out = io.BytesIO()
    image.save(out, "JPEG", quality=80)
    return out.getvalue()


@dataclass
class FakeMissions(Service):
    name: str = "coordinator"
    commands: list[str] = field(default_factory=list)
    understands: list[tuple[str, ...]] = field(default_factory=list)
    understood: Understood | None = None
    acted: list[tuple[str, str]] = field(default_factory=list)
    done: list[Action] = field(default_factory=list[Action])
    keys: list[str] = field(default_factory=list)
    past: tuple[Mission, ...] = ()
    refusal: str = ""
    heard: Heard | None = None
    hangs: bool = False
    current: MissionStatus = field(default_factory=status)
    timeline: tuple[MissionEvent, ...] = ()
    believed: SearchBelief | NoBelief = NoBelief.ANOTHER_RULE
    beliefs_asked: list[str] = field(default_factory=list)

    async def start(self, command: str, *, key: str) -> Mission | Heard:
        if self.hangs:
            await asyncio.Event().wait()
        self.answer()
        self.keys.append(key)
        if self.refusal:
            raise UpstreamError(self.name, 422, self.refusal)
        self.commands.append(command)
        return self.heard or mission(command)

    async def ask(self, question: str) -> Answer:
        self.answer()
        return Answer(answer=f"You asked: {question}", about=About.LAST_SEEN, phrased_by="template")

    async def do(self, action: Action) -> ActionReply:
        self.answer()
        if self.refusal:
            raise UpstreamError(self.name, 409, self.refusal)
        self.done.append(action)
        return ActionReply(action=action.action, text="begun", mission=mission(action.action.value))

    async def understand(self, readings: Sequence[str]) -> Understood:
        if self.hangs:
            await asyncio.Event().wait()
        self.answer()
        self.understands.append(tuple(readings))
        if self.understood is not None:
            return self.understood
        intents = [Intent(action=WantedAction.FIND, command=one, mood=Mood.FIND) for one in readings]
        if len(intents) == 1:
            return Understood(intent=intents[0])
        choices = tuple(Choice(text=one.command, intent=one) for one in intents)
        return Understood(question=f"Did you mean: {', or '.join(readings)}?", choices=choices)

    async def newest(self, limit: int) -> Sequence[Mission]:
        self.answer()
        return self.past[:limit]

    async def belief(self, mission_id: str) -> SearchBelief | NoBelief:
        self.answer()
        self.beliefs_asked.append(mission_id)
        return self.believed

    async def picture(self, mission_id: str, number: int) -> bytes:
        self.answer()
        return camera_jpeg(number)

    async def pause(self, mission_id: str) -> Mission:
        return self._act("pause", mission_id, paused=True)

    async def resume(self, mission_id: str) -> Mission:
        return self._act("resume", mission_id)

    async def cancel(self, mission_id: str) -> Mission:
        return self._act("cancel", mission_id, outcome=Outcome.CANCELED)

    def _act(self, what: str, mission_id: str, **changes: Any) -> Mission:
        self.answer()
        self.acted.append((what, mission_id))
        return mission(**changes)

    async def status(self) -> MissionStatus:
        self.answer()
        return self.current

    async def events(self, mission_id: str) -> Sequence[MissionEvent]:
        self.answer()
        return tuple(one for one in self.timeline if one.mission_id == mission_id)


def thing(number: int, description: str = "red bottle", **changes: object) -> RememberedObject:
    values: dict[str, object] = {
        "id": number,
        "label": description.rsplit(maxsplit=1)[-1],
        "description": description,
        "position": Point3D(x=1.0, y=0.5, z=0.4),
        "uncertainty_m": 0.1,
        "belief": 0.8,
        "state": ObjectState.PRESENT,
        "confidence": 0.9,
        "first_seen_s": STARTED_S,
        "last_seen_s": STARTED_S + 10.0,
        "times_seen": 5,
    }
    return RememberedObject.model_validate(values | changes)


@dataclass
class FakeMemory(Service):
    name: str = "memory"
    things: list[RememberedObject] = field(default_factory=lambda: [thing(1), thing(2, "blue cup", belief=0.3)])
    imported: list[bytes] = field(default_factory=list)
    rooms_of: str = ""
    named_rooms: list[NamedRoom] = field(default_factory=list[NamedRoom])
    rooms_lie: RoomGrid | None = None
    grids_asked: int = 0

    async def labels(self) -> Sequence[LabelCount]:
        self.answer()
        labels = sorted({one.label for one in self.things})
        return [LabelCount(label=one, views=3, best_confidence=0.9, last_seen_s=STARTED_S) for one in labels]

    async def objects(self) -> Sequence[RememberedObject]:
        self.answer()
        return tuple(self.things)

    async def views(self) -> Sequence[View]:
        self.answer()
        pose = Pose2D(x=0.5, y=0.5, yaw=0.0)
        return [View(id=1, label="bottle", confidence=0.9, pose=pose, stamp_s=STARTED_S, colour="red")]

    async def rooms(self) -> RoomsReply:
        self.answer()
        return RoomsReply(map_id=self.rooms_of, rooms=tuple(self.named_rooms))

    async def room_grid(self) -> RoomGrid:
        self.answer()
        self.grids_asked += 1
        if self.rooms_lie is None:
            raise UpstreamError("memory", 404, "there is no map now that is cut into rooms")
        return self.rooms_lie

    async def name_room(self, room_id: int, name: str) -> NamedRoom:
        self.answer()
        for at, one in enumerate(self.named_rooms):
            if one.id == room_id:
                by = NamedBy.PERSON if name else NamedBy.NOBODY
                new = {"name": name or f"unnamed room {room_id}", "named_by": by}
                self.named_rooms[at] = one.model_copy(update=new)
                return self.named_rooms[at]
        raise UpstreamError("memory", 404, f"the map has no room {room_id}")

    async def forget_object(self, object_id: int) -> int:
        return self._forget(lambda one: one.id == object_id)

    async def forget_label(self, label: str) -> int:
        return self._forget(lambda one: one.label == label)

    def _forget(self, gone: Callable[[RememberedObject], bool]) -> int:
        self.answer()
        before = len(self.things)
        self.things = [one for one in self.things if not gone(one)]
        return before - len(self.things)

    async def export(self) -> bytes:
        self.answer()
        return b'{"form":"full"}\n'

    async def import_(self, data: bytes) -> ImportReply:
        self.answer()
        self.imported.append(data)
        return ImportReply(objects=2, views=3)


@dataclass
class UiWorld:
    bus: MemoryBus = field(default_factory=described_bus)
    robot: FakeRobot = field(default_factory=FakeRobot)
    inference: FakeInference = field(default_factory=FakeInference)
    missions: FakeMissions = field(default_factory=FakeMissions)
    memory: FakeMemory = field(default_factory=FakeMemory)
    speech: FakeSpeech = field(default_factory=FakeSpeech)


def fresh_nicegui() -> None:
    """NiceGUI is one a process and takes no more middleware once it has served; tests make several apps."""
    nicegui_app.middleware_stack = None
    nicegui_app.user_middleware.clear()
