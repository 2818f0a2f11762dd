"""How soon a typed stop is obeyed while inference hangs and memory is away.

`PYTHONPATH=tests python -m support.stop_words`.

From the request's arrival at the coordinator (in-process, a mission under way) to the answer that the robot stands. The
time of a real bridge's `/halt` comes on top.
"""

import asyncio
import statistics
import sys
import time

import structlog

from contracts.vision import ParsedTask, ParseTaskRequest
from support.coordinator_mesh import opened_mesh
from support.coordinator_world import FakeInference, Thing

SAID = (
    "stop",
    "halt!",
    "wait, stop",
    "cancel that",
    "no, stop it",
    "that's enough",
    "hör auf",
    "arrête",
    "dừng lại",
    "dur",
)
ROUNDS = 20


async def hangs(self: FakeInference, request: ParseTaskRequest) -> ParsedTask:
    await asyncio.Event().wait()
    raise AssertionError(request)


async def took_ms() -> tuple[list[float], list[float]]:
    """On the wall, and of this process's own time, sorted."""
    found: list[float] = []
    own: list[float] = []
    real = FakeInference.parse_task
    for text in SAID * ROUNDS:
        async with opened_mesh(Thing("bottle", "red", 8.0, 6.5)) as mesh:
            await mesh.post_mission()
            FakeInference.parse_task, mesh.memory.away = hangs, True
            began_s, began_own_s = time.perf_counter(), time.process_time()
            answer = await mesh.client.post("/missions", json={"command": text})
            found.append((time.perf_counter() - began_s) * 1000.0)
            own.append((time.process_time() - began_own_s) * 1000.0)
            FakeInference.parse_task = real
            assert answer.json()["still"], answer.text
    return sorted(found), sorted(own)


if __name__ == "__main__":
    structlog.configure(wrapper_class=structlog.make_filtering_bound_logger(50))
    for name, times in zip(("on the wall", "of its own time"), asyncio.run(took_ms()), strict=True):
        p50, p99 = statistics.median(times), times[int(0.99 * (len(times) - 1))]
        sys.stdout.write(
            f"{len(times)} typed stops, {name}: p50 {p50:.1f} ms, p99 {p99:.1f} ms, worst {times[-1]:.1f} ms\n"
        )
