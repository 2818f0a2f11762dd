"""Recordings of form 1, written when the bridge told ends in words: the one table that still knows those words."""

from typing import Any

from contracts.motion import Hazard, MotionEnd

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


def from_form_1(step: dict[str, Any]) -> dict[str, Any]:
    """A recorded step as it is written today. Whether `moved` was of a turn or of a drive was not told: it is both."""
    event: dict[str, Any] = step["event"]
    if event["is"] != "MotionEnded":
        return step
    last = event["reason"].split("; ")[-1]
    end = MotionEnd.COMPLETED if event["completed"] else SAID.get(last, MotionEnd.HELD_BACK)
    lengths = {"turned_rad": event["moved"], "driven_m": event["moved"]}
    told = {"is": "MotionEnded", "call": event["call"], "end": end.value, "text": event["reason"]}
    return step | {"event": told | lengths}
