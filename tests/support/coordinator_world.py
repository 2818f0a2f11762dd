"""A flat world in fake time behind the coordinator's ports: a robot that drives, a camera, votes, a memory."""

import asyncio
import io
import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from PIL import Image

from contracts.causes import GoalCause, Refusal
from contracts.colours import Colour
from contracts.geometry import Point3D, Pose2D, Twist2D
from contracts.language import ReasonReply, ReasonRequest
from contracts.laser import LaserScan
from contracts.measuring import Measurement, NotMeasured, not_measured
from contracts.memory import (
    LabelCount,
    Look,
    LookBatch,
    ObjectState,
    RecalledView,
    RecallReply,
    RecallRequest,
    RememberedObject,
    View,
)
from contracts.motion import BaseEnd, BaseReply, DriveReply, MotionEnd, RotateReply
from contracts.obstacles import Obstacles
from contracts.problem import Dependency
from contracts.robot import (
    Battery,
    BoxQuery,
    CandidatePose,
    EmergencyStop,
    Goal,
    GoalRequest,
    GoalStatus,
    Map,
    RobotState,
    VelocityReply,
)
from contracts.rooms import NamedRoom, RoomGrid, RoomsReply
from contracts.topics import ROBOT_EMERGENCY_STOP, ROBOT_STATE, VISION_DETECTIONS
from contracts.vision import (
    Detection,
    Detections,
    ParsedTask,
    ParseTaskRequest,
    ValidateRequest,
    Validation,
    Verdict,
    Vote,
)
from geometry.grids import OccupancyGrid, encode
from geometry.poses import compose
from mesh.errors import UnavailableError, UpstreamError
from support.bus import MemoryBus
from support.described import NOISE
from support.fake_clock import FakeClock

HFOV_RAD = math.radians(54)
WIDTH_PX, HEIGHT_PX = 320, 240
CAMERA_M = 0.06
STEP_S = 0.05
RESOLUTION_M = 0.05


def _picture() -> bytes:
    out = io.BytesIO()
    Image.new("RGB", (WIDTH_PX, HEIGHT_PX), (120, 60, 60)).save(out, "JPEG")
    return out.getvalue()


PICTURE = _picture()


@dataclass(frozen=True)
class Thing:
    label: str
    colour: str
    x: float
    y: float
    near_limit_m: float = 0.2
    """Nearer than this it has left the picture (it stands on a table)."""


