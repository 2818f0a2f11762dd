"""Fakes of everything the page talks to, and a small home for them to tell of."""

import base64
import io
import math
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from nicegui import app as nicegui_app
from PIL import Image, ImageDraw

from contracts.geometry import Pose2D, Twist2D
from contracts.mission import Mission, MissionEvent, MissionState, MissionStatus, Outcome
from contracts.problem import Dependency
from contracts.robot import (
    Battery,
    EmergencyStop,
    EmergencyStopReply,
    EmergencyStopRequest,
    Map,
    MotionReply,
    NavigationState,
    RobotState,
    SensorStatus,
)
from contracts.vision import Target, Verdict, Vote
from mesh.errors import UnavailableError, UpstreamError
from support.bus import MemoryBus
from ui.ports import Frame

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
    height, width = cells.shape
    data = base64.b64encode(zlib.compress(cells.astype(np.int8).tobytes())).decode()
    return Map(width=width, height=height, resolution_m=resolution_m, origin=origin, data_base64=data)


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
        sensors={name: SensorStatus(valid=name != "depth", age_s=0.1) for name in names},
    )


def votes() -> tuple[Vote, ...]:
    return (
        Vote(voter="detector", verdict=Verdict.YES, score=0.81, threshold=0.3),
        Vote(voter="clip", verdict=Verdict.YES, score=0.62, threshold=0.45),
        Vote(voter="vlm", verdict=Verdict.ABSTAIN, reason="no vision-language model"),
    )


def mission(command: str = "find the red bottle", **changes: object) -> Mission:
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
        return Dependency(name=self.name, ok=not self.away, detail="not reachable (ConnectError)" if self.away else "")

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

    async def dock(self) -> MotionReply:
        self.answer()
        self.asked.append("dock")
        return MotionReply(completed=True, moved=0.0)

    async def undock(self) -> MotionReply:
        self.answer()
        self.asked.append("undock")
        return MotionReply(completed=False, moved=0.0, reason="the base gave up")


@dataclass
class FakeEyes(Service):
    """Every ask is answered by another frame, as a camera would."""

    name: str = "inference"
    frames: int = 0
    nothing_new: bool = False

    async def annotated(self, *, after_s: float | None, wait_s: float) -> Frame | None:
        self.answer()
        if self.nothing_new:
            return None
        self.frames += 1
        return Frame(STARTED_S + self.frames, camera_jpeg(self.frames))


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
    acted: list[tuple[str, str]] = field(default_factory=list)
    refusal: str = ""
    current: MissionStatus = field(default_factory=status)
    timeline: tuple[MissionEvent, ...] = ()

    async def start(self, command: str) -> Mission:
        self.answer()
        if self.refusal:
            raise UpstreamError(self.name, 422, self.refusal)
        self.commands.append(command)
        return mission(command)

    async def pause(self, mission_id: str) -> Mission:
        return self._act("pause", mission_id, paused=True)

    async def resume(self, mission_id: str) -> Mission:
        return self._act("resume", mission_id)

    async def cancel(self, mission_id: str) -> Mission:
        return self._act("cancel", mission_id, outcome=Outcome.CANCELED)

    def _act(self, what: str, mission_id: str, **changes: object) -> Mission:
        self.answer()
        self.acted.append((what, mission_id))
        return mission(**changes)

    async def status(self) -> MissionStatus:
        self.answer()
        return self.current

    async def events(self, mission_id: str) -> Sequence[MissionEvent]:
        self.answer()
        return tuple(one for one in self.timeline if one.mission_id == mission_id)


@dataclass
class FakeMemory(Service):
    name: str = "memory"


@dataclass
class UiWorld:
    bus: MemoryBus = field(default_factory=MemoryBus)
    robot: FakeRobot = field(default_factory=FakeRobot)
    eyes: FakeEyes = field(default_factory=FakeEyes)
    missions: FakeMissions = field(default_factory=FakeMissions)
    memory: FakeMemory = field(default_factory=FakeMemory)


def fresh_nicegui() -> None:
    """NiceGUI is one a process and takes no more middleware once it has served; tests make several apps."""
    nicegui_app.middleware_stack = None
    nicegui_app.user_middleware.clear()
