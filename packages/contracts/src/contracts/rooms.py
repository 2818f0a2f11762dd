"""The rooms of a home, as memory knows them: cut from the map, named by a person or by what stands in them."""

from enum import StrEnum
from typing import Annotated

from pydantic import Field, StringConstraints, model_validator

from contracts.base import NO_CONTROL_CHARACTERS, Label, Message
from contracts.geometry import Pose2D

ROOM_NAME_MAX = 40
ROOM_CELLS_MAX = 2048 * 2048
"""Of a map that is cut into rooms: 1 ha in cells of 5 cm."""
ROOMS_MAX = 200
_BASE64_MAX = 5_700_000
"""Of so many bytes that zlib could not make fewer."""
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
    rooms: tuple[NamedRoom, ...] = Field(default=(), max_length=ROOMS_MAX)


class RoomGrid(Message):
    """`GET /rooms/grid`: where the rooms lie. Row 0 at the origin, as in `contracts.robot.Map`; `geometry.room_grids`
    reads and makes it. Only free cells are in a room: what stands there is not.
    """

    map_id: str = Field(default="", description="the home they are of")
    width: int = Field(ge=1, le=ROOM_CELLS_MAX)
    height: int = Field(ge=1, le=ROOM_CELLS_MAX)
    resolution_m: float = Field(gt=0.0, le=1000.0, description="a cell's side")
    origin: Pose2D = Field(description="of the corner of the first cell in map; may be turned")
    ids: tuple[int, ...] = Field(max_length=ROOMS_MAX, description="of the rooms, see /rooms; cell k is of ids[k - 1]")
    cells_base64: str = Field(
        max_length=_BASE64_MAX,
        description="width*height uint8 cells, zlib-compressed, base64: 0 is no room, k the room ids[k - 1]",
    )

    @model_validator(mode="after")
    def _is_not_too_large(self) -> "RoomGrid":
        if self.width * self.height > ROOM_CELLS_MAX:
            raise ValueError(f"a grid of rooms has no more than {ROOM_CELLS_MAX} cells")
        return self


class NameRoom(Message):
    """What a person calls a room. An empty name takes the old one away."""

    name: RoomName
