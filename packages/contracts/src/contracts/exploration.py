"""What whoever leads an exploration may ask of the robot: seven typed tools, none of them a velocity (C7)."""

import math
from enum import StrEnum
from typing import Annotated, Any, Final, Literal, Self

from pydantic import Field, TypeAdapter, model_validator

from contracts.base import NO_CONTROL_CHARACTERS, Label, Message, StampS

BEARING_MAX_RAD: Final = math.pi
STEP_M_MAX: Final = 2.0
"""As far as one drive may go."""
GOAL_M_MAX: Final = 1_000.0

BearingRad = Annotated[
    float,
    Field(ge=-BEARING_MAX_RAD, le=BEARING_MAX_RAD, description="rad from the robot's x axis, left is positive"),
]
StepM = Annotated[float, Field(gt=0.0, le=STEP_M_MAX, description="m")]
CoordinateM = Annotated[float, Field(ge=-GOAL_M_MAX, le=GOAL_M_MAX, description="m, in the map")]


class MoveToward(Message):
    """Turn to a bearing and drive some way straight ahead."""

    tool: Literal["move_toward"] = "move_toward"
    bearing_rad: BearingRad
    distance_m: StepM


class NavigateToGoal(Message):
    """Drive to a place of the map, or to a frontier by its number; exactly one of them."""

    tool: Literal["navigate_to_goal"] = "navigate_to_goal"
    x_m: CoordinateM | None = None
    y_m: CoordinateM | None = None
    frontier: int | None = Field(default=None, ge=1, le=1_000_000, description="a number that was told with the map")

    @model_validator(mode="after")
    def _names_one_goal(self) -> Self:
        if (self.x_m is None) != (self.y_m is None):
            raise ValueError("a place needs both x_m and y_m")
        if (self.x_m is None) == (self.frontier is None):
            raise ValueError("name either x_m and y_m, or a frontier")
        return self


class RotateBy(Message):
    """Turn on the spot."""

    tool: Literal["rotate"] = "rotate"
    angle_rad: BearingRad


class StopRobot(Message):
    """End what moves, and stand."""

    tool: Literal["stop_robot"] = "stop_robot"


class ObserveScene(Message):
    """Tell what the camera shows and what stands round the robot. Nothing moves."""

    tool: Literal["observe_scene"] = "observe_scene"


class CheckPathClear(Message):
    """Tell how far the way is clear. Nothing moves."""

    tool: Literal["check_path_clear"] = "check_path_clear"
    bearing_rad: BearingRad
    distance_m: StepM


class ReportDiscovery(Message):
    """Write down something worth knowing, at the place where the robot stands. Nothing moves."""

    tool: Literal["report_discovery"] = "report_discovery"
    label: Label
    note: str = Field(default="", max_length=200, pattern=NO_CONTROL_CHARACTERS)


ExplorationDecision = Annotated[
    MoveToward | NavigateToGoal | RotateBy | StopRobot | ObserveScene | CheckPathClear | ReportDiscovery,
    Field(discriminator="tool"),
]
DECISIONS: Final[TypeAdapter[ExplorationDecision]] = TypeAdapter(ExplorationDecision)
"""Reads one decision. Raises pydantic's `ValidationError` for everything that is none."""

TOOLS: Final = (MoveToward, NavigateToGoal, RotateBy, StopRobot, ObserveScene, CheckPathClear, ReportDiscovery)


def function_tools() -> list[dict[str, Any]]:
    """The seven as `tools` of a chat completion, in OpenAI's and Ollama's common format."""
    return [_function_tool(tool) for tool in TOOLS]


def _function_tool(tool: type[Message]) -> dict[str, Any]:
    schema = tool.model_json_schema()
    properties = {name: each for name, each in schema["properties"].items() if name != "tool"}
    parameters = {
        "type": "object",
        "properties": properties,
        "required": [name for name in schema.get("required", []) if name in properties],
        "additionalProperties": False,
    }
    name = tool.model_fields["tool"].default
    return {"type": "function", "function": {"name": name, "description": tool.__doc__ or "", "parameters": parameters}}


class DecisionVerdict(StrEnum):
    """What became of a decision when it was held against the newest scan."""

    ACCEPTED = "accepted"
    """As it was asked for."""
    SLOWED = "slowed"
    """Accepted, slower: something stands within the slow distance of the way."""
    SHORTENED = "shortened"
    """Accepted, for less of the way than was asked."""
    BLOCKED = "blocked"
    """Something stands nearer than the least clear distance that way."""
    TRIED_TOO_OFTEN = "tried_too_often"
    """This direction was blocked twice a short while ago."""
    NO_SCAN = "no_scan"
    """There is no laser scan, or it is too old to move on."""
    BLIND = "blind"
    """The laser says nothing about that way."""
    NO_POSE = "no_pose"
    """The robot does not know where it is on the map."""
    NO_SUCH_FRONTIER = "no_such_frontier"
    """That number was not told, or is no frontier any more."""
    GOAL_NOT_FREE = "goal_not_free"
    """The goal is not known free space that the robot has room in."""
    NOT_UNDERSTOOD = "not_understood"
    """It is none of the tools, or not within their bounds."""

    @property
    def moves(self) -> bool:
        """The robot may do it."""
        return self in {DecisionVerdict.ACCEPTED, DecisionVerdict.SLOWED, DecisionVerdict.SHORTENED}


