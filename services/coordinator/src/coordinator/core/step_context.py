"""One step being worked out: the mission as it changes, and the actions that go with it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, Concatenate, ParamSpec, TypeVar

from contracts.mission import NO_FACTS, EventFacts, EventKind, MissionState
from contracts.robot import GOAL_ANSWER_S, CandidatePose
from coordinator.core import actions as do
from coordinator.core.activities import (
    Activity,
    AwaitingFrame,
    Driving,
    Navigating,
    Paused,
    Rotating,
    Starting,
    Waiting,
)  # fmt: skip
from coordinator.core.mission import Approach, Candidate, Mission, Search
from coordinator.core.rules import Rules
from coordinator.core.transitions import ALLOWED


class ForbiddenTransitionError(AssertionError):
    """The core tried to leave its own table: a bug."""


P = ParamSpec("P")
First = TypeVar("First")


def _writer(part: str, constructor: Callable[P, object]) -> Callable[Concatenate[StepContext, P], None]:
    """Sets fields of one part of the mission: pyright checks them by the part's own constructor."""
    del constructor

    def update(context: StepContext, *_: P.args, **changes: P.kwargs) -> None:
        changed: Any = replace(getattr(context, part), **changes)
        context.mission = changed if part == "mission" else replace(context.mission, **{part: changed})

    return update


def _all_but_the_first(constructor: Callable[Concatenate[First, P], object]) -> Callable[P, object]:
    """The one field that has no default: a mission's rules and a candidate's sighting are not set one by one."""
    return partial(constructor)  # pyright: ignore[reportReturnType, reportCallIssue]


@dataclass(slots=True)
class StepContext:
    """Lives for one step; the functions of the core work on it, and only it is mutable."""

    mission: Mission
    now_s: float
    actions: list[do.Action] = field(default_factory=list[do.Action])

    @property
    def rules(self) -> Rules:
        return self.mission.rules

    @property
    def search(self) -> Search:
        return self.mission.search

    @property
    def candidate(self) -> Candidate:
        assert self.mission.candidate is not None, "this state has a candidate"
        return self.mission.candidate

    @property
    def approach(self) -> Approach:
        return self.mission.approach or Approach()

    @property
    def robot_now_s(self) -> float:
        """The present on the clock that stamps frames."""
        return self.now_s + self.mission.robot.offset_s

    update = _writer("mission", _all_but_the_first(Mission))
    update_search = _writer("search", Search)
    update_candidate = _writer("candidate", _all_but_the_first(Candidate))
    update_approach = _writer("approach", Approach)

    def request(self, action: do.Action) -> None:
        self.actions.append(action)

    def log_event(self, kind: EventKind, text: str, facts: EventFacts = NO_FACTS) -> None:
        self.update(progress=text)
        self.request(do.Say(self.mission.state, kind, text, facts))

    def set_activity(self, activity: Activity) -> None:
        self.update(activity=activity)

    def transition_to(
        self, state: MissionState, reason: str, *, kind: EventKind = EventKind.STATE, facts: EventFacts = NO_FACTS
    ) -> None:
        """Changes the state, with its reason in words; the new state's `begin` runs next."""
        if state not in ALLOWED[self.mission.state]:
            raise ForbiddenTransitionError(f"{self.mission.state} -> {state}: {reason}")
        before = self.mission.state
        self.update(state=state, activity=Starting())
        self.log_event(kind, reason, facts.model_copy(update={"before": before}))

    def call(self) -> int:
        self.update(calls=self.mission.calls + 1)
        return self.mission.calls

    def stop_motion(self) -> None:
        self.request(do.StopMotion())

    def count_failure(self) -> None:
        self.update(failures=self.mission.failures + 1)

    def retry_later(self, service: str, detail: str, *, stopped: bool = False) -> None:
        """One more call failed in a row: the state is taken up again after a pause (`outcomes.retry_or_abort` ends it).

        `stopped`: an emergency stop cut it off. It is not said to be tried again: word of the stop is about to end it.
        """
        self.count_failure()
        how = "cut off by the emergency stop" if stopped else f"{detail}; trying again"
        self.log_event(EventKind.FAILURE, f"{service}: {how}", EventFacts(service=service))
        grown_s = self.rules.retry_wait_s * self.rules.retry_wait_factor ** (self.mission.failures - 1)
        self.set_activity(Waiting(self.now_s + min(grown_s, self.rules.retry_wait_s_max), service))

    def pause(self, why: str, *, for_s: float | None = None) -> None:
        """Until a person resumes it, or for so long. A pause that is made longer began when it began."""
        before = self.mission.activity
        since_s = before.since_s if isinstance(before, Paused) else self.now_s
        until_s = self.now_s + (self.rules.pause_timeout_s if for_s is None else for_s)
        self.stop_motion()
        self.set_activity(Paused(since_s=since_s, until_s=until_s, why=why, resumes=for_s is not None))
        self.log_event(EventKind.PAUSE, why)

    # calls, each with the activity that awaits its answer

    def look(self, wait_s: float) -> None:
        after_s = self.robot_now_s + self.rules.look_settle_s
        self.set_activity(AwaitingFrame(after_s=after_s, until_s=self.now_s + self.rules.look_settle_s + wait_s))

    def turn(self, angle_rad: float, speed_rad_s: float) -> None:
        call, limit_s = self.call(), self.rules.turn_timeout_s
        self.request(do.Rotate(call, angle_rad, speed_rad_s, limit_s))
        self.set_activity(Rotating(call, self._until(limit_s)))

    def drive(self, distance_m: float) -> None:
        call, speed = self.call(), self.rules.approach_speed_m_s
        limit_s = abs(distance_m) / speed * 1.5 + 5.0
        self.request(do.Drive(call, distance_m, speed, limit_s))
        self.set_activity(Driving(call, self._until(limit_s)))

    def navigate(self, candidates: tuple[CandidatePose, ...], ring_radius_m: float | None = None) -> None:
        """The bridge checks them first, so its answer may take a while."""
        call, limit_s = self.call(), self.rules.goal_timeout_s
        self.request(do.Navigate(call, candidates, limit_s, ring_radius_m))
        self.set_activity(Navigating(call, self._until(GOAL_ANSWER_S + limit_s), candidates))

    def _until(self, limit_s: float) -> float:
        return self.now_s + limit_s + self.rules.call_margin_s