@dataclass
class World:
    """10 x 8 m, walls round it, one wall with a door in the middle; `keep_out` discs stop the robot."""

    clock: FakeClock
    bus: MemoryBus
    things: list[Thing] = field(default_factory=list)
    keep_out: list[tuple[float, float, float]] = field(default_factory=list)
    pose: Pose2D = field(default_factory=lambda: Pose2D(x=1.5, y=1.5, yaw=0.0))
    stop: EmergencyStop = field(default_factory=lambda: EmergencyStop(latched=False, epoch=0))
    docked: bool = False
    battery_percent: float | None = None
    charging: bool = False
    lost: bool = False
    """It does not know its place in the map."""
    sees: bool = True
    colours_unknown: bool = False
    unmeasured: int = 0
    """The next pictures with something in them come without places."""
    range_m: float = 2.5
    speed_m_s: float = 0.0
    map_id: str | None = None
    mapped_m: float | None = None
    """The map shows only what lies this near to where the robot has been; none: all of it."""
    been: list[Pose2D] = field(default_factory=list[Pose2D])
    moves: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        free = np.zeros((160, 200), dtype=bool)
        free[4:-4, 4:-4] = True
        free[:, 98:102] = False
        free[70:94, 98:102] = True
        self.free = free

    def grid(self, yaw: float = 0.0) -> OccupancyGrid:
        """The world as a map whose rows are turned by `yaw`, written down cell by cell; unknown beyond the walls."""
        c, s = abs(math.cos(yaw)), abs(math.sin(yaw))
        width, height = round(200 * c + 160 * s), round(200 * s + 160 * c)
        corner = Pose2D(x=-width * RESOLUTION_M / 2, y=-height * RESOLUTION_M / 2, yaw=0.0)
        turned = OccupancyGrid(
            np.zeros((height, width), np.int8), RESOLUTION_M, compose(Pose2D(x=5.0, y=4.0, yaw=yaw), corner)
        )
        rows, columns = np.indices(turned.cells.shape)
        x, y = turned.points(columns + 0.5, rows + 0.5)
        cells = np.where(self.free, 0, 100).astype(np.int8)
        whole = OccupancyGrid(cells, RESOLUTION_M, Pose2D(x=0.0, y=0.0, yaw=0.0))
        known = np.full(x.shape, self.mapped_m is None)
        self.been += [self.pose] if self.mapped_m is not None else []
        for one in self.been:
            known |= np.hypot(x - one.x, y - one.y) < (self.mapped_m or 0.0)
        free, wall = known & whole.at(x, y, whole.free), known & whole.at(x, y, whole.occupied)
        return replace(turned, cells=np.where(free, 0, np.where(wall, 100, -1)).astype(np.int8))

    def is_free(self, x: float, y: float, clearance_m: float = 0.2) -> bool:
        if any(math.hypot(x - cx, y - cy) < r for cx, cy, r in self.keep_out):
            return False
        offsets = ((0.0, 0.0), (clearance_m, 0.0), (-clearance_m, 0.0), (0.0, clearance_m), (0.0, -clearance_m))
        return all(self._cell_free(x + dx, y + dy) for dx, dy in offsets)

    def _cell_free(self, x: float, y: float) -> bool:
        row, column = int(y / 0.05), int(x / 0.05)
        return 0 <= row < 160 and 0 <= column < 200 and bool(self.free[row, column])

    def in_sight(self, thing: Thing) -> tuple[float, float] | None:
        """(distance from the camera, bearing), or none."""
        dx, dy = thing.x - self.pose.x, thing.y - self.pose.y
        bearing = math.remainder(math.atan2(dy, dx) - self.pose.yaw, math.tau)
        away = math.hypot(dx, dy) - CAMERA_M
        if abs(bearing) > HFOV_RAD / 2 * 0.95 or not thing.near_limit_m <= away <= self.range_m:
            return None
        ray = np.linspace(0.0, 1.0, 60)
        clear = all(self._cell_free(self.pose.x + dx * t, self.pose.y + dy * t) for t in ray)
        return (away, bearing) if clear else None

    def detections(self) -> Detections:
        focal = WIDTH_PX / 2 / math.tan(HFOV_RAD / 2)
        found: list[Detection] = []
        for thing in self.things:
            seen = self.in_sight(thing)
            if seen is not None:
                away, bearing = seen
                u, half = WIDTH_PX / 2 - focal * math.tan(bearing), max(3.0, 0.04 * focal / away)
                box = (max(0.0, u - half), 100.0, min(float(WIDTH_PX), u + half), 100.0 + 4 * half)
                colour = None if self.colours_unknown or not thing.colour else Colour(thing.colour)
                found.append(
                    Detection(
                        label=thing.label,
                        confidence=0.8,
                        bbox_xyxy=box,
                        colour=colour,
                        measurement=self._measured(thing, away, bearing),
                    )
                )
        self.unmeasured = max(0, self.unmeasured - 1) if found else self.unmeasured
        return Detections(
            stamp_s=self.clock.now_s(),
            image_width_px=WIDTH_PX,
            image_height_px=HEIGHT_PX,
            pose=self.pose,
            detections=tuple(found),
        )

    def _measured(self, thing: Thing, away_m: float, bearing_rad: float) -> Measurement:
        if self.unmeasured:
            return not_measured(NotMeasured.NOT_ANSWERED, "no answer within 0.3 s")
        if away_m > 3.0:
            return not_measured(NotMeasured.NO_DEPTH, "no depth in the box")
        reach = away_m + CAMERA_M
        return Measurement(
            distance_m=away_m,
            sigma_m=NOISE.sigma_m(away_m),
            bearing_rad=bearing_rad,
            base_point=Point3D(x=reach * math.cos(bearing_rad), y=reach * math.sin(bearing_rad), z=0.1),
            map_point=Point3D(x=thing.x, y=thing.y, z=0.1),
        )

    def at(self, box: BoxQuery) -> Thing | None:
        """The thing a box shows."""
        focal = WIDTH_PX / 2 / math.tan(HFOV_RAD / 2)
        u = (box.bbox_xyxy[0] + box.bbox_xyxy[2]) / 2
        bearing = math.atan2(WIDTH_PX / 2 - u, focal)
        seen = [(t, s) for t in self.things if (s := self.in_sight(t)) is not None and abs(s[1] - bearing) < 0.1]
        return min(seen, key=lambda pair: abs(pair[1][1] - bearing))[0] if seen else None

    def state(self) -> RobotState:
        return RobotState(
            stamp_s=self.clock.now_s(),
            battery=Battery(percentage=self.battery_percent, charging=self.charging)
            if self.battery_percent is not None
            else None,
            pose=None if self.lost else self.pose,
            odometry=self.pose,
            twist=Twist2D(linear_x=self.speed_m_s),
            docked=self.docked,
            emergency_stop=self.stop,
            map_id=self.map_id,
        )

    async def latch(self, reason: str) -> None:
        self.stop = EmergencyStop(latched=True, epoch=self.stop.epoch + 1, reason=reason)
        await self.bus.publish(ROBOT_EMERGENCY_STOP, self.stop)

    async def reset(self) -> None:
        self.stop = EmergencyStop(latched=False, epoch=self.stop.epoch)
        await self.bus.publish(ROBOT_EMERGENCY_STOP, self.stop)

    async def run(self) -> None:
        """Publishes what the robot and the eyes would, until cancelled."""
        count = 0
        while True:
            await self.bus.publish(ROBOT_STATE, self.state())
            if self.sees and count % 3 == 0:
                await self.bus.publish(VISION_DETECTIONS, self.detections())
            count += 1
            await self.clock.sleep(0.1)

    def turn_to(self, yaw: float) -> None:
        self.pose = Pose2D(x=self.pose.x, y=self.pose.y, yaw=math.remainder(yaw, math.tau))

    def shift(self, dx: float, dy: float) -> bool:
        x, y = self.pose.x + dx, self.pose.y + dy
        if not self.is_free(x, y):
            return False
        self.pose = Pose2D(x=x, y=y, yaw=self.pose.yaw)
        return True


