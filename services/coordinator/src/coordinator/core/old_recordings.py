"""Recordings of older forms as they are written today: the one place that still knows the old words and names.

Form 1 told ends in words; form 2 had other names for what a person asks and for the plain approach.
"""

from typing import Any

from contracts.motion import Hazard, MotionEnd

OLD_FORMS = frozenset({1, 2})

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
    return header | {"rules": rules | {"approach_rule": APPROACH_RULES.get(rule, rule)}}


def translated_step(form: int, step: dict[str, Any]) -> dict[str, Any]:
    if form not in OLD_FORMS:
        return step
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
