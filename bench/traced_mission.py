"""One mission of the whole mesh in one process with every span of it recorded: what `make trace` then draws.

`python -m bench.traced_mission --number 3`; `make bench-trace` draws it too. Spans are stamped with simulated time. It
takes about four minutes of processor time, half of them for a tour of the home that is kept for the next time: what it
is at is said, so that a busy machine does not look like one that hangs.
"""

import argparse
import asyncio
import random
import sys
import time
from pathlib import Path

from opentelemetry import trace
from opentelemetry.sdk import trace as recording
from opentelemetry.sdk.trace import ReadableSpan, SpanProcessor, TracerProvider
from opentelemetry.sdk.trace.export import SimpleSpanProcessor
from opentelemetry.sdk.trace.id_generator import IdGenerator

from bench.calls import TOURS
from bench.search.play import STARTED_S, played
from bench.search.running import begin, loaded, prepare_exports, say
from bench.search.sets import TUNE_HOMES, episode
from bench.world.tour import toured
from contracts.mission import MissionState
from mesh.span_file import SpanFile
from sim.home import Home

STATES = frozenset(state.value for state in MissionState)


class OwnIds(IdGenerator):
    """The SDK's own draws from `random`, which the episode has seeded: recording would play another mission."""

    def __init__(self) -> None:
        self._random = random.SystemRandom()

    def generate_span_id(self) -> int:
        return self._random.getrandbits(64) or 1

    def generate_trace_id(self) -> int:
        return self._random.getrandbits(128) or 1


def simulated_ns() -> int:
    """The monotonic clock's where no episode plays: the SDK's own threads ask, to know when to give up."""
    try:
        return int(asyncio.get_running_loop().time() * 1e9)
    except RuntimeError:
        return time.monotonic_ns()


class Told(SpanProcessor):
    """Says each state of the mission at its end, with the simulated seconds since the robot was there."""

    def on_end(self, span: ReadableSpan) -> None:
        if span.name in STATES and span.end_time is not None:
            say(f"{span.end_time / 1e9 - STARTED_S:7.1f} s  {span.name}")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--number", type=int, default=0, help="of the episode of bench.search's set 'mapped'")
    parser.add_argument("--out", type=Path, default=Path("out/bench/traces"))
    options = parser.parse_args()
    begin()
    prepare_exports("sim")
    models, settings = loaded("sim")
    one = episode("mapped", options.number, TUNE_HOMES)
    say("a tour of the home, where none is kept of it")
    toured(Home.generate(one.home_seed), models, settings, TOURS)  # nobody's command
    for file in options.out.glob("mesh.jsonl*"):
        file.unlink()
    provider = TracerProvider(id_generator=OwnIds())
    provider.add_span_processor(SimpleSpanProcessor(SpanFile(options.out / "mesh.jsonl")))
    provider.add_span_processor(Told())
    trace.set_tracer_provider(provider)
    recording.time_ns = simulated_ns
    say(f"the mission: {one.commands[0].text}")
    (row,) = played(one, models, settings, tours=TOURS)["missions"]
    say(f"{row['outcome']}: {row['reason']}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
