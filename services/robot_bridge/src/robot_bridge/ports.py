"""What the bridge needs of a robot: a real one over ROS 2, or a fake one in tests."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from contracts.geometry import Pose2D, Twist2D
from contracts.robot import GoalStatus
from robot_bridge.sensing.sensor_readings import SensorReadings


@dataclass(frozen=True, slots=True)
class Path:
    """Nav2's plan: `poses` is empty where `error_code` is not 0."""

    poses: tuple[Pose2D, ...]
    error_code: int = 0


@dataclass(frozen=True, slots=True)
class GoalEnd:
    """How a goal ended at Nav2: SUCCEEDED, CANCELED or ABORTED, with Nav2's error code (0 = none)."""

    status: GoalStatus
    error_code: int = 0
    error_msg: str = ""


class AcceptedGoal(Protocol):
    """A goal Nav2 has taken."""

    async def end(self) -> GoalEnd:
        """Waits for the end, however long it takes."""
        ...

    def cancel(self) -> None:
        """Asks Nav2 to cancel it; the answer comes as the end."""
        ...

    async def was_preempted(self) -> bool:
        """Whether somebody else's goal is under way in its place; asked once it has ended."""
        ...


@dataclass(frozen=True, slots=True)
class Note:
    frequency_hz: int
    duration_s: float


@dataclass(frozen=True, slots=True)
class Celebration:
    """Notes one after the other, and all six LEDs in one colour, spinning."""

    notes: tuple[Note, ...]
    led_rgb: tuple[int, int, int]
    led_animation_type: int
    led_duration_s: float


@dataclass(frozen=True, slots=True)
class Kind:
    """What a topic's messages are: their type's name, how they are encoded, and the definition that reads them."""

    name: str
    message_encoding: str
    schema_encoding: str
    definition: bytes


@dataclass(frozen=True, slots=True)
class Raw:
    """A message as it is recorded. Stamps are nanoseconds since the Unix epoch."""

    topic: str
    kind: Kind
    log_ns: int
    data: bytes


Sink = Callable[[Raw], None]
"""Takes a message from any thread, at once."""


class LiveView(Protocol):
    """Shows what a recording would hold, while it happens."""

    def show(self, message: Raw) -> None:
        """From any thread, at once: what nobody looks at in time is dropped, the oldest first."""
        ...

    def close(self) -> None:
        """Blocks: not for the event loop."""
        ...


class Robot(Protocol):
    """Raises `UnavailableError` (naming the dependency) from whatever needs an action or service that is away."""

    @property
    def senses(self) -> SensorReadings: ...

    async def start(self, *, tick: Callable[[], None], navigation_velocity: Callable[[float, float], None]) -> None:
        """From here on `tick` is called at 20 Hz and `navigation_velocity` with what Nav2 wants, by the robot's thread.

        Goals that an earlier process left in Nav2 are cancelled.
        """
        ...

    async def close(self) -> None: ...

    def send_velocity(self, twist: Twist2D) -> None:
        """To the base, now, from any thread. Never blocks, never raises."""
        ...

    def engage_base_stop(self, engaged: bool, *, restored: bool = False) -> None:
        """Has the base's own e_stop follow the latch, as `robot_bridge.safety.base_stop` says; waits for nothing.

        `restored`: the latch was found set at the start.
        """
        ...

    def cancel_all_goals(self) -> None:
        """Every goal in Nav2, whoever sent it, and docking too; waits for nothing. What is out of reach is asked once
        it is back, and no goal is sent there before it has answered."""
        ...

    async def navigate(self, pose: Pose2D, on_progress: Callable[[float], None]) -> AcceptedGoal | None:
        """Sends a goal in map; none when Nav2 rejects it. `on_progress` hears the metres left, in the asyncio loop."""
        ...

    async def compute_path(self, goal: Pose2D, start: Pose2D | None) -> Path: ...

    async def clear_costmaps(self) -> None: ...

    async def dock(self) -> bool:
        """True when docked; false when the base could not."""
        ...

    async def undock(self) -> bool: ...

    def set_initial_pose(self, pose: Pose2D) -> None:
        """Tells the localiser where base_link is in map; waits for nothing."""
        ...

    def celebrate(self, celebration: Celebration) -> None:
        """Plays the notes and the lights; waits for nothing."""
        ...

    def record(self, sink: Sink, *, images_hz: float) -> Callable[[], None]:
        """Hands over the robot's own messages as they come, until what it answers is called. Waits for nothing.

        Pictures come at most so often; 0 = none.
        """
        ...