def around(wanted: Pose2D) -> tuple[CandidatePose, ...]:
    """Where the bridge would go instead, nearest first."""
    bearings = [k * math.tau / 8 for k in range(8)]
    return tuple(
        CandidatePose(
            pose=Pose2D(x=wanted.x + away_m * math.cos(a), y=wanted.y + away_m * math.sin(a), yaw=wanted.yaw), rank=rank
        )
        for rank, away_m in ((999, 0.35), (1000, 0.7))
        for a in bearings
    )


class FakeRobot:
    """The port `Robot` over a `World`. `fail_next` makes the next calls of a name fail; `aborts` ends goals badly."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.session_held = True
        self.fail_next: dict[str, int] = {}
        self.aborts: list[tuple[GoalStatus, int]] = []
        self.celebrations = 0
        self.sessions_dropped = 0
        self.halts = 0
        self.loses_navigate_reply = False
        self.refuses_dock = False
        self.hangs: set[str] = set()
        """Calls that are never answered."""
        self.arrives_nowhere = 0
        """Goals that are said to be reached at once."""
        self.slow_to_accept_s = 0.0
        self.as_map: Map | None = None
        """What is told for a map; none: the world as it is."""
        self.goals: dict[str, Goal] = {}
        self._going: asyncio.Task[None] | None = None

    async def hold_session(self) -> None:
        await asyncio.Event().wait()

    async def drop_session(self) -> None:
        """What was asked for in it ends."""
        self.sessions_dropped += 1
        for goal in [g for g in self.goals.values() if g.status is GoalStatus.EXECUTING]:
            await self.cancel_goal(goal.id)

    async def _check(self, name: str, epoch: int | None = None) -> None:
        if name in self.hangs:
            await asyncio.Event().wait()
        if self.fail_next.get(name, 0) > 0:
            self.fail_next[name] -= 1
            raise UnavailableError("robot_bridge", f"{name} is away")
        if epoch is not None:
            if self.world.stop.latched:
                raise UpstreamError("robot_bridge", 409, "the emergency stop is latched", code=Refusal.STOPPED)
            if epoch != self.world.stop.epoch:
                raise UpstreamError("robot_bridge", 409, "of an older epoch", code=Refusal.OLD_EPOCH)
            self.world.moves.append(name)

    async def state(self) -> RobotState:
        await self._check("state")
        return self.world.state()

    async def scan(self) -> LaserScan:
        """Nothing in the laser's reach."""
        await self._check("scan")
        return LaserScan(stamp_s=self.world.clock.now_s(), pose=self.world.pose)

    async def obstacles(self) -> Obstacles:
        await self._check("obstacles")
        return Obstacles(stamp_s=self.world.clock.now_s(), sectors_m={}, emergency=False)

    async def map(self) -> Map:
        await self._check("map")
        return self.as_map if self.as_map is not None else encode(self.world.grid())

    async def navigate(self, request: GoalRequest) -> Goal:
        await self._check("navigate", request.epoch)
        if self.slow_to_accept_s:
            await self.world.clock.sleep(self.slow_to_accept_s)
        ring = around(request.candidates[0].pose) if request.ring_radius_m is None else ()
        near = [each for each in (*request.candidates, *ring) if self.world.is_free(each.pose.x, each.pose.y, 0.25)]
        unreachable = GoalStatus.ABORTED, 206
        status, code = self.aborts.pop(0) if self.aborts else (GoalStatus.EXECUTING, 0) if near else unreachable
        if self.arrives_nowhere > 0:
            self.arrives_nowhere -= 1
            status = GoalStatus.SUCCEEDED
        goal = Goal(
            id=f"goal-{len(self.goals)}",
            pose=min(near or request.candidates, key=self._cost).pose,
            status=status,
            error_code=code,
            cause=None if near else GoalCause.UNREACHABLE,
            stamp_s=self.world.clock.now_s(),
        )
        self.goals[goal.id] = goal
        if status is GoalStatus.EXECUTING:
            self._going = asyncio.create_task(self._go(goal))
        if self.loses_navigate_reply:
            raise UnavailableError("robot_bridge", "no answer in time")
        return goal

    def _cost(self, candidate: CandidatePose) -> tuple[int, float]:
        here, pose = self.world.pose, candidate.pose
        return candidate.rank, candidate.cost_m + math.hypot(pose.x - here.x, pose.y - here.y)

    async def _go(self, goal: Goal) -> None:
        world = self.world
        while (left := math.hypot(goal.pose.x - world.pose.x, goal.pose.y - world.pose.y)) > 0.01:
            if world.stop.latched or self._status(goal.id) is not GoalStatus.EXECUTING:
                return
            step = min(left, 0.3 * STEP_S)
            yaw = math.atan2(goal.pose.y - world.pose.y, goal.pose.x - world.pose.x)
            world.pose = Pose2D(x=world.pose.x + step * math.cos(yaw), y=world.pose.y + step * math.sin(yaw), yaw=yaw)
            await world.clock.sleep(STEP_S)
        world.turn_to(goal.pose.yaw)
        self.goals[goal.id] = goal.model_copy(update={"status": GoalStatus.SUCCEEDED})

    def _status(self, goal_id: str) -> GoalStatus | None:
        return self.goals[goal_id].status if goal_id in self.goals else None

    async def goal(self, goal_id: str) -> Goal:
        if goal_id not in self.goals:
            raise UpstreamError("robot_bridge", 404, f"no goal {goal_id}")
        return self.goals[goal_id]

    def lose_goals(self) -> None:
        """As a bridge does that was restarted: what it was asked for is unknown to it, and the robot stands."""
        self.goals = {}

    async def cancel_goal(self, goal_id: str) -> Goal:
        await self.goal(goal_id)
        over = {"status": GoalStatus.CANCELED, "cause": GoalCause.CANCELED}
        self.goals[goal_id] = self.goals[goal_id].model_copy(update=over)
        return self.goals[goal_id]

    async def rotate(self, angle_rad: float, *, speed_rad_s: float, timeout_s: float, epoch: int) -> RotateReply:
        await self._check("rotate", epoch)
        await self.world.clock.sleep(abs(angle_rad) / speed_rad_s)
        self.world.turn_to(self.world.pose.yaw + angle_rad)
        return RotateReply(end=MotionEnd.COMPLETED, turned_rad=angle_rad)

    async def drive(self, distance_m: float, *, speed_m_s: float, timeout_s: float, epoch: int) -> DriveReply:
        await self._check("drive", epoch)
        moved = 0.0
        while moved < distance_m:
            step = min(speed_m_s * STEP_S, distance_m - moved)
            if self.world.stop.latched:
                return _drove(MotionEnd.STOPPED, moved)
            yaw = self.world.pose.yaw
            if not self.world.shift(step * math.cos(yaw), step * math.sin(yaw)):
                return _drove(MotionEnd.BLOCKED, moved)
            moved += step
            await self.world.clock.sleep(STEP_S)
        return _drove(MotionEnd.COMPLETED, moved)

    async def velocity(self, twist: Twist2D, *, duration_s: float, epoch: int) -> VelocityReply:
        await self._check("velocity", epoch)
        yaw, step_s = self.world.pose.yaw, 0.1 if twist.linear_x else duration_s
        moved = twist.linear_x * step_s
        driven = self.world.shift(moved * math.cos(yaw), moved * math.sin(yaw)) if moved else True
        self.world.turn_to(self.world.pose.yaw + twist.angular_z * step_s)
        self.world.speed_m_s = twist.linear_x if driven else 0.0
        return VelocityReply(accepted=True, sent=twist)

    async def end_motion(self) -> None:
        self.world.speed_m_s = 0.0

    async def halt(self) -> EmergencyStop:
        if "halt" in self.hangs:
            await asyncio.Event().wait()
        self.halts += 1
        self.world.stop = self.world.stop.model_copy(update={"epoch": self.world.stop.epoch + 1})
        self._end_everything()
        return self.world.stop

    async def emergency_stop(self, reason: str) -> EmergencyStop:
        if "emergency_stop" in self.hangs:
            await asyncio.Event().wait()
        self._end_everything()
        await self.world.latch(reason)
        return self.world.stop

    def _end_everything(self) -> None:
        for goal in [g for g in self.goals.values() if g.status is GoalStatus.EXECUTING]:
            self.goals[goal.id] = goal.model_copy(update={"status": GoalStatus.CANCELED})
        self.world.speed_m_s = 0.0

    async def undock(self, *, timeout_s: float) -> BaseReply:
        await self._check("undock", self.world.stop.epoch)
        await self.world.clock.sleep(2.0)
        self.world.docked = False
        return BaseReply(end=BaseEnd.COMPLETED)

    async def dock(self, *, timeout_s: float) -> BaseReply:
        await self._check("dock", self.world.stop.epoch)
        await self.world.clock.sleep(5.0)
        if self.refuses_dock:
            return BaseReply(end=BaseEnd.GAVE_UP, text=BaseEnd.GAVE_UP.sentence)
        self.world.docked = True
        return BaseReply(end=BaseEnd.COMPLETED)

    async def celebrate(self) -> None:
        self.celebrations += 1

    async def dependency(self) -> Dependency:
        return Dependency.of("robot_bridge", ok=True)


