"""What memory is told and what it recalls (requirement A4: a view is a *robot* pose from which a thing was seen)."""

from enum import StrEnum
from typing import Annotated

from pydantic import Field, model_validator

from contracts.base import NO_CONTROL_CHARACTERS, BboxXyxy, Confidence, ImageSidePx, Label, Message, SigmaM, StampS
from contracts.geometry import Point3D, Pose2D
from contracts.vision import Target

ColourWord = Annotated[str, Field(max_length=24, pattern=NO_CONTROL_CHARACTERS)]
Belief = Annotated[float, Field(ge=0.0, le=1.0, description="how sure memory is now that it is still there")]


class Embedding(Message):
    """An image's or a text's unit vector; only vectors of one model are compared."""

    model: str = Field(min_length=1, max_length=64, pattern=NO_CONTROL_CHARACTERS)
    vector: tuple[Annotated[float, Field(ge=-1.001, le=1.001)], ...] = Field(min_length=8, max_length=1024)


class Observation(Message):
    """One thing in one frame. Observations with the same stamp and pose are of one frame: they are different things."""

    label: Label
    confidence: Confidence
    pose: Pose2D = Field(description="of the robot, in map, when it saw the thing")
    stamp_s: StampS
    colour: ColourWord | None = None
    position: Point3D | None = Field(default=None, description="of the thing's near surface, in map, where measured")
    sigma_m: SigmaM | None = Field(default=None, description="standard deviation of the position")
    embedding: Embedding | None = Field(default=None, description="of what the box shows")


class ObservationBatch(Message):
    observations: tuple[Observation, ...] = Field(min_length=1, max_length=1000)


class ObservationsReply(Message):
    stored: int
    ignored: int = Field(default=0, description="excluded labels, such as person: never written")


class SeenBox(Message):
    label: Label
    bbox_xyxy: BboxXyxy
    position: Point3D | None = Field(default=None, description="in map, where measured")


class Look(Message):
    """One look, and everything that was seen in it: what should have been seen and was not loses belief."""

    pose: Pose2D = Field(description="of the robot, in map, when it looked")
    stamp_s: StampS
    image_width_px: ImageSidePx
    image_height_px: ImageSidePx
    hfov_rad: float | None = Field(default=None, gt=0.05, lt=3.0, description="none: the robot's")
    range_m: float | None = Field(default=None, gt=0.1, le=20.0, description="none: as in memory's settings")
    labels: tuple[Label, ...] | None = Field(
        default=None, max_length=100, description="what was looked for; none: everything the detector knows"
    )
    seen: tuple[SeenBox, ...] = Field(default=(), max_length=300, description="every box, whatever its label")
    ranges_m: tuple[Annotated[float, Field(gt=0.0, le=100.0)] | None, ...] | None = Field(
        default=None,
        max_length=1024,
        description="how far one sees, in equal columns from left to right, m along the optical axis; "
        "none: memory asks robot_bridge's depth at that stamp, and the map",
    )


class LookBatch(Message):
    looks: tuple[Look, ...] = Field(min_length=1, max_length=100)


class LooksReply(Message):
    """Of the objects remembered near: how many were seen, were missing, or could not be told (hidden, ambiguous)."""

    confirmed: int = 0
    missed: int = 0
    undetermined: int = 0


class View(Message):
    id: int
    label: Label
    confidence: Confidence
    pose: Pose2D
    stamp_s: StampS
    colour: str | None = None
    object_id: int | None = Field(default=None, description="which thing was seen; none where depth was not measured")
    count: int = Field(default=1, ge=1, description="sightings merged into it")


class ObjectState(StrEnum):
    PRESENT = "present"
    """Belief 0.5 or more."""
    DOUBTFUL = "doubtful"
    """Not seen for long, or missing in a look."""
    LOST = "lost"
    """Looked for in its place and not there."""
    MOVED = "moved"
    """Lost, and the same kind of thing has since turned up elsewhere: see `moved_to`."""


class RememberedObject(Message):
    """A thing at a place. When it turns up elsewhere that is another object; `moved_from` and `moved_to` link them."""

    id: int
    label: Label
    colour: str | None = None
    description: str = Field(description="e.g. 'red bottle'")
    position: Point3D = Field(description="in map")
    uncertainty_m: float = Field(ge=0.0, description="standard deviation of x and y")
    belief: Belief
    state: ObjectState
    confidence: Confidence = Field(description="the best it was ever seen with")
    first_seen_s: StampS
    last_seen_s: StampS
    last_missed_s: StampS | None = Field(
        default=None, description="last look in which it should have been, and was not"
    )
    times_seen: int = Field(ge=1)
    times_missed: int = Field(default=0, ge=0)
    moved_from: int | None = None
    moved_to: int | None = None
    room_id: int | None = Field(default=None, description="the room it stands in, see /rooms; none: not known")


