"""What joint_states say of the arm: its own joints, numbers only, and rates where they are not told. Pure."""

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class JointStates:
    """What the joints told, by name: rad, rad/s, Nm. A name that is missing was not told."""

    positions: dict[str, float]
    velocities: dict[str, float]
    efforts: dict[str, float]


def read(
    names: Sequence[str],
    positions: Sequence[float],
    velocities: Sequence[float],
    efforts: Sequence[float],
    *,
    ours: Collection[str],
    before: JointStates | None,
    elapsed_s: float | None,
) -> JointStates | None:
    """A message's lists, as sensor_msgs/JointState has them; None where it says nothing of the joints that are `ours`.

    A driver may leave velocities out: they are then the way since the message `before`, over the time since.
    """

    def told(values: Sequence[float]) -> dict[str, float]:
        return {
            name: float(value)
            for name, value in zip(names, values, strict=False)
            if name in ours and math.isfinite(value)
        }

    now = told(positions)
    if not now:
        return None
    rates = told(velocities)
    if not rates and before is not None and elapsed_s is not None and elapsed_s > 0.0:
        rates = {
            name: (at - before.positions[name]) / elapsed_s for name, at in now.items() if name in before.positions
        }
    return JointStates(now, rates, told(efforts))