class ExplorationMode(StrEnum):
    """Who decides where an exploration goes next (requirement C6)."""

    IDLE = "idle"
    """Nobody: nothing is explored."""
    MODEL = "model"
    """A language model, by the typed tools."""
    FRONTIERS = "frontiers"
    """The borders of what is known, the most worthwhile first, by Nav2."""
    REACTIVE = "reactive"
    """The laser alone: a careful wander."""
    LISTENING = "listening"
    """Nobody: somebody speaks to the robot. It goes on as before afterwards."""
    RETURNING = "returning"
    """Nobody: the robot drives home."""


class AskingReason(StrEnum):
    """Why the model is asked now (requirement C8)."""

    BEGUN = "begun"
    DOORWAY = "doorway"
    JUNCTION = "junction"
    DEAD_END = "dead_end"
    MOVED = "moved"
    """1.5 m since it was last asked."""
    DUE = "due"
    """10 s since it was last asked."""
    DONE = "done"
    """All it asked for is done."""
    TOOL_ANSWERED = "tool_answered"
    """It asked something and was told: the same question goes on."""


class ExplorationEnd(StrEnum):
    """Why an exploration came to its end."""

    EXPLORED = "explored"
    """No frontier is left that can be reached."""
    TIME_UP = "time_up"
    MODEL_SILENT = "model_silent"
    """The model did not answer for longer than the robot may be away from home without it."""
    CANCELED = "canceled"
    STOPPED = "stopped"
    """The emergency stop. Nothing goes on by itself afterwards."""
    ANOTHER_MAP = "another_map"
    """The robot is in another map than it began in: what was explored means nothing there."""
    HOME_NOT_REACHED = "home_not_reached"
    """No way home was found as often as it was tried."""
    MOTION_FAILED = "motion_failed"
    """Nothing that moves the robot was taken, however often it was asked for."""


class DoneAction(Message):
    """One action of an exploration and what became of it."""

    tool: str = Field(max_length=30)
    verdict: DecisionVerdict
    end: str = Field(default="", max_length=60, description="how the motion ended; '' = it moved nothing, or not yet")
    by: ExplorationMode


class Discovery(Message):
    """Something worth knowing, where the robot stood when it was reported."""

    label: Label
    note: str = Field(default="", max_length=200, pattern=NO_CONTROL_CHARACTERS)
    x_m: CoordinateM
    y_m: CoordinateM
    stamp_s: StampS


class ExploredRoom(Message):
    name: str = Field(max_length=40, pattern=NO_CONTROL_CHARACTERS)
    area_m2: float = Field(ge=0.0)
    x_m: CoordinateM
    y_m: CoordinateM


class MapPoint(Message):
    x_m: CoordinateM
    y_m: CoordinateM


class KnownFrontier(Message):
    number: int = Field(ge=1)
    x_m: CoordinateM
    y_m: CoordinateM
    border_m: float = Field(ge=0.0)


ACTIONS_KEPT: Final = 8
DISCOVERIES_KEPT: Final = 50
PLACES_KEPT: Final = 200


class ExplorationMemory(Message):
    """What an exploration knows of the home so far (requirement C10); kept over restarts, the newest last."""

    rooms: tuple[ExploredRoom, ...] = Field(default=(), max_length=50)
    frontiers: tuple[KnownFrontier, ...] = Field(default=(), max_length=50)
    dead_ends: tuple[MapPoint, ...] = Field(default=(), max_length=50)
    given_up: tuple[MapPoint, ...] = Field(
        default=(), max_length=PLACES_KEPT, description="frontiers that could not be reached, or showed nothing new"
    )
    actions: tuple[DoneAction, ...] = Field(default=(), max_length=ACTIONS_KEPT)
    actions_done: int = Field(default=0, ge=0)
    discoveries: tuple[Discovery, ...] = Field(default=(), max_length=DISCOVERIES_KEPT)
    trail: tuple[MapPoint, ...] = Field(
        default=(), max_length=PLACES_KEPT, description="where it has been, 0.5 m apart"
    )


DISCOVERIES_TOLD: Final = 10


class ExplorationStatus(Message):
    """What an exploration is at: who leads and why, and what of the bounds on the model is used up."""

    mission_id: str = Field(max_length=64)
    mode: ExplorationMode
    why: str = Field(default="", max_length=200, description="why that mode leads, for a person")
    model: str = Field(default="", max_length=100, description="the model that may lead; '' = none is set")
    calls: int = Field(default=0, ge=0, description="of the model so far")
    calls_max: int = Field(default=0, ge=0)
    tokens: int = Field(default=0, ge=0)
    tokens_max: int = Field(default=0, ge=0)
    waited_s: float = Field(default=0.0, ge=0.0, description="s that the model was waited for in all")
    waited_s_max: float = Field(default=0.0, ge=0.0, description="s")
    refused: int = Field(default=0, ge=0, description="decisions of the model that the check refused")
    actions: int = Field(default=0, ge=0, description="drives and turns that are over, in this exploration")
    goals: int = Field(default=0, ge=0, description="of those, goals of Nav2 that were reached")
    frontiers: int = Field(default=0, ge=0, description="borders of the known that are left and can be reached")
    explored_m2: float | None = Field(default=None, ge=0.0, description="m2 of floor that the map shows a way to")
    discoveries: tuple[Discovery, ...] = Field(
        default=(), max_length=DISCOVERIES_TOLD, description="the newest of this home, newest last"
    )
