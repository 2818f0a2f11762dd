"""What happens to the ear, and what is to be done about it: the core's events and actions. Data only."""

from dataclasses import dataclass
from enum import StrEnum

from contracts.intent import Intent, Understood


class Tone(StrEnum):
    """Short sounds that need no voice. The ear stays open through them."""

    AWAKE = "awake"
    DONE = "done"
    TROUBLE = "trouble"


# what happens; `turn` is that of the action it answers, and one of an older turn is too late


@dataclass(frozen=True, slots=True)
class Woken:
    pass


@dataclass(frozen=True, slots=True)
class StopHeard:
    """In any reading, a partial one too."""

    words: str


@dataclass(frozen=True, slots=True)
class HeardOut:
    """`readings` without the wake word, the likeliest first. `spoke`: somebody said something, if only that word."""

    turn: int
    readings: tuple[str, ...]
    spoke: bool


@dataclass(frozen=True, slots=True)
class Meant:
    turn: int
    understood: Understood


@dataclass(frozen=True, slots=True)
class Begun:
    """A mission began, or waits for its turn. `able`: what of it the robot cannot do."""

    turn: int
    able: str = ""


@dataclass(frozen=True, slots=True)
class Replied:
    """An answer or a refusal, for a person."""

    turn: int
    sentence: str


@dataclass(frozen=True, slots=True)
class Stopped:
    """`reached`: robot_bridge said that the emergency stop is set."""

    turn: int
    reached: bool


@dataclass(frozen=True, slots=True)
class Away:
    """Who was asked did not answer."""

    turn: int
    service: str
    why: str


@dataclass(frozen=True, slots=True)
class Sounding:
    """The loudspeaker begins."""

    turn: int


@dataclass(frozen=True, slots=True)
class Spoken:
    """It has ended, or was cut off."""

    turn: int


@dataclass(frozen=True, slots=True)
class News:
    """Something to say when nothing else is said."""

    sentence: str


Event = Woken | StopHeard | HeardOut | Meant | Begun | Replied | Stopped | Away | Sounding | Spoken | News


# what is to be done about it


@dataclass(frozen=True, slots=True)
class Listen:
    """`again`: what was heard before this moment is not listened to once more."""

    turn: int
    again: bool = False


@dataclass(frozen=True, slots=True)
class Understand:
    turn: int
    readings: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Send:
    turn: int
    intent: Intent


@dataclass(frozen=True, slots=True)
class Say:
    turn: int
    sentence: str


@dataclass(frozen=True, slots=True)
class StopRobot:
    turn: int
    words: str


@dataclass(frozen=True, slots=True)
class Sound:
    tone: Tone


@dataclass(frozen=True, slots=True)
class Hold:
    """The mission stands for a while, or a while longer."""


@dataclass(frozen=True, slots=True)
class LetGo:
    """It goes on, if the ear was what held it."""


Action = Listen | Understand | Send | Say | StopRobot | Sound | Hold | LetGo
