"""The rooms of a home, as memory knows them: cut from the map, named by a person or by what stands in them."""

from enum import StrEnum
from typing import Annotated

from pydantic import Field, StringConstraints

from contracts.base import NO_CONTROL_CHARACTERS, Label, Message

ROOM_NAME_MAX = 40
RoomName = Annotated[
    str, StringConstraints(strip_whitespace=True, max_length=ROOM_NAME_MAX, pattern=NO_CONTROL_CHARACTERS)
]


class NamedBy(StrEnum):
    PERSON = "person"
    CONTENTS = "contents"
    """Guessed from what stands there: a refrigerator makes a kitchen."""
    NOBODY = "nobody"
    """'unnamed room 3'."""


class NamedRoom(Message):
    """One room of the map the robot is in."""

    id: int = Field(ge=1, description="kept as long as memory knows the room, whatever it is called")
    name: str = Field(max_length=64, description="'kitchen', 'bedroom 2', 'unnamed room 3'")
    named_by: NamedBy
    kind: str | None = Field(default=None, max_length=24, description="what its contents make it, whoever named it")
    x: float = Field(ge=-10_000.0, le=10_000.0, description="m, in map: its roomiest place")
    y: float = Field(ge=-10_000.0, le=10_000.0, description="m, in map")
    area_m2: float = Field(ge=0.0, description="of its free floor")
    labels: tuple[Label, ...] = Field(default=(), max_length=100, description="what is remembered to stand there")


class RoomsReply(Message):
    """Empty where memory has no map."""

    map_id: str = Field(default="", description="the home they are of")
    rooms: tuple[NamedRoom, ...] = Field(default=(), max_length=200)


class NameRoom(Message):
    """What a person calls a room. An empty name takes the old one away."""

    name: RoomName
