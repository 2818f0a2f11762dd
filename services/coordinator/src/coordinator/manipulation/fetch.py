"""A fetch as it stands: one immutable value."""

from dataclasses import dataclass, field

from contracts.geometry import Pose2D
from contracts.manipulation import FetchCause, FetchEnd, Holding, ManipulationState
from coordinator.manipulation.recoveries import FetchRecovery
from coordinator.manipulation.transitions import Task


@dataclass(frozen=True, slots=True)
class FetchRules:
    """How long a task may take, and all of it. A call that takes longer has failed."""

    fetch_s_max: float = 600.0
    plan_s_max: float = 20.0
    arm_s_max: float = 40.0
    drive_s_max: float = 180.0
    look_s_max: float = 15.0
    hand_s_max: float = 60.0


@dataclass(frozen=True, slots=True)
class FetchEnding:
    """Decided; told when the arm is folded, or cannot be."""

    end: FetchEnd
    cause: FetchCause | None = None


@dataclass(frozen=True, slots=True)
class Fetch:
    """All that `step` knows."""

    rules: FetchRules = field(default_factory=FetchRules)
    state: ManipulationState = ManipulationState.IDLE
    why: str = ""
    goal: Pose2D | None = None
    hand_over: bool = True
    started_s: float = 0.0
    # what is done now
    tasks: tuple[Task, ...] = ()
    """Of this state, those not done yet; the first is under way."""
    call: int = 0
    """That is waited for; 0 = none."""
    until_s: float = 0.0
    next_call: int = 1
    # the thing
    holding: Holding = Holding.EMPTY
    at_goal: bool = False
    """The robot is where the thing is wanted."""
    stance: Pose2D | None = None
    tried: tuple[Pose2D, ...] = ()
    grasp: int = 0
    grasps: int = 0
    # what went wrong
    cause: FetchCause | None = None
    failed_in: ManipulationState | None = None
    undone: tuple[Task, ...] = ()
    """Of the state that failed: the task that did, and those after it."""
    recovery: FetchRecovery | None = None
    used: tuple[FetchRecovery, ...] = ()
    ending: FetchEnding | None = None
    # the emergency stop
    stopped: bool = False
    epoch: int | None = None

    @property
    def running(self) -> bool:
        return self.state is not ManipulationState.IDLE