def _drove(end: MotionEnd, metres: float) -> DriveReply:
    return DriveReply(end=end, driven_m=metres, text=end.sentence)


class FakeInference:
    """The port `Eyes`: reads '<verb> the <colour> <label>', and votes by what really stands in the box."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.fail_next = 0
        self.parse: ParsedTask | None = None
        """None: whatever is said asks for the red bottle."""
        self.validations = 0
        self.pictures: dict[str, bytes] = {}
        """Of what was judged, by the validation's id."""
        self.narrow = False
        self.reads = True
        self.lies = False
        """It calls confirmed what its votes refuse."""
        self.words: str | None = None
        self.reasoned: list[ReasonRequest] = []

    async def parse_task(self, request: ParseTaskRequest) -> ParsedTask:
        if not self.reads:
            raise UnavailableError("inference", "not reachable")
        bottle = {"yolo_class": "bottle", "memory_object": "bottle", "description": "red bottle", "parser": "rules"}
        return self.parse or ParsedTask.model_validate({"targets": [{"said": request.command, **bottle}]})

    async def validate(self, request: ValidateRequest, *, timeout_s: float) -> Validation:
        self.validations += 1
        if self.fail_next > 0:
            self.fail_next -= 1
            raise UnavailableError("inference", "the model is away")
        assert request.bbox_xyxy is not None
        box = BoxQuery(bbox_xyxy=request.bbox_xyxy, image_width_px=WIDTH_PX, image_height_px=HEIGHT_PX)
        thing = self.world.at(box)
        right = thing is not None and f"{thing.colour} {thing.label}" == request.target.description
        votes = (
            Vote(voter="detector", verdict=Verdict.YES, score=0.8, threshold=0.3),
            Vote(
                voter="clip",
                verdict=Verdict.YES if right else Verdict.NO,
                score=0.5 if right else 0.38 if self.narrow else 0.1,
                threshold=0.4,
            ),
            Vote(voter="vlm", verdict=Verdict.ABSTAIN, reason="none is there"),
        )
        name = f"validation-{self.validations}"
        self.pictures[name] = PICTURE + name.encode()  # a JPEG may be followed by anything
        return Validation(
            id=name,
            confirmed=right or self.lies,
            votes=votes,
            stamp_s=self.world.clock.now_s(),
            image_width_px=WIDTH_PX,
            image_height_px=HEIGHT_PX,
        )

    async def evidence(self, validation_id: str) -> bytes:
        if validation_id not in self.pictures:
            raise UpstreamError("inference", 404, f"no picture of validation {validation_id} is kept")
        return self.pictures[validation_id]

    async def reason(self, request: ReasonRequest) -> ReasonReply:
        self.reasoned.append(request)
        if self.words is None:
            raise UnavailableError("inference", "no language model is there")
        return ReasonReply(answer=self.words, by="openai:test")

    async def dependency(self) -> Dependency:
        return Dependency.of("inference", ok=True)


