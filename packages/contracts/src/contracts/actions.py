"""The action library: everything that the robot can be asked to do, each declared once as a typed model.

The terminal's `atom do`, the tools of language models and of MCP, `POST /actions` and docs/actions.md are made from
these declarations. No action is a velocity: each names an end that the robot reaches by its own means, or refuses.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import cache
from typing import Annotated, Any, Final, Literal, Self

from pydantic import Field, JsonValue, StringConstraints, TypeAdapter, model_validator

from contracts.access import Role
from contracts.asking import Answer
from contracts.base import NO_CONTROL_CHARACTERS, Message
from contracts.mission import Heard, Mission, Outcome
from contracts.rooms import ROOM_NAME_MAX


class ActionName(StrEnum):
    STOP = "stop"
    PAUSE = "pause"
    RESUME = "resume"
    CANCEL = "cancel"
    FIND = "find"
    GO_TO = "go_to"
    LOOK_AROUND = "look_around"
    ROTATE = "rotate"
    DRIVE = "drive"
    EXPLORE = "explore"
    PATROL = "patrol"
    DOCK = "dock"
    UNDOCK = "undock"
    CELEBRATE = "celebrate"
    ASK = "ask"
    WHERE_IS = "where_is"
    COUNT = "count"
    DESCRIBE_VIEW = "describe_view"


def _said(most: int) -> StringConstraints:
    return StringConstraints(
        strip_whitespace=True, min_length=1, max_length=most, pattern=NO_CONTROL_CHARACTERS, strict=True
    )


Thing = Annotated[
    str,
    _said(100),
    Field(pattern=r"^\w[\w' -]*$", description="one thing in a few plain words, e.g. 'red bottle' or 'the couch'"),
]
Room = Annotated[
    str, _said(ROOM_NAME_MAX), Field(description="a room's name as GET /rooms of memory has it: 'kitchen'")
]
MissionId = Annotated[
    str | None,
    Field(min_length=1, max_length=64, pattern=r"^[0-9a-zA-Z_-]+$", description="none = the one that runs now"),
]
TURN_RAD_MAX: Final = 6.2832
TURN_RAD_MIN: Final = 0.02
"""A smaller turn is within what a turn is off by."""


class StopAction(Message):
    """Stops the robot at once and ends every mission; where nobody confirms it, the emergency stop is set."""

    action: Literal[ActionName.STOP] = ActionName.STOP


class PauseAction(Message):
    """Holds the mission where it is until it is resumed."""

    action: Literal[ActionName.PAUSE] = ActionName.PAUSE
    mission_id: MissionId = None


class ResumeAction(Message):
    """Lets a paused mission go on. It does not reset an emergency stop: only a person does."""

    action: Literal[ActionName.RESUME] = ActionName.RESUME
    mission_id: MissionId = None


class CancelAction(Message):
    """Ends a mission that runs or waits; the robot stands still."""

    action: Literal[ActionName.CANCEL] = ActionName.CANCEL
    mission_id: MissionId = None


class FindAction(Message):
    """Looks for a thing in the whole home, drives up to it and says where it is."""

    action: Literal[ActionName.FIND] = ActionName.FIND
    thing: Thing


class GoToAction(Message):
    """Drives to a place on the map, a room or a thing: exactly one of the three is named."""

    action: Literal[ActionName.GO_TO] = ActionName.GO_TO
    x_m: float | None = Field(
        default=None, strict=True, ge=-10_000.0, le=10_000.0, description="m, in map; a place is x_m and y_m together"
    )
    y_m: float | None = Field(default=None, strict=True, ge=-10_000.0, le=10_000.0, description="m, in map")
    yaw_rad: float | None = Field(
        default=None, strict=True, ge=-TURN_RAD_MAX, le=TURN_RAD_MAX,
        description="rad, the heading there, counter-clockwise from the map's x axis; none = as it comes",
    )  # fmt: skip
    room: Room | None = None
    thing: Thing | None = None

    @model_validator(mode="after")
    def _names_one(self) -> Self:
        if (self.x_m is None) != (self.y_m is None):
            raise ValueError("a place is x_m and y_m together")
        if self.yaw_rad is not None and self.x_m is None:
            raise ValueError("yaw_rad belongs to a place: x_m and y_m are missing")
        if sum(one is not None for one in (self.x_m, self.room, self.thing)) != 1:
            raise ValueError("exactly one of a place (x_m and y_m), a room or a thing is named")
        return self


class LookAroundAction(Message):
    """Turns once round on the spot and looks at each stop; what it saw is remembered and reported."""

    action: Literal[ActionName.LOOK_AROUND] = ActionName.LOOK_AROUND


class RotateAction(Message):
    """Turns on the spot by an angle."""

    action: Literal[ActionName.ROTATE] = ActionName.ROTATE
    angle_rad: float = Field(
        strict=True,
        ge=-TURN_RAD_MAX,
        le=TURN_RAD_MAX,
        description=f"rad, counter-clockwise (to the left) positive; a quarter turn to the left is {math.pi / 2:.4f}",
    )

    @model_validator(mode="after")
    def _turns(self) -> Self:
        if abs(self.angle_rad) < TURN_RAD_MIN:
            raise ValueError(f"a turn is at least {TURN_RAD_MIN} rad")
        return self


class DriveAction(Message):
    """Drives straight ahead by a distance; it ends before what stands in the way. It does not drive backwards."""

    action: Literal[ActionName.DRIVE] = ActionName.DRIVE
    distance_m: float = Field(strict=True, ge=0.05, le=2.0, description="m, straight ahead")


class ExploreAction(Message):
    """Drives to what the map does not show yet, and home; looks at all of the map where nothing unknown is left."""

    action: Literal[ActionName.EXPLORE] = ActionName.EXPLORE
    duration_s: float | None = Field(
        default=None, strict=True, ge=10.0, le=800.0, description="s, then it drives home; none, or longer = as is set"
    )


class PatrolAction(Message):
    """Drives to rooms in turn and looks round in each; the report says which were reached and what was seen."""

    action: Literal[ActionName.PATROL] = ActionName.PATROL
    rooms: Annotated[tuple[Room, ...], Field(min_length=1, max_length=12, description="in the order of the visits")]


class DockAction(Message):
    """Drives to the dock and onto it."""

    action: Literal[ActionName.DOCK] = ActionName.DOCK


class UndockAction(Message):
    """Drives off the dock and waits for the camera; done at once where it is not on it."""

    action: Literal[ActionName.UNDOCK] = ActionName.UNDOCK


class CelebrateAction(Message):
    """Plays six notes and a light; the wheels stand still."""

    action: Literal[ActionName.CELEBRATE] = ActionName.CELEBRATE


class AskAction(Message):
    """Answers a question from what is remembered, the missions and the robot's state."""

    action: Literal[ActionName.ASK] = ActionName.ASK
    question: Annotated[str, _said(500), Field(description="e.g. 'what is in the kitchen?'")]


