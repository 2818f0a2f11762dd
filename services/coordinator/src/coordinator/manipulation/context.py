"""One step under way: the fetch as it has become so far, and the commands so far."""

from dataclasses import replace
from typing import Any, Literal

from contracts.manipulation import FetchCause, FetchEnd, ManipulationState
from coordinator.manipulation import commands as do
from coordinator.manipulation.fetch import Fetch
from coordinator.manipulation.transitions import ALLOWED, TASKS, ForbiddenStateError, Task

_Question = Literal[
    Task.PLAN_STANCE, Task.PLAN_GRASP, Task.PLAN_SPOT, Task.LOOK, Task.CHECK_HOLD, Task.AWAIT_HAND
]  # fmt: skip


class ManipulationContext:
    """Mutable for one `step` only."""

    def __init__(self, fetch: Fetch, now_s: float) -> None:
        self.fetch = fetch
        self.now_s = now_s
        self.commands: list[do.Command] = []

    def update(self, **changes: Any) -> None:
        self.fetch = replace(self.fetch, **changes)

    def become(self, state: ManipulationState, why: str, tasks: tuple[Task, ...] | None = None) -> None:
        """And begins its first task. `tasks`: none = those of the state. Raises `ForbiddenStateError`."""
        if state not in ALLOWED[self.fetch.state]:
            raise ForbiddenStateError(f"{self.fetch.state} to {state} ({why})")
        self.update(state=state, why=why, tasks=TASKS[state] if tasks is None else tasks, call=0)
        self.commands.append(do.TellFetchState(state, why))
        self.begin_task()

    def begin_task(self) -> None:
        """The first of those left; of none, nothing."""
        if self.fetch.tasks:
            self._ask(self.fetch.tasks[0])

    def halt(self) -> None:
        """Whatever is under way ends; its answer will be too late."""
        if self.fetch.call:
            self.commands.append(do.HaltManipulation())
        self.update(call=0)

    def finish(self, end: FetchEnd, cause: FetchCause | None = None, *, folded: bool, why: str) -> None:
        """Nothing is asked for after it."""
        self.halt()
        self.become(ManipulationState.IDLE, why)
        self.commands.append(do.FinishFetch(end, cause, folded))

    def _ask(self, task: Task) -> None:
        call = self.fetch.next_call
        command, seconds = self._command(task, call)
        self.update(next_call=call + 1, call=call, until_s=self.now_s + seconds)
        self.commands.append(command)

    def _command(self, task: Task, call: int) -> tuple[do.Command, float]:
        """What asks for it, and how long its answer may take, s."""
        fetch, rules = self.fetch, self.fetch.rules
        match task:
            case Task.FOLD:
                return do.FoldArm(call), rules.arm_s_max
            case Task.OPEN | Task.LET_GO | Task.CLOSE:
                return do.MoveJaw(call, open=task is not Task.CLOSE), rules.arm_s_max
            case Task.DRIVE_TO_STANCE | Task.DRIVE_TO_GOAL:
                pose = fetch.stance if task is Task.DRIVE_TO_STANCE else fetch.goal
                if pose is None:
                    raise ForbiddenStateError(f"{task} with nowhere to drive to")
                return do.DriveBase(call, pose, carrying=task is Task.DRIVE_TO_GOAL), rules.drive_s_max
            case Task.MOVE_BEFORE | Task.MOVE_TO | Task.RAISE | Task.BACK_OFF | Task.HOLD_OUT | Task.MOVE_TO_SPOT:
                return do.MoveArm(call, task, fetch.grasp), rules.arm_s_max
            case _:
                return self._question(task, call)

    def _question(self, task: _Question, call: int) -> tuple[do.Command, float]:
        rules = self.fetch.rules
        match task:
            case Task.PLAN_STANCE:
                return do.PlanStance(call, self.fetch.tried), rules.plan_s_max
            case Task.PLAN_GRASP:
                return do.PlanGrasps(call), rules.plan_s_max
            case Task.PLAN_SPOT:
                return do.PlanSpot(call), rules.plan_s_max
            case Task.LOOK:
                return do.LookAtThing(call), rules.look_s_max
            case Task.CHECK_HOLD:
                return do.CheckHold(call), rules.look_s_max
            case Task.AWAIT_HAND:
                return do.AwaitHand(call), rules.hand_s_max