class LabelCount(Message):
    label: Label
    views: int
    best_confidence: Confidence
    last_seen_s: StampS
    objects: int = 0


class RecallRule(StrEnum):
    BELIEF = "belief"
    """By score: belief, agreement with the description, confidence, recency, travel."""
    CONFIDENCE = "confidence"
    """Requirement A5: the memory object's views, then the class's own, each by confidence."""


class RecallRequest(Message):
    target: Target = Field(description="views of its colour are preferred")
    memory_object: Label | None = Field(default=None, description="where such things may be near (requirement A5)")
    embedding: Embedding | None = Field(
        default=None, description="of the description, by the model of the objects' own"
    )
    pose: Pose2D | None = Field(default=None, description="of the robot now: nearer places score higher")
    rule: RecallRule | None = Field(default=None, description="none: as in memory's settings")
    limit: int = Field(default=20, ge=1, le=200)
    min_separation_m: float = Field(
        default=0.75, ge=0.0, le=10.0, description="views closer together than this count once"
    )


class ScoreParts(Message):
    """Each from 0 to 1; the score is their product, each to the power of its weight (`MEMORY_WEIGHT_...`)."""

    belief: float
    agreement: float = Field(description="with the description: its colour, or its embedding")
    relation: float = Field(description="1 for the label itself, less for the memory object")
    confidence: float
    recency: float
    travel: float
    again: float = Field(description="1 for the best view of a thing, halved for each further one")


class RecalledView(Message):
    view: View
    source: str = Field(description="memory_object or label")
    reason: str = ""
    pose: Pose2D | None = Field(
        default=None, description="where to go: the view's place, turned to face the thing; none: the view's own pose"
    )
    score: float = Field(default=0.0, ge=0.0, le=1.0)
    parts: ScoreParts | None = None
    thing: RememberedObject | None = Field(default=None, description="what is expected to be seen from there")


class RecallReply(Message):
    views: tuple[RecalledView, ...]
    rule: RecallRule = RecallRule.CONFIDENCE
    map_id: str = Field(default="", description="the map that the places are in; '' where nobody knows which it is")
    in_other_maps: tuple[str, ...] = Field(
        default=(), max_length=20, description="maps in which such a thing is remembered too; their places are not told"
    )


class RememberedMap(Message):
    """A home that something is remembered of."""

    id: str = Field(description="as robot_bridge names it; '' where nobody knew which map it was")
    current: bool = Field(description="the robot is in it, or was last")
    last_seen_s: StampS
    views: int
    objects: int


class DeletedReply(Message):
    deleted: int = Field(description="views and objects")


class Area(Message):
    """A rectangle in map."""

    x_min: float = Field(ge=-10_000.0, le=10_000.0, description="m")
    y_min: float = Field(ge=-10_000.0, le=10_000.0, description="m")
    x_max: float = Field(ge=-10_000.0, le=10_000.0, description="m")
    y_max: float = Field(ge=-10_000.0, le=10_000.0, description="m")

    @model_validator(mode="after")
    def _has_an_inside(self) -> "Area":
        if self.x_max <= self.x_min or self.y_max <= self.y_min:
            raise ValueError("x_max and y_max must be greater than x_min and y_min")
        return self


class ForgetRequest(Message):
    """Forgets what meets every condition given; at least one must be. An area is of the map the robot is in."""

    label: Label | None = None
    area: Area | None = Field(default=None, description="things in it, and views taken from it")
    seen_after_s: StampS | None = Field(default=None, description="last seen at or after this")
    seen_before_s: StampS | None = Field(default=None, description="last seen before this")

    @model_validator(mode="after")
    def _says_something(self) -> "ForgetRequest":
        if self.label is None and self.area is None and self.seen_after_s is None and self.seen_before_s is None:
            raise ValueError("say at least one of label, area, seen_after_s, seen_before_s")
        return self


class ExportForm(StrEnum):
    FULL = "full"
    """JSON lines: a header, then objects, then views; nothing is lost in a round trip."""
    SEEDS = "seeds"
    """One JSON object: class -> [{x, y, yaw, confidence, time}], by confidence descending."""


class ImportReply(Message):
    objects: int
    views: int
    ignored: int = Field(default=0, description="records of excluded labels")


class MemoryStatistics(Message):
    labels: int
    views: int
    sightings: int = Field(description="merged into those views")
    objects: dict[ObjectState, int]
    oldest_s: StampS | None = None
    newest_s: StampS | None = None
    database: str = Field(description="sqlite or postgresql")
    size_bytes: int | None = None
