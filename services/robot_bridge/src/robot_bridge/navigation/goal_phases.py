"""The phases of the goal under way, what each carries, and what may follow what and why; see `docs/goal-phases.md`."""

from dataclasses import dataclass
from enum import StrEnum
from typing import ClassVar

from contracts.causes import GoalCause
from contracts.robot import GoalStatus
from robot_bridge.ports import AcceptedGoal


class GoalPhase(StrEnum):
    ASKING = "asking"
    """Nav2 has yet to say whether it takes the goal; none of its velocity passes."""
    DRIVING = "driving"
    """Nav2 has taken it, and its velocity passes."""
    RECOVERING = "recovering"
    """Nav2 gave it up under way: the robot gets room and the costmaps are cleared before it is asked again."""
    ENDING = "ending"
    """Somebody asked for the end, which Nav2 is to confirm; none of its velocity passes."""
    OVER = "over"
    """It has ended, and how is told."""


_P = GoalPhase
FOLLOWS: dict[GoalPhase, dict[GoalPhase, str]] = {
    _P.ASKING: {
        _P.DRIVING: "Nav2 takes it",
        _P.ENDING: "cancelled, preempted or its session ended",
        _P.OVER: "no path leads there, rejected, Nav2 is gone, or the emergency stop",
    },
    _P.DRIVING: {
        _P.RECOVERING: "Nav2 gives up with a code that another try may cure",
        _P.ENDING: "cancelled, preempted or its time is up",
        _P.OVER: "arrived, aborted, Nav2 is gone, or the emergency stop",
    },
    _P.RECOVERING: {
        _P.ASKING: "the robot has room and the costmaps are fresh",
        _P.ENDING: "cancelled or preempted",
        _P.OVER: "Nav2 is gone, or the emergency stop",
    },
    _P.ENDING: {
        _P.ENDING: "Nav2 takes it only now, and is told at once to give it up",
        _P.OVER: "Nav2 confirms, or does not in time, or the emergency stop",
    },
    _P.OVER: {},
}
"""What may come after each phase, and why."""


@dataclass(frozen=True, slots=True, eq=False)
class Asking:
    phase: ClassVar = GoalPhase.ASKING
    accepted: ClassVar = None


@dataclass(frozen=True, slots=True, eq=False)
class Driving:
    phase: ClassVar = GoalPhase.DRIVING
    accepted: AcceptedGoal


@dataclass(frozen=True, slots=True, eq=False)
class Recovering:
    phase: ClassVar = GoalPhase.RECOVERING
    accepted: ClassVar = None


@dataclass(frozen=True, slots=True, eq=False)
class Ending:
    """`status` and `cause` are what it ends as."""

    phase: ClassVar = GoalPhase.ENDING
    status: GoalStatus
    cause: GoalCause
    accepted: AcceptedGoal | None


@dataclass(frozen=True, slots=True, eq=False)
class Over:
    phase: ClassVar = GoalPhase.OVER
    accepted: ClassVar = None


Phase = Asking | Driving | Recovering | Ending | Over


def page() -> str:
    """`docs/goal-phases.md`, whole."""
    arrows = "\n".join(
        f"    {before} --> {after}: {why}" for before, to in FOLLOWS.items() for after, why in to.items()
    )
    return (
        "# The phases of a navigation goal\n\n"
        "Written from `robot_bridge/navigation/goal_phases.py` (`page()`); a test compares them.\n\n"
        f"```mermaid\nstateDiagram-v2\n    [*] --> {GoalPhase.ASKING}\n{arrows}\n```\n\n"
        "Nav2's velocity reaches the wheels only while a goal is driving. The emergency stop ends a goal from every "
        "phase at once. What a client is told of it are Nav2's own words (`GoalStatus`).\n"
    )
