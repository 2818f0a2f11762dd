"""What memory is told and what it recalls (requirement A4: a view is a *robot* pose from which a thing was seen)."""

from pydantic import Field

from contracts.base import NO_CONTROL_CHARACTERS, Confidence, Label, Message, StampS
from contracts.geometry import Pose2D


class Observation(Message):
    label: Label
    confidence: Confidence
    pose: Pose2D = Field(description="of the robot, in map, when it saw the thing")
    stamp_s: StampS
    colour: str | None = Field(default=None, max_length=24, pattern=NO_CONTROL_CHARACTERS)


class ObservationBatch(Message):
    observations: tuple[Observation, ...] = Field(min_length=1, max_length=1000)


class ObservationsReply(Message):
    stored: int
    ignored: int = Field(default=0, description="excluded labels, such as person: never written")


class View(Message):
    id: int
    label: Label
    confidence: Confidence
    pose: Pose2D
    stamp_s: StampS
    colour: str | None = None


class LabelCount(Message):
    label: Label
    views: int
    best_confidence: Confidence
    last_seen_s: StampS


class RecallRequest(Message):
    label: Label
    memory_object: Label | None = Field(default=None, description="looked at first (requirement A5)")
    description: str = Field(default="", max_length=120, description="prefers views of the colour it names")
    pose: Pose2D | None = None
    limit: int = Field(default=20, ge=1, le=200)
    min_separation_m: float = Field(
        default=0.75, ge=0.0, le=10.0, description="views closer together than this count once"
    )


class RecalledView(Message):
    view: View
    source: str = Field(description="memory_object or label")
    reason: str = ""


class RecallReply(Message):
    views: tuple[RecalledView, ...]


class DeletedReply(Message):
    deleted: int
