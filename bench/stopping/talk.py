"""Somebody who talks to a speech service without end: the load of `bench.stop --speech`.

Commands in a synthetic voice, one after another in real time, into `WS /listen`. None of them says stop.
"""

import argparse
import asyncio
import contextlib
import itertools
import time
from pathlib import Path

import numpy as np
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed

from bench.speech.voices import RATE, hibari, spoken

SAYINGS = ("find the red bottle", "where is my blue cup", "go to the kitchen", "what do you see")
SOUNDS = Path("out/bench/talk")
CHUNK_S = 0.04
PAUSE_S = 1.0


async def talk(port: int) -> None:
    sounds = [spoken(said, hibari, SOUNDS / f"{number}.wav") for number, said in enumerate(SAYINGS)]
    for sound in itertools.cycle(sounds):
        padded = np.pad(sound, (0, round(PAUSE_S * RATE)))
        await _say(port, (np.clip(padded, -1.0, 1.0) * 32767).astype("<i2").tobytes())


async def _say(port: int, raw: bytes) -> None:
    """The service reads it and closes the socket, which it may do before its last silence is sent."""
    async with connect(f"ws://127.0.0.1:{port}/listen") as socket:
        began_s, size = time.monotonic(), 2 * round(CHUNK_S * RATE)
        with contextlib.suppress(ConnectionClosed):
            for number, at in enumerate(range(0, len(raw), size)):
                await asyncio.sleep(began_s + (number + 1) * CHUNK_S - time.monotonic())
                await socket.send(raw[at : at + size])
        async for _ in socket:
            pass


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--port", type=int, required=True, help="of the speech service")
    asyncio.run(talk(parser.parse_args().port))
