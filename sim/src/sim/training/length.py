"""How long a run of training lasts: a number of steps, or, on a machine that others use too, a number of minutes."""

import time
from collections.abc import Callable, Iterator
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

    def steps_from(self, first: int, now_s: Callable[[], float] = time.monotonic) -> Iterator[tuple[int, float]]:
        """The steps to do, from `first` on, each with the share of the run that is done before it."""
        began_s = now_s()
        for step in range(first, self.steps):
            if (spent := self.spent(step, now_s() - began_s)) >= 1.0:
                return
            yield step, spent
