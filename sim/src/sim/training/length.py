"""How long a run of training lasts: a number of steps, or, on a machine that others use too, a number of minutes."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Length:
    """`minutes` (of this run alone, one that goes on begins anew) end it before its `steps` do; None: never."""

    steps: int
    minutes: float | None = None

    def spent(self, step: int, passed_s: float) -> float:
        """The share of the run that is done, 0 to 1; a learning rate that follows it comes down by the end."""
        by_steps = step / self.steps
        return min(1.0, by_steps if self.minutes is None else max(by_steps, passed_s / (60 * self.minutes)))
