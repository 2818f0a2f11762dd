"""What keeps the robot from going where Nav2 wants it to go: the safety filter, and since when. Pure."""

from dataclasses import dataclass

from robot_bridge.motion.arbiter import ArbitratedCommand
from robot_bridge.motion.words import restraint_in_words
from robot_bridge.safety.collision_monitor import Restraint

GAP_S = 0.5
"""Held again after longer than this, it is held anew: in between it may have driven or turned."""


@dataclass(frozen=True, slots=True)
class NavigationHold:
    """The safety filter has let nothing of what Nav2 wants to drive pass, from `since_s` to `last_s`."""

    restraint: Restraint
    since_s: float
    last_s: float

    @property
    def in_words(self) -> str:
        lasted_s = self.last_s - self.since_s
        return f"the safety filter held the robot for {lasted_s:.1f} s: {restraint_in_words(self.restraint)}"


def next_hold(hold: NavigationHold | None, choice: ArbitratedCommand, now_s: float) -> NavigationHold | None:
    """After one tick's `choice` for Nav2; a turn on the spot says nothing about the way."""
    if choice.wanted.linear_x == 0.0:
        return hold
    if (stopping := choice.stopping) is None or choice.twist.linear_x != 0.0:
        return None
    since_s = hold.since_s if hold is not None and now_s - hold.last_s <= GAP_S else now_s
    return NavigationHold(stopping, since_s, now_s)
