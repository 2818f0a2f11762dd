"""Questions a person asks (`POST /ask`), and answers that name the records they rest on."""

from enum import StrEnum

from pydantic import Field

from contracts.base import NO_CONTROL_CHARACTERS, Label, Message
from contracts.geometry import Pose2D


class About(StrEnum):
    """What a question was taken to be about."""

    LAST_SEEN = "last_seen"
    """Where did you last see my keys?"""
    CONTENTS = "contents"
    """What is in the kitchen? What do you know?"""
    DOING = "doing"
    """What are you doing, and why?"""
    HISTORY = "history"
    """What did you do? Did you find the cup?"""
    BATTERY = "battery"
    """How full is the battery?"""
    COUNT = "count"
    """How many bottles have you seen?"""
    CHANGES = "changes"
    """What changed?"""
    DISCOVERIES = "discoveries"
    """What did you discover? What have you explored?"""
    UNKNOWN = "unknown"
    """None of these: the answer says what can be asked."""


class Question(Message):
    question: str = Field(min_length=1, max_length=500, pattern=NO_CONTROL_CHARACTERS)


class Record(Message):
    """One fact an answer rests on, and where it can be looked up."""

    source: str = Field(description="memory, mission, robot, queue or exploration")
    id: str = Field(default="", description="of the view, object or mission in its service")
    text: str = Field(max_length=300)
    label: Label | None = None
    stamp_s: float | None = None
    pose: Pose2D | None = None


class Answer(Message):
    answer: str = Field(max_length=2000)
    about: About
    label: Label | None = Field(default=None, description="the kind of thing it was about")
    records: tuple[Record, ...] = Field(default=(), max_length=50)
    phrased_by: str = Field(description="'template', or the model that put the facts into words")
    notes: str = Field(default="", max_length=500, description="what could not be asked: a service that is away")