class WhereIsAction(Message):
    """Says where a thing was last seen, from memory."""

    action: Literal[ActionName.WHERE_IS] = ActionName.WHERE_IS
    thing: Thing


class CountAction(Message):
    """Says how many of a kind of thing are remembered."""

    action: Literal[ActionName.COUNT] = ActionName.COUNT
    thing: Thing


class DescribeViewAction(Message):
    """Says what the camera sees now: things with their side and distance."""

    action: Literal[ActionName.DESCRIBE_VIEW] = ActionName.DESCRIBE_VIEW


Action = Annotated[
    StopAction | PauseAction | ResumeAction | CancelAction | FindAction | GoToAction | LookAroundAction | RotateAction
    | DriveAction | ExploreAction | PatrolAction | DockAction | UndockAction | CelebrateAction | AskAction
    | WhereIsAction | CountAction | DescribeViewAction,
    Field(discriminator="action"),
]  # fmt: skip
ACTION: Final[TypeAdapter[Action]] = TypeAdapter(Action)


class ActionNeed(StrEnum):
    """What an action cannot be begun without."""

    ROBOT = "robot"
    """robot_bridge tells the robot's state, and no emergency stop is latched."""
    MAP = "map"  # and the robot's place in it
    CAMERA = "camera"  # and inference, which sees things in its pictures
    MEMORY = "memory"
    DOCK = "dock"
    BATTERY = "battery"  # not too low to set out


@dataclass(frozen=True, slots=True)
class ActionSpec:
    """What goes with a declaration: who may, what it needs, how it may end and how long it may take."""

    model: type[Message]
    role: Role | None
    """Who may ask for it; none = anybody."""
    limit_s: float
    """It ends by itself after so long, the way off the dock included."""
    needs: tuple[ActionNeed, ...] = ()
    ends: tuple[Outcome, ...] = ()
    """Of an action that moves, which is a mission; none = it answers at once."""

    @property
    def moves(self) -> bool:
        """It is a mission: queued, reported, recorded, and paused, cancelled and stopped as any other."""
        return bool(self.ends)

    @property
    def sentence(self) -> str:
        return " ".join((self.model.__doc__ or "").split())


_N: Final = ActionNeed
_CUT_OFF: Final = (Outcome.CANCELED, Outcome.ABORTED, Outcome.INTERRUPTED)
_SEARCH: Final = (Outcome.FOUND, Outcome.NOT_FOUND, Outcome.UNSURE, *_CUT_OFF)
_MOTION: Final = (Outcome.DONE, *_CUT_OFF)
_DRIVING: Final = (_N.ROBOT, _N.BATTERY, _N.MAP)
_TURNING: Final = (_N.ROBOT, _N.BATTERY)
_OPERATOR, _VIEWER = Role.OPERATOR, Role.VIEWER

