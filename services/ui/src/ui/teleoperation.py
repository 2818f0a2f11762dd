"""Driving by hand: what a held stick means, and when it no longer counts. Pure.

A dead man's lease at every step: the browser speaks ten times a second while the stick is held, each word is worth
`lease_s` at the wheels, and a word that was long on its way is worth nothing.
"""

import math
from dataclasses import dataclass
from typing import Final

from pydantic import Field

from contracts.base import Message
from contracts.geometry import Twist2D

CENTRE: Final = 0.08
"""A stick this near to its middle is let go."""


class Stick(Message):
    """What the browser says while somebody drives."""

    t_ms: float = Field(ge=0.0, description="the browser's own clock, milliseconds")
    forward: float = Field(ge=-1.0, le=1.0)
    turn: float = Field(ge=-1.0, le=1.0, description="counter-clockwise positive")

    @property
    def let_go(self) -> bool:
        return math.hypot(self.forward, self.turn) < CENTRE


def twist(stick: Stick, *, speed_m_s: float, turn_rad_s: float) -> Twist2D:
    """Gentle near the middle: the square of the way. Backwards at half the speed."""
    if stick.let_go:
        return Twist2D()
    forward = math.copysign(stick.forward**2, stick.forward) * speed_m_s
    turn = math.copysign(stick.turn**2, stick.turn) * turn_rad_s
    return Twist2D(linear_x=forward if forward >= 0.0 else forward / 2.0, angular_z=turn)


@dataclass(slots=True)
class Delay:
    """How long words are on their way, beyond the quickest of this connection: two clocks, no agreement needed."""

    offset_s: float = math.inf

    def of(self, t_ms: float, received_s: float) -> float:
        offset_s = received_s - t_ms / 1000.0
        self.offset_s = min(self.offset_s, offset_s)
        return offset_s - self.offset_s
