"""A trajectory of joints, and where it says they are when, as ros2_control's joint_trajectory_controller reads it."""

import math
from bisect import bisect_left
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Knot:
    """Where the joints are to be (rad), and how fast (rad/s; empty = not said), so long after the start."""

    time_s: float
    positions: tuple[float, ...]
    velocities: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class Trajectory:
    """Joint names, and knots at rising times; the way to the first begins where the joints are at the start."""

    joints: tuple[str, ...]
    knots: tuple[Knot, ...]

    @property
    def duration_s(self) -> float:
        return self.knots[-1].time_s

    def in_order(self, joints: tuple[str, ...]) -> "Trajectory":
        """The same, with the joints in another order. `joints` names the same ones."""
        at = [self.joints.index(name) for name in joints]

        def ordered(values: tuple[float, ...]) -> tuple[float, ...]:
            return tuple(values[i] for i in at) if values else ()

        return Trajectory(
            joints, tuple(Knot(each.time_s, ordered(each.positions), ordered(each.velocities)) for each in self.knots)
        )

    def why_invalid(self, joints: tuple[str, ...]) -> str:
        """What the controller of `joints` would reject it for; '' for nothing."""
        if sorted(self.joints) != sorted(joints):
            return f"it names {', '.join(self.joints) or 'no joint'}, not all of {', '.join(joints)}"
        if not self.knots:
            return "it has no point"
        before_s = -math.inf
        for knot in self.knots:
            if len(knot.positions) != len(joints) or len(knot.velocities) not in {0, len(joints)}:
                return "a point has not one value for each joint"
            if not all(map(math.isfinite, (knot.time_s, *knot.positions, *knot.velocities))):
                return "a number is not finite"
            if knot.time_s < 0.0 or knot.time_s <= before_s:
                return "its times do not rise"
            before_s = knot.time_s
        return ""

    def at(self, time_s: float, start: tuple[float, ...]) -> tuple[float, ...]:
        """Positions (rad) so long after the start: a line between knots, or a cubic where both tell their velocities.

        `start` is where the joints stood, at rest.
        """
        index = bisect_left([knot.time_s for knot in self.knots], time_s)
        if index == len(self.knots):
            return self.knots[-1].positions
        after = self.knots[index]
        before = self.knots[index - 1] if index else Knot(0.0, start, tuple(0.0 for _ in start))
        span_s = after.time_s - before.time_s
        share = (time_s - before.time_s) / span_s if span_s > 0.0 else 1.0
        if not (before.velocities and after.velocities):
            return tuple(
                one + share * (other - one) for one, other in zip(before.positions, after.positions, strict=True)
            )
        return tuple(
            _hermite(share, span_s, one, other, v_one, v_other)
            for one, other, v_one, v_other in zip(
                before.positions, after.positions, before.velocities, after.velocities, strict=True
            )
        )


def _hermite(share: float, span_s: float, one: float, other: float, v_one: float, v_other: float) -> float:
    """The cubic with these ends and end velocities."""
    square, cube = share * share, share**3
    return (
        (2 * cube - 3 * square + 1) * one
        + (cube - 2 * square + share) * span_s * v_one
        + (3 * square - 2 * cube) * other
        + (cube - square) * span_s * v_other
    )
