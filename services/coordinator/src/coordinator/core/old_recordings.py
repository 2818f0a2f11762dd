"""Recordings of older forms as they are written today: the one place that still knows the old words and names.

Form 1 told ends in words; form 2 had other names for what a person asks and for the plain approach; until form 3
the core chose among paths.
"""

from collections.abc import Iterable, Iterator
from typing import Any

from contracts.motion import Hazard, MotionEnd

OLD_FORMS = frozenset({1, 2, 3})

SAID: dict[str, MotionEnd] = {
    "obstacle ahead": MotionEnd.BLOCKED,
    "obstacle behind": MotionEnd.BLOCKED,
    "timeout": MotionEnd.TIMED_OUT,
    "a wheel hangs in the air": MotionEnd.LIFTED,
    "the laser is blind ahead": MotionEnd.BLIND,
    "the laser is blind behind": MotionEnd.BLIND,
    "no laser scan": MotionEnd.NO_SCAN,
    "no odometry": MotionEnd.NO_ODOMETRY,
    "a navigation goal took over": MotionEnd.PREEMPTED,
    "the base drives itself": MotionEnd.BASE_BUSY,
    "emergency stop": MotionEnd.STOPPED,
    "reset": MotionEnd.RESET,
    "the session ended": MotionEnd.SESSION_ENDED,
    "the client went away": MotionEnd.CLIENT_LEFT,
    "cancelled": MotionEnd.CANCELED,
} | {f"hazard: {hazard.value}": MotionEnd.HAZARD for hazard in Hazard}


EVENTS: dict[str, str] = {
    "CancelAsked": "CancelRequested",
    "PauseAsked": "PauseRequested",
    "ResumeAsked": "ResumeRequested",
}
"""Events of forms 1 and 2, and their names today."""

APPROACH_RULES: dict[str, str] = {"seeds": "straight"}


def translated_header(header: dict[str, Any]) -> dict[str, Any]:
    if header.get("form") not in OLD_FORMS:
        return header
    rules: dict[str, Any] = header["rules"]
    rule = rules["approach_rule"]
    kept = {name: value for name, value in rules.items() if name != "path_timeout_s"}
    return header | {"rules": kept | {"approach_rule": APPROACH_RULES.get(rule, rule)}}


def translated_steps(form: int, goal_timeout_s: float, steps: Iterable[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    if form not in OLD_FORMS:
        return iter(steps)
    named = (step if form == 3 else _renamed(form, step) for step in steps)
    return _PathsChosen(goal_timeout_s).taken_out(named)


class _PathsChosen:
    """Until form 3 the core chose a reachable pose first (ChoosePath, PathChosen) and sent the goal then, once more
    where Nav2 aborted it. Now it is one call, and what the core did in between is left out."""

    def __init__(self, goal_timeout_s: float) -> None:
        self._goal_timeout_s = goal_timeout_s
        self._left_out = 0
        self._number: dict[int, int] = {0: 0}

    def taken_out(self, steps: Iterable[dict[str, Any]]) -> Iterator[dict[str, Any]]:
        for step in steps:
            event, actions = step["event"], step["actions"]
            sent = next((each for each in actions if each["is"] == "Navigate"), None)
            chosen, ended = event["is"] == "PathChosen", event["is"] == "GoalEnded"
            if "call" in event:
                event = event | {"call": self._number.get(event["call"], event["call"] - self._left_out)}
            if sent is not None and (chosen or ended):  # the next goal of one call
                self._left_out += 1
                self._number[sent["call"]] = event["call"]
                continue
            if chosen:
                event = _ended_without_a_path(event)
            translated = [new for each in actions for new in self._action(step["state"], each, actions)]
            yield step | {"event": event, "actions": translated}

    def _action(self, state: str, action: dict[str, Any], beside: list[dict[str, Any]]) -> Iterator[dict[str, Any]]:
        if "call" in action:
            self._number[action["call"]] = action["call"] - self._left_out
            action = action | {"call": self._number[action["call"]]}
        if action["is"] != "ChoosePath":
            yield action
            return
        to_it = state in {"APPROACHING", "DRIVING_1M"}
        if to_it and not any(each["is"] == "Say" and each["kind"] == "navigation" for each in beside):
            yield {"is": "Say", "state": state, "kind": "navigation", "text": "", "data": {}}
        ranks = ((rank, pose) for rank, group in enumerate(action["groups"]) for pose in group)
        candidates = [
            {"pose": pose, "cost_m": cost_m, "rank": rank}
            for (rank, pose), cost_m in zip(ranks, action["costs_m"], strict=True)
        ]
        yield {
            "is": "Navigate",
            "call": action["call"],
            "candidates": candidates if to_it else candidates[:1],
            "timeout_s": self._goal_timeout_s,
            "ring_radius_m": 0.0 if to_it else None,
        }


def _ended_without_a_path(event: dict[str, Any]) -> dict[str, Any]:
    """Of a chosen pose that was too near for a goal it is said that the robot is there."""
    ended = {"is": "GoalEnded", "call": event["call"]}
    if event["index"] is not None:
        return ended | {"status": "SUCCEEDED"}
    return ended | {"status": "ABORTED", "cause": "unreachable", "error": event["error"]}


def _renamed(form: int, step: dict[str, Any]) -> dict[str, Any]:
    event: dict[str, Any] = step["event"]
    event = event | {"is": EVENTS.get(event["is"], event["is"])}
    if event["is"] == "Localized":
        event = event | {"reply": _measurement(event["reply"])}
    if form == 1 and event["is"] == "MotionEnded":
        event = _typed_end(event)
    return step | {"event": event}


def _measurement(reply: dict[str, Any]) -> dict[str, Any]:
    """Until form 2 robot_bridge did not say how sure a distance is: the core had the requirements' formula (A9)."""
    distance_m = reply["distance_m"]
    sigma_m = 0.012 * distance_m**3.461 if distance_m is not None else None
    kept = {name: value for name, value in reply.items() if name != "reason"}
    return kept | {"sigma_m": sigma_m, "text": reply["reason"]}


def _typed_end(event: dict[str, Any]) -> dict[str, Any]:
    """Form 1 did not say whether `moved` was of a turn or of a drive: it is both."""
    last = event["reason"].split("; ")[-1]
    end = MotionEnd.COMPLETED if event["completed"] else SAID.get(last, MotionEnd.HELD_BACK)
    lengths = {"turned_rad": event["moved"], "driven_m": event["moved"]}
    return {"is": "MotionEnded", "call": event["call"], "end": end.value, "text": event["reason"]} | lengths
