"""What inference sees and how it votes."""

from enum import StrEnum
from typing import Annotated

from pydantic import Field

from contracts.base import BboxXyxy, Confidence, ImageSidePx, Label, Message, StampS
from contracts.colours import Colour, colour_asked
from contracts.geometry import Pose2D
from contracts.measuring import Measurement
from contracts.reading import Mood, Restriction


class Target(Message):
    """What is looked for: the detector's class, and the words that tell the right one of its kind."""

    label: Label
    description: str = Field(min_length=1, max_length=120, description="2-4 words, e.g. 'red bottle'")
    colour: Colour | None = Field(
        default_factory=lambda said: colour_asked(said["label"], said["description"]),
        description="the colour asked for, none = any; read from the description where it is left out",
    )
    not_colours: tuple[Colour, ...] = Field(default=(), max_length=11, description="colours it must not have")

    def may_be(self, label: str, colour: str | None) -> bool:
        """The class, in no other colour than the one asked for. A colour that is not known does not disagree."""
        agrees = colour is None or (colour not in self.not_colours and self.colour in {None, colour})
        return label == self.label and agrees


class Detection(Message):
    label: Label
    confidence: Confidence
    bbox_xyxy: BboxXyxy
    colour: Colour | None = Field(default=None, description="the one the image-text model is sure of, if any")
    measurement: Measurement | None = Field(default=None, description="none where nobody was asked to measure")


class Detections(Message):
    """One frame's detections, with the robot's pose at capture."""

    stamp_s: StampS = Field(description="of the frame")
    image_width_px: ImageSidePx
    image_height_px: ImageSidePx
    pose: Pose2D | None = Field(default=None, description="base_link in map when the frame was taken")
    detections: tuple[Detection, ...] = Field(default=(), max_length=300)
    model: str = ""
    took_ms: float = Field(default=0.0, ge=0.0)


class ObjectSpotted(Message):
    """The target was seen; at most every 0.5 s (requirement A7)."""

    stamp_s: StampS
    target: Target
    detection: Detection
    image_width_px: ImageSidePx
    image_height_px: ImageSidePx
    pose: Pose2D | None = None


LOG_ODDS_MAX = 6.0
"""Of one vote: nobody measured that a voter is wrong less often than once in 400."""


class Verdict(StrEnum):
    YES = "yes"
    NO = "no"
    ABSTAIN = "abstain"


class Vote(Message):
    voter: str = Field(description="detector, clip or vlm")
    verdict: Verdict
    score: float | None = None
    threshold: float | None = None
    rival: str = Field(default="", max_length=120, description="clip: the other colour that came nearest")
    rival_score: float | None = None
    frame_score: float | None = Field(default=None, description="clip: of the whole frame; the crop is what votes")
    log_odds: float | None = Field(
        default=None,
        ge=-LOG_ODDS_MAX,
        le=LOG_ODDS_MAX,
        description="what it says for the target: natural, measured on held-out pictures; none = not measured",
    )
    model: str = ""
    took_ms: float = Field(default=0.0, ge=0.0)
    reason: str = ""


class ValidateRequest(Message):
    """Is the target in the newest frame (taken after `after_stamp_s`)? `bbox_xyxy` says which box is meant."""

    target: Target
    bbox_xyxy: BboxXyxy | None = None
    after_stamp_s: StampS | None = None
    moving: bool = Field(
        default=False, description="the robot drives on: the vision-language model, which takes seconds, abstains"
    )
    allow_single_vote: bool = Field(
        default=False, description="where only one model can vote at all, let its yes confirm (the answer says so)"
    )


class Validation(Message):
    id: str = Field(default="", max_length=64, description="GET /validations/{id}.jpg: the crop that was judged")
    confirmed: bool
    votes: tuple[Vote, ...]
    by_single_vote: bool = Field(default=False, description="confirmed by the only model that could vote, as allowed")
    stamp_s: StampS
    image_width_px: ImageSidePx
    image_height_px: ImageSidePx
    bbox_xyxy: BboxXyxy | None = None
    reason: str = ""


class ParseTaskRequest(Message):
    command: str = Field(min_length=1, max_length=500)
    labels_in_memory: tuple[Label, ...] = Field(default=(), max_length=500)


class ParsedTarget(Message):
    """One of the things a command asks for, as a parser claims it; check it against the words of `said` alone."""

    said: str = Field(min_length=1, max_length=500, description="the part of the command that asks for it")
    yolo_class: str = Field(max_length=64, description="a COCO label, or 'none'")
    named: bool = Field(default=True, description="false where no thing is named at all, known or not")
    memory_object: str | None = Field(default=None, max_length=64, description="where to look first")
    description: str = Field(default="", max_length=120)
    parser: str = Field(description="who read this part: 'rules', 'ollama:<model>' or 'openai:<model>'")
    notes: str = Field(default="", max_length=500)


class ParsedTask(Message):
    """What a parser *claims* the command means; the coordinator checks every word of it (requirement A3)."""

    targets: tuple[ParsedTarget, ...] = Field(default=(), max_length=8, description="the things asked for, as said")
    notes: str = Field(default="", max_length=500, description="what of the command was not read, and why")
    mood: Mood = Field(default=Mood.FIND, description="only FIND asks for a search")
    restrictions: tuple[Restriction, ...] = Field(default=(), max_length=24, description="what narrows the thing down")


class ScoreRequest(Message):
    """Image-text scores of the newest frame, or of the crop at `bbox_xyxy` in it."""

    texts: tuple[Annotated[str, Field(max_length=200)], ...] = Field(min_length=1, max_length=64)
    bbox_xyxy: BboxXyxy | None = None


class ScoreReply(Message):
    """One cosine a text, in the order sent."""

    scores: tuple[float, ...] = Field(description="of the crop, or of the whole frame where no box was named")
    frame_scores: tuple[float, ...] = Field(default=(), description="of the whole frame, where a box was named too")
    threshold: float
    model: str
    took_ms: float = 0.0


class EmbedRequest(Message):
    """Embeddings of texts, and where `image` is set of the newest frame, or of the crop at `bbox_xyxy` in it."""

    texts: tuple[Annotated[str, Field(max_length=200)], ...] = Field(default=(), max_length=64)
    image: bool = False
    bbox_xyxy: BboxXyxy | None = None


class EmbedReply(Message):
    model: str
    image: tuple[float, ...] | None = Field(default=None, description="unit vector; none where no image was asked for")
    texts: tuple[tuple[float, ...], ...] = Field(default=(), description="one unit vector a text, in the order sent")


class ModelState(StrEnum):
    """How a model does."""

    READY = "ready"
    NOT_CONFIGURED = "not_configured"
    NOT_LOADED = "not_loaded"
    """Still loading, or its weights could not be read."""
    AWAY = "away"
    """It does not answer, or its server refuses."""
    ANSWERS_WRONG = "answers_wrong"
    """It answers, but not as asked."""


class ModelInfo(Message):
    role: str = Field(description="detector, clip, vlm or parser")
    name: str
    backend: str
    backends_ms: dict[str, float] = Field(
        default_factory=dict, description="the backends that were tried, fastest call of each in milliseconds"
    )
    threshold: float | None = None
    state: ModelState = ModelState.READY
    detail: str = Field(default="", description="for a person: why it is not ready, or not as fast as it could be")
