"""What every service tells Prometheus alike: whether it is ready, the beat of its loops, and how long calls took."""

import time
from collections.abc import Sequence

from prometheus_client import Gauge, Histogram

from contracts.problem import Dependency

READY = Gauge("service_ready", "1 while every dependency is; asked at each scrape", ["service"])
DEPENDENCY_READY = Gauge("service_dependency_ready", "1 while it is", ["service", "dependency"])
PERIODS = Histogram(
    "loop_period_seconds",
    "between two rounds of a loop that keeps a rate; the spread is its jitter",
    ["loop"],
    buckets=(0.01, 0.025, 0.04, 0.06, 0.075, 0.09, 0.11, 0.15, 0.2, 0.3, 0.45, 0.55, 0.75, 1.0, 2.0, 5.0, 10.0),
)
CALLS = Histogram(
    "http_client_request_duration_seconds",
    "a call of another service; status 0 = it gave no answer",
    ["server", "method", "status"],
    buckets=(0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0),
)


class Rounds:
    """The beat of one loop, which calls `turn` once a round."""

    def __init__(self, loop: str) -> None:
        self._seconds = PERIODS.labels(loop)
        self._last_s: float | None = None

    def turn(self) -> None:
        now_s = time.perf_counter()
        if self._last_s is not None:
            self._seconds.observe(now_s - self._last_s)
        self._last_s = now_s


def tell_ready(service: str, dependencies: Sequence[Dependency]) -> None:
    READY.labels(service).set(all(one.ok for one in dependencies))
    for one in dependencies:
        DEPENDENCY_READY.labels(service, one.name).set(one.ok)