def thing(
    number: int, label: str, x: float, y: float, colour: str | None = None, seen_s: float = 400.0
) -> RememberedObject:
    return RememberedObject(
        id=number, label=label, colour=colour, description=f"{colour} {label}" if colour else label,
        position=Point3D(x=x, y=y, z=0.4), uncertainty_m=0.1, belief=0.9, state=ObjectState.PRESENT, confidence=0.8,
        first_seen_s=1.0, last_seen_s=seen_s, times_seen=3,
    )  # fmt: skip


class FakeMemory:
    """The port `Memory` over a list of robot poses."""

    def __init__(self, views: Sequence[Pose2D] = ()) -> None:
        self.remembered = tuple(views)
        self.away = False
        self.things: tuple[RememberedObject, ...] | None = None
        """None: a memory that knows views only, and takes no looks."""
        self.named_rooms: tuple[NamedRoom, ...] = ()
        self.rooms_hang = False
        self.rooms_lie: RoomGrid | None = None
        """None: there is no map."""
        self.asked_for_rooms = 0
        self.looked: list[Look] = []
        self.in_other_maps: tuple[str, ...] = ()

    async def looks(self, batch: LookBatch) -> None:
        self._check()
        if self.things is None:
            raise UpstreamError("memory", 404, "Not Found")
        self.looked += batch.looks

    async def views(self, label: str, limit: int) -> Sequence[View]:
        self._check()
        return (
            []
            if label != "bottle"
            else [
                View(id=k, label=label, confidence=0.9, pose=pose, stamp_s=1.0)
                for k, pose in enumerate(self.remembered[:limit])
            ]
        )

    async def objects(self, label: str | None, limit: int, room_id: int | None = None) -> Sequence[RememberedObject]:
        self._check()
        if self.things is None:
            raise UpstreamError("memory", 404, "Not Found")
        of_room = [one for one in self.things if room_id in {None, one.room_id}]
        return [one for one in of_room if label in {None, one.label}][:limit]

    async def rooms(self) -> RoomsReply:
        self.asked_for_rooms += 1
        self._check()
        if self.rooms_hang:
            await asyncio.Event().wait()
        return RoomsReply(map_id="home", rooms=self.named_rooms)

    async def room_grid(self) -> RoomGrid:
        self._check()
        if self.rooms_lie is None:
            raise UpstreamError("memory", 404, "there is no map now that is cut into rooms")
        return self.rooms_lie

    def _check(self) -> None:
        if self.away:
            raise UnavailableError("memory", "not reachable")

    async def labels(self) -> Sequence[LabelCount]:
        if self.away:
            raise UnavailableError("memory", "not reachable")
        known = LabelCount(label="bottle", views=len(self.remembered), best_confidence=0.9, last_seen_s=1.0)
        return [known] if self.remembered else []

    async def recall(self, request: RecallRequest) -> RecallReply:
        if self.away:
            raise UnavailableError("memory", "not reachable")
        views = (
            View(id=k, label=request.target.label, confidence=0.9, pose=pose, stamp_s=1.0)
            for k, pose in enumerate(self.remembered[: request.limit])
        )
        thing = next((one for one in self.things or () if one.label == request.target.label), None)
        recalled = tuple(RecalledView(view=view, source="label", thing=thing) for view in views)
        return RecallReply(views=recalled, in_other_maps=self.in_other_maps)

    async def dependency(self) -> Dependency:
        return Dependency.of("memory", ok=not self.away)
