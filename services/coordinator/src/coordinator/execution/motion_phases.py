"""The phases of what is asked of the robot's wheels, what each carries, and what may follow what."""

import asyncio
from dataclasses import dataclass
from enum import StrEnum
from typing import ClassVar

from contracts.robot import Goal
from mesh.errors import MeshError


class MotionPhase(StrEnum):
    """Each member says whether a stop finds something to end in it."""

    to_end: bool

    def __new__(cls, value: str, to_end: bool) -> "MotionPhase":
        member = str.__new__(cls, value)
        member._value_ = value
        member.to_end = to_end
        return member

    IDLE = "idle", False
    """Nothing is asked for."""
    LEASED = "leased", True
    """A velocity was sent; it ends by itself soon."""
    CALLING = "calling", True
    """A call runs (rotate, drive, dock), or waits for what ran before."""
    SENDING = "sending", True
    """A goal is on its way; its id is not known yet."""
    FOLLOWING = "following", True
    """The goal was taken."""
    ENDING = "ending", False
    """A stop is at work."""
    UNCERTAIN = "uncertain", False
    """A call was not answered: the robot may move all the same, and the session is being dropped."""


_P = MotionPhase
FOLLOWS: dict[MotionPhase, frozenset[MotionPhase]] = {
    _P.IDLE: frozenset({_P.LEASED, _P.CALLING}),
    _P.LEASED: frozenset({_P.LEASED, _P.CALLING, _P.ENDING}),
    _P.CALLING: frozenset({_P.IDLE, _P.CALLING, _P.SENDING, _P.ENDING, _P.UNCERTAIN}),
    _P.SENDING: frozenset({_P.CALLING, _P.FOLLOWING, _P.ENDING, _P.UNCERTAIN}),
    _P.FOLLOWING: frozenset({_P.CALLING, _P.ENDING, _P.UNCERTAIN}),
    _P.ENDING: frozenset({_P.IDLE, _P.CALLING}),
    _P.UNCERTAIN: frozenset({_P.IDLE, _P.CALLING}),
}
"""What may come after each phase."""

Task = asyncio.Task[None]


@dataclass(frozen=True, slots=True, eq=False)
class Idle:
    phase: ClassVar = MotionPhase.IDLE


@dataclass(frozen=True, slots=True, eq=False)
class Leased:
    phase: ClassVar = MotionPhase.LEASED


@dataclass(frozen=True, slots=True, eq=False)
class Calling:
    phase: ClassVar = MotionPhase.CALLING
    task: Task


@dataclass(frozen=True, slots=True, eq=False)
class Sending:
    phase: ClassVar = MotionPhase.SENDING
    task: Task
    answer: asyncio.Task[Goal | MeshError]


@dataclass(frozen=True, slots=True, eq=False)
class Following:
    phase: ClassVar = MotionPhase.FOLLOWING
    task: Task
    goal: Goal
    over: asyncio.Future[Goal]


@dataclass(frozen=True, slots=True, eq=False)
class Ending:
    phase: ClassVar = MotionPhase.ENDING


@dataclass(frozen=True, slots=True, eq=False)
class Uncertain:
    phase: ClassVar = MotionPhase.UNCERTAIN


Motion = Idle | Leased | Calling | Sending | Following | Ending | Uncertain
