"""Time that jumps: waiting takes none of the wall clock's, and work for a thread is done in place."""

import asyncio
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from bench.world.clock import NothingLeftError, run_simulated
from bench.world.drawn import drawn_from


def test_an_hour_passes_in_no_time_and_to_the_very_moment() -> None:
    async def main() -> float:
        await asyncio.sleep(3600.0)
        return asyncio.get_running_loop().time()

    began_s = time.monotonic()
    assert run_simulated(main, start_s=1000.0) == 4600.0
    assert time.monotonic() - began_s < 10.0


def test_a_thread_of_a_named_pool_takes_its_fixed_time() -> None:
    async def main() -> tuple[str, float, float]:
        loop = asyncio.get_running_loop()
        models = ThreadPoolExecutor(1, "models")
        answer = await loop.run_in_executor(models, lambda: "a box")
        seen_s = loop.time()
        await asyncio.to_thread(lambda: None)
        return answer, seen_s, loop.time()

    assert run_simulated(main, start_s=0.0, took_s={"models": 0.05}) == ("a box", 0.05, 0.05)


def test_what_fails_in_a_thread_fails_who_asked() -> None:
    async def main() -> None:
        await asyncio.to_thread(int, "no number")

    with pytest.raises(ValueError, match="no number"):
        run_simulated(main)


def test_everybody_waiting_for_nothing_is_a_hang() -> None:
    async def main() -> None:
        await asyncio.Event().wait()

    with pytest.raises(NothingLeftError):
        run_simulated(main)


def test_names_drawn_from_a_seed_are_the_same_again() -> None:
    import uuid

    with drawn_from(3):
        first = [uuid.uuid4(), uuid.uuid4()]
    with drawn_from(3):
        assert [uuid.uuid4(), uuid.uuid4()] == first
    assert uuid.uuid4() not in first
