"""No wait without an end: whoever does not answer in time is left, also where he cannot be told to stop."""

import asyncio
import contextlib
import io
import wave
from collections.abc import Coroutine
from typing import Any, TypeVar

from mesh.clock import Clock

T = TypeVar("T")


async def within(clock: Clock, seconds: float, work: Coroutine[Any, Any, T]) -> T:
    """What it gives. Raises `TimeoutError` after so long: it is cancelled then, and not waited for."""
    doing, waiting = asyncio.ensure_future(work), asyncio.ensure_future(clock.sleep(seconds))
    try:
        await asyncio.wait({doing, waiting}, return_when=asyncio.FIRST_COMPLETED)
        if not doing.done():
            raise TimeoutError(f"not done within {seconds:.0f} s")
        return doing.result()
    finally:
        waiting.cancel()
        doing.cancel()
        doing.add_done_callback(_forgotten)


def length_s(wav: bytes) -> float:
    """0 for what is no WAV: the loudspeaker refuses it."""
    with contextlib.suppress(wave.Error, EOFError), wave.open(io.BytesIO(wav)) as file:
        return file.getnframes() / file.getframerate()
    return 0.0


def _forgotten(task: "asyncio.Future[Any]") -> None:
    """What it fails with after it was left is nobody's any more."""
    if not task.cancelled():
        task.exception()
