"""What joint_states say of the arm: its own joints, numbers only, and rates where they are not told. Pure."""

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Final

RATE_OVER_S: Final = 0.05
"""A rate that is not told is the way over this time at least: over less, a servo's steps look like speed."""


@dataclass(frozen=True, slots=True)
class JointStates:
    """What the joints told last, by name: rad, rad/s, Nm, and when each did. A name that is missing was not told."""

    positions: dict[str, float]
    velocities: dict[str, float]
    efforts: dict[str, float]
    told_s: dict[str, float]

    def since(self, moment_s: float) -> "JointStates | None":
        """Of the joints that have told since then; none where none has."""
        names = {name for name, at_s in self.told_s.items() if at_s >= moment_s}

        def of(values: dict[str, float]) -> dict[str, float]:
            return {name: value for name, value in values.items() if name in names}

        states = JointStates(of(self.positions), of(self.velocities), of(self.efforts), of(self.told_s))
        return states if names else None


class Joints:
    """Puts messages together: they may come from several publishers, each telling of some of the joints.

    A joint whose velocity is not told is given the way since it told its own position before, over the time since.
    Called by one thread.
    """

    def __init__(self, ours: Collection[str]) -> None:
        self._ours = ours
        self._states = JointStates({}, {}, {}, {})
        self._befores: dict[str, tuple[float, float]] = {}  # a position and when, for a rate

    def read(
        self,
        names: Sequence[str],
        positions: Sequence[float],
        velocities: Sequence[float],
        efforts: Sequence[float],
        *,
        now_s: float,
    ) -> JointStates | None:
        """What is known with a message's lists, as sensor_msgs/JointState has them; None where it says nothing of the
        joints that are ours."""
        at = self._of_ours(names, positions)
        if not at:
            return None
        told, last = self._of_ours(names, velocities), self._states
        rates = {name: rate for name in at if (rate := told.get(name, self._rate(name, at[name], now_s))) is not None}
        efforts_now = {name: effort for name, effort in self._of_ours(names, efforts).items() if name in at}
        self._states = JointStates(
            last.positions | at,
            _without(last.velocities, at) | rates,
            _without(last.efforts, at) | efforts_now,
            last.told_s | dict.fromkeys(at, now_s),
        )
        return self._states

    def _rate(self, name: str, position: float, now_s: float) -> float | None:
        before, before_s = self._befores.setdefault(name, (position, now_s))
        if (elapsed_s := now_s - before_s) < RATE_OVER_S:
            return self._states.velocities.get(name)
        self._befores[name] = (position, now_s)
        return (position - before) / elapsed_s

    def _of_ours(self, names: Sequence[str], values: Sequence[float]) -> dict[str, float]:
        return {
            name: float(value)
            for name, value in zip(names, values, strict=False)
            if name in self._ours and math.isfinite(value)
        }


def _without(values: dict[str, float], names: Collection[str]) -> dict[str, float]:
    return {name: value for name, value in values.items() if name not in names}
