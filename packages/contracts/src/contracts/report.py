"""What the ending of a mission rests on."""

from enum import StrEnum

from pydantic import Field

from contracts.base import Confidence, Label, Message, StampS
from contracts.geometry import Pose2D
from contracts.vision import Vote


class Candidate(Message):
    """One thing that was looked at closely: what was found, or what was not taken, and why."""

    text: str = Field(max_length=500, description="what it is and why it was taken or not, for a person")
    label: Label
    colour: str | None = Field(default=None, max_length=24)
    place: Pose2D | None = Field(default=None, description="its place in map (yaw unused); none where not measured")
    seen_from: Pose2D | None = Field(default=None, description="of the robot, in map")
    distance_m: float | None = Field(default=None, description="camera to its near surface when it was judged")
    confidence: Confidence | None = Field(default=None, description="the detector's")
    votes: tuple[Vote, ...] = ()
    log_odds: tuple[float, ...] = Field(
        default=(), max_length=100, description="that it is the target, of all looks at it; after each, the first first"
    )
    confirmed: bool = False
    narrow: bool = Field(default=False, description="refused by a hair, or judged by too few: it may be the target")
    colour_unseen: bool = Field(default=False, description="no look at it named the colour asked for: votes alone did")
    picture: int | None = Field(default=None, ge=0, description="GET /missions/{id}/pictures/{picture}: a JPEG crop")
    stamp_s: float = Field(ge=0.0, description="when it was judged")


class SeenInstead(Message):
    """What the search saw that was not looked for."""

    label: Label
    colour: str | None = Field(default=None, max_length=24)
    times: int = Field(ge=1, description="frames it was seen in")
    confidence: Confidence = Field(description="the best")
    seen_from: Pose2D | None = None


class LastSeen(Message):
    """Where memory has the target last, and when."""

    label: Label
    colour: str | None = Field(default=None, max_length=24)
    pose: Pose2D = Field(description="of the robot when it saw it")
    stamp_s: StampS


class SearchedRoom(Message):
    """A room that a mission keeps to."""

    id: int = Field(ge=1, description="see memory's /rooms")
    name: str = Field(max_length=64, description="as it was called when it was asked for")


class SeenElsewhere(Message):
    """What memory knew of the target outside the rooms that were looked in."""

    label: Label
    colour: str | None = Field(default=None, max_length=24)
    room: str = Field(default="", max_length=64, description="the name of the room it stands in; '' = not known")
    place: Pose2D = Field(description="of the thing in map (yaw unused)")
    stamp_s: StampS = Field(description="when it was seen last")


class MapTrouble(StrEnum):
    """Why a search cannot go on with the map it has."""

    NO_FREE_SPACE = "no_free_space"
    """The map shows no free space at all."""
    NO_ROOM = "no_room"
    """It shows some, and the robot fits nowhere in it."""
    ANOTHER_MAP = "another_map"
    """The map was changed for that of another place while the mission ran."""


class EndCause(StrEnum):
    """What ended a mission that was no find: for a program; `Report.cause` and `text` say it to a person."""

    ALL_LOOKED = "all_looked"
    """Every place worth it was looked at."""
    NO_PLACE_LEFT = "no_place_left"
    """Of the places left none could be reached."""
    TIME_UP = "time_up"  # its own
    STOPPED = "stopped"
    """An emergency stop."""
    PERSON = "person"  # who asked for it
    STAYED_PAUSED = "stayed_paused"
    """Nobody resumed it."""
    CANNOT_MOVE = "cannot_move"
    """Turns and drives kept being cut off."""
    NAVIGATION = "navigation"
    """Nav2 refused goal after goal, or reached none of many places."""
    SERVICE = "service"
    """A service kept failing, or did not answer."""
    NO_PICTURES = "no_pictures"
    """No picture came to look at."""
    BRIDGE_SILENT = "bridge_silent"
    """robot_bridge, or Redis, said nothing any more."""
    LOST = "lost"
    """The robot did not know its place in the map for long."""
    MAP = "map"
    """The map cannot be searched; `map_trouble` says why."""
    BATTERY = "battery"
    """The battery was too low to begin."""
    NOT_DOCKED = "not_docked"
    """It did not get onto its dock."""
    RESTART = "restart"
    """The coordinator ended while it was queued or ran."""


class Report(Message):
    """What an ending rests on. `text` says all of it in one or two sentences."""

    text: str = Field(max_length=1000)
    found: Candidate | None = None
    candidates: tuple[Candidate, ...] = Field(default=(), max_length=20, description="not taken, likeliest first")
    looked_share: float | None = Field(
        default=None, ge=0.0, le=1.0, description="of the free space of where it was to look; none = no map"
    )
    rooms: tuple[SearchedRoom, ...] = Field(
        default=(), max_length=200, description="the only rooms looked in, as asked for; empty: the whole home"
    )
    elsewhere: tuple[SeenElsewhere, ...] = Field(
        default=(), max_length=20, description="known of outside those rooms, newest first"
    )
    places_looked: int = Field(default=0, ge=0)
    places_unreachable: int = Field(default=0, ge=0)
    last_seen: LastSeen | None = None
    seen_instead: tuple[SeenInstead, ...] = Field(default=(), max_length=20, description="most often seen first")
    ended_by: EndCause | None = Field(default=None, description="none for a find, and in records of before")
    cause: str = Field(default="", max_length=500, description="why it was aborted, interrupted or cancelled")
    map_trouble: MapTrouble | None = Field(default=None, description="where the map is why it was aborted")
