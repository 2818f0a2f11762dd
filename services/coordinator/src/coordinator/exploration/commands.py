"""What an exploration asks of the shell. Each with a `call` is answered by one event of that number."""

from dataclasses import dataclass

from contracts.exploration import AskingReason, ExplorationEnd, ExplorationMemory, ExplorationMode
from contracts.geometry import Pose2D


@dataclass(frozen=True, slots=True)
class AskModel:
    """`situation`: what it is told, about 200 tokens. `answer`: what came of the tool it called before, '' = none."""

    call: int
    reason: AskingReason
    situation: str
    answer: str = ""


@dataclass(frozen=True, slots=True)
class TurnRobot:
    call: int
    angle_rad: float


@dataclass(frozen=True, slots=True)
class DriveRobot:
    """Straight ahead."""

    call: int
    distance_m: float
    speed_m_s: float


@dataclass(frozen=True, slots=True)
class NavigateRobot:
    call: int
    pose: Pose2D


@dataclass(frozen=True, slots=True)
class HaltMotion:
    """End what moves."""


@dataclass(frozen=True, slots=True)
class Remember:
    """Write down what is known now: once an action."""

    memory: ExplorationMemory


@dataclass(frozen=True, slots=True)
class TellMode:
    """For the timeline: who leads from now on, and why."""

    mode: ExplorationMode
    why: str


@dataclass(frozen=True, slots=True)
class Finish:
    end: ExplorationEnd


Command = AskModel | TurnRobot | DriveRobot | NavigateRobot | HaltMotion | Remember | TellMode | Finish
MOTION = TurnRobot | DriveRobot | NavigateRobot
