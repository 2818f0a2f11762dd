"""What an exploration goes by: how long, who leads, when to ask, what it may spend, when it gives up."""

import math
from dataclasses import dataclass, field

from contracts.exploration import ExplorationMode
from coordinator.exploration.decision_check import CheckLimits


@dataclass(frozen=True, slots=True)
class AskingRules:
    """When the model is asked (requirement C8)."""

    moved_m: float = 1.5
    due_s: float = 10.0
    place_m: float = 0.5
    """A doorway, junction or dead end counts once the robot is this far from where it last asked."""
    view_bits: int = 8
    """Two views that differ in no more of the 64 bits of their hash are the same: measured, docs/exploration.md."""
    unseen_m: float = 0.3
    unseen_rad: float = math.radians(20.0)
    """Without a picture: the view is another one from so far on."""
    again_s: float = 2.0
    """Between a call that failed and the next."""
    answer_s: float = 10.0
    """An answer that takes longer comes too late: the robot is elsewhere."""
    tool_turns_max: int = 4
    """Tools that move nothing, one after another, within one question."""
    refusals_max: int = 3
    """Refused in a row: one stretch is explored without the model."""
    unchanged_max: int = 7
    """Turns in a row, more than once round, after which the view is still the same (a dark room, a covered camera):
    one stretch is explored without the model."""


@dataclass(frozen=True, slots=True)
class WatchdogRules:
    """What the robot does while a model owes an answer (requirement C9): from so many seconds on."""

    stand_s: float = 3.0
    local_s: float = 10.0
    home_s: float = 30.0


@dataclass(frozen=True, slots=True)
class SpendingLimits:
    calls_max: int = 300
    tokens_max: int = 300_000
    seconds_max: float = 1800.0
    """That the model has been waited for in all."""


@dataclass(frozen=True, slots=True)
class ExplorationRules:
    pilot: ExplorationMode = ExplorationMode.MODEL
    """Who leads while all is well: MODEL, FRONTIERS or REACTIVE."""
    duration_s: float = 1200.0
    asking: AskingRules = field(default_factory=AskingRules)
    watchdog: WatchdogRules = field(default_factory=WatchdogRules)
    spending: SpendingLimits = field(default_factory=SpendingLimits)
    limits: CheckLimits = field(default_factory=CheckLimits)
    turn_s_max: float = 20.0
    goal_s_max: float = 120.0
    settle_s_max: float = 2.0
    """For a scan that was taken after a turn."""
    visits_max: int = 2
    """A frontier that was driven to so often and is still there is given up."""
    charts_to_believe: int = 3
    """So many maps in a row without a frontier that is left: all is explored."""
    home_tries_max: int = 3
    failed_pause_s: float = 1.0
    """After a motion that was not taken, or that somebody else ended: a lost session is back by then."""
    failures_max: int = 30
    """So many of those in a row end it."""
