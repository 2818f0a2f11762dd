"""What a sentence asks for: the wanted action and the wanted things (requirement L1), and the question back."""

from enum import StrEnum
from typing import Annotated

from pydantic import Field

from contracts.asking import About
from contracts.base import NO_CONTROL_CHARACTERS, Message
from contracts.reading import Mood
from contracts.vision import Target


class WantedAction(StrEnum):
    FIND = "find"
    """Look for it and drive up to it."""
    BRING = "bring"
    """'bring me an apple': found and driven up to; a robot without an arm says that it carries nothing."""
    POUR = "pour"
    """'pour the medicine': asked back by a robot without an arm."""
    GO = "go"
    """'go to the couch': found and driven up to; 'go to the kitchen': driven to, where memory knows the room."""
    DOCK = "dock"
    MOVE = "move"
    """Plain motions, asked for as an action and not in words (`contracts.actions`)."""
    ASK = "ask"
    """A question: `POST /ask` answers it."""
    COUNT = "count"
    """'how many cups are there?': a question too."""
    STOP = "stop"
    PAUSE = "pause"
    RESUME = "resume"
    EMERGENCY = "emergency"
    NOTHING = "nothing"
    """It asks for nothing; `mood` says what it is: a denial, thanks, a statement, not understood."""

    @property
    def is_question(self) -> bool:
        return self in {WantedAction.ASK, WantedAction.COUNT}


class Intent(Message):
    """One sentence as typed data. Nothing has begun: `command` goes to `POST /missions`, or to `POST /ask`."""

    action: WantedAction
    command: str = Field(max_length=500, description="the words that were read, as they are to be sent on")
    targets: tuple[Target, ...] = Field(default=(), max_length=8, description="the things asked for, known classes")
    unknown: tuple[str, ...] = Field(default=(), max_length=8, description="what was asked for and is no known class")
    room: str | None = Field(default=None, max_length=64, description="'kitchen': where to look, or to go")
    about: About | None = Field(default=None, description="of a question")
    mood: Mood
    able: str = Field(default="", max_length=300, description="what the robot cannot do of it; '' = it can do all")


class Understand(Message):
    """`POST /understand`: what one saying was heard as, the likeliest first."""

    readings: tuple[Annotated[str, Field(max_length=500, pattern=NO_CONTROL_CHARACTERS)], ...] = Field(
        min_length=1, max_length=4, description="of one saying: with our names expected, then plain; typed words alone"
    )


class Choice(Message):
    text: str = Field(max_length=200, description="for a person: 'bring the blue cup'")
    intent: Intent


class Understood(Message):
    """What was meant; or, where the readings differ, the question back. Nothing has begun."""

    intent: Intent | None = Field(default=None, description="what all readings mean; none where a person must say")
    question: str = Field(default="", max_length=500, description="for a person: 'The blue cup or the blue cap?'")
    choices: tuple[Choice, ...] = Field(default=(), max_length=4, description="what it may mean, the likeliest first")