SPECS: Final[Mapping[ActionName, ActionSpec]] = {
    ActionName.STOP: ActionSpec(StopAction, None, 3.0),
    ActionName.PAUSE: ActionSpec(PauseAction, _OPERATOR, 5.0),
    ActionName.RESUME: ActionSpec(ResumeAction, _OPERATOR, 5.0),
    ActionName.CANCEL: ActionSpec(CancelAction, _OPERATOR, 5.0),
    ActionName.FIND: ActionSpec(FindAction, _OPERATOR, 900.0, (*_DRIVING, _N.CAMERA), _SEARCH),
    ActionName.GO_TO: ActionSpec(GoToAction, _OPERATOR, 900.0, _DRIVING, (Outcome.DONE, *_SEARCH)),
    ActionName.LOOK_AROUND: ActionSpec(LookAroundAction, _OPERATOR, 300.0, (*_TURNING, _N.CAMERA), _MOTION),
    ActionName.ROTATE: ActionSpec(RotateAction, _OPERATOR, 240.0, _TURNING, _MOTION),
    ActionName.DRIVE: ActionSpec(DriveAction, _OPERATOR, 240.0, _TURNING, _MOTION),
    ActionName.EXPLORE: ActionSpec(ExploreAction, _OPERATOR, 900.0, (*_DRIVING, _N.CAMERA), _MOTION),
    ActionName.PATROL: ActionSpec(PatrolAction, _OPERATOR, 900.0, (*_DRIVING, _N.CAMERA, _N.MEMORY), _MOTION),
    ActionName.DOCK: ActionSpec(DockAction, _OPERATOR, 900.0, (*_DRIVING, _N.DOCK), (Outcome.DOCKED, *_CUT_OFF)),
    ActionName.UNDOCK: ActionSpec(UndockAction, _OPERATOR, 240.0, _TURNING, _MOTION),
    ActionName.CELEBRATE: ActionSpec(CelebrateAction, _OPERATOR, 5.0, (_N.ROBOT,)),
    ActionName.ASK: ActionSpec(AskAction, _VIEWER, 30.0, (_N.MEMORY,)),
    ActionName.WHERE_IS: ActionSpec(WhereIsAction, _VIEWER, 30.0, (_N.MEMORY,)),
    ActionName.COUNT: ActionSpec(CountAction, _VIEWER, 30.0, (_N.MEMORY,)),
    ActionName.DESCRIBE_VIEW: ActionSpec(DescribeViewAction, _VIEWER, 5.0, (_N.CAMERA,)),
}
"""In the order in which tools are listed: to stop comes first."""


class ToolSchema(Message):
    """A tool as models that call tools take it (OpenAI's, Ollama's and MCP's form, but for the names of the fields)."""

    name: ActionName
    description: str = Field(max_length=500)
    parameters: dict[str, JsonValue] = Field(description="JSON schema of the arguments")


class ActionDescription(ToolSchema):
    """One line of the catalogue, `GET /actions`."""

    role: Role | None = Field(description="who may ask for it; none = anybody")
    moves: bool = Field(description="it is a mission (201); else it is answered at once (200)")
    needs: tuple[ActionNeed, ...] = Field(max_length=10)
    ends: tuple[Outcome, ...] = Field(max_length=10, description="how its mission may end")
    limit_s: float = Field(gt=0.0, description="it ends by itself after so long")


class ActionReply(Message):
    """What `POST /actions` answers: the mission of what moves, or the answer of what does not."""

    action: ActionName
    text: str = Field(max_length=2000, description="for a person")
    mission: Mission | None = Field(default=None, description="begun or queued, or what the order was about")
    answer: Answer | None = Field(default=None, description="of a question, with the records it rests on")
    heard: Heard | None = Field(default=None, description="of an order")


@cache
def tool_schema(name: ActionName) -> ToolSchema:
    """The one source of every schema of a tool. The action's own name is no argument."""
    spec = SPECS[name]
    schema: dict[str, Any] = spec.model.model_json_schema()
    arguments: dict[str, dict[str, Any]] = schema["properties"]
    properties: dict[str, JsonValue] = {key: _plain(value) for key, value in arguments.items() if key != "action"}
    parameters: dict[str, JsonValue] = {
        "type": "object",
        "properties": properties,
        "required": list(schema.get("required", ())),
        "additionalProperties": False,
    }
    return ToolSchema(name=name, description=spec.sentence, parameters=parameters)


def described(name: ActionName) -> ActionDescription:
    spec, tool = SPECS[name], tool_schema(name)
    return ActionDescription(
        name=tool.name, description=tool.description, parameters=tool.parameters,
        role=spec.role, moves=spec.moves, needs=spec.needs, ends=spec.ends, limit_s=spec.limit_s,
    )  # fmt: skip


def _plain(schema: dict[str, Any]) -> dict[str, JsonValue]:
    """Without titles, and an argument that may be left out by its own type: many models read no `anyOf`."""
    kept = {key: value for key, value in schema.items() if key not in {"title", "default"}}
    some = [one for one in kept.pop("anyOf", ()) if one.get("type") != "null"]
    return (some[0] if len(some) == 1 else {"anyOf": some} if some else {}) | kept
