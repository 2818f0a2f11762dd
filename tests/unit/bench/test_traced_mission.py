"""A mission that is recorded is the mission that is played without."""

import random

from opentelemetry.sdk.trace import TracerProvider

from bench.traced_mission import OwnIds


def test_a_span_draws_nothing_from_what_the_episode_has_seeded() -> None:
    random.seed(1)
    before = random.getstate()
    TracerProvider(id_generator=OwnIds()).get_tracer("sample").start_span("drive")
    assert random.getstate() == before
