"""Stops spoken in real time into the running speech service; whoever hears one stops a robot_bridge that drives."""

import asyncio
import contextlib
import time
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import httpx
import numpy as np
from websockets.asyncio.client import connect

from bench.processes import Processes, until
from bench.speech.voices import RATE, Sound, spoiled, spoken, voices
from bench.stopping.rig import HEAR_S_MAX, Rig
from contracts.speech import Hearing

SAYINGS = ("stop", "stop the robot", "halt", "please stop", "stop it now")
NOISES_DB = (None, 10.0)
CHUNK_S = 0.04
BEFORE_S, BEHIND_S = 0.6, 2.5
QUIET = 0.02
"""Of the loudest: what is quieter is no part of the word."""
LEASE_S = 1.0


@dataclass(frozen=True, slots=True)
class Spoken:
    """ms from the end of what was said; None = missed. `read`: what the final reading was."""

    voice: str
    said: str
    noise_db: float | None
    hearing_ms: float | None
    zero_ms: float | None
    read: str


@contextlib.contextmanager
def speech_service(port: int) -> Iterator[None]:
    """`python -m speech`, ready."""
    with Processes({"SPEECH_PORT": str(port)}) as processes:
        processes.python("-m", "speech")
        with httpx.Client(base_url=f"http://127.0.0.1:{port}", trust_env=False) as http:
            until(lambda: _ready(http), "a speech service", timeout_s=60.0)
            yield


def _ready(http: httpx.Client) -> bool:
    with contextlib.suppress(httpx.TransportError):
        return http.get("/ready").status_code == 200
    return False


async def measure(rig: Rig, port: int, sounds: Path, rounds: int) -> list[Spoken]:
    told: list[Spoken] = []
    for number in range(rounds):
        for noise_db in NOISES_DB:
            for said in SAYINGS:
                for voice, speak in voices().items():
                    kept = sounds / voice / f"{zlib.crc32(said.encode()):08x}.wav"
                    clean = _between(spoken(said, speak, kept))
                    loud = np.nonzero(np.abs(clean) > QUIET * np.abs(clean).max())[0]
                    sound = spoiled(clean, noise_db, zlib.crc32(f"{said} {number}".encode()))
                    hearing_ms, zero_ms, read = await _one(rig, port, sound, end_s=float(loud[-1] + 1) / RATE)
                    told.append(Spoken(voice, said, noise_db, hearing_ms, zero_ms, read))
    return told


def _between(sound: Sound) -> Sound:
    return np.pad(sound, (round(BEFORE_S * RATE), round(BEHIND_S * RATE)))


async def _one(rig: Rig, port: int, sound: Sound, *, end_s: float) -> tuple[float | None, float | None, str]:
    """(ms to the hearing that says stop, ms to the first zero velocity, the final reading)."""
    rig.drive()
    rig.listener.forget()
    raw = (np.clip(sound, -1.0, 1.0) * 32767).astype("<i2").tobytes()
    size = 2 * round(CHUNK_S * RATE)
    async with (
        connect(f"ws://127.0.0.1:{port}/listen") as socket,
        httpx.AsyncClient(base_url=str(rig.http.base_url), trust_env=False) as http,
    ):
        await http.get("/health")  # the page's relay keeps its connection
        driving = asyncio.create_task(_drive(http))
        began_s = time.monotonic()

        async def speak() -> None:
            for number, at in enumerate(range(0, len(raw), size)):
                await asyncio.sleep(began_s + (number + 1) * CHUNK_S - time.monotonic())
                await socket.send(raw[at : at + size])

        speaking = asyncio.create_task(speak())
        hearing_ms = zero_ms = None
        read = ""
        try:
            async for message in socket:
                hearing = Hearing.model_validate_json(message)
                read = f"{hearing.transcript.text} / {hearing.transcript.hot_text}"
                if hearing.stop and hearing_ms is None:
                    heard_s = time.monotonic()
                    driving.cancel()
                    hearing_ms = (heard_s - began_s - end_s) * 1000
                    await http.post("/emergency-stop", json={"reason": "spoken", "by": "bench"})
                    zero = await asyncio.to_thread(
                        rig.listener.first, lambda one: one.zero, since_ns=int(heard_s * 1e9), timeout_s=HEAR_S_MAX
                    )
                    zero_ms = (zero.at_ns / 1e9 - began_s - end_s) * 1000
        finally:
            for task in (driving, speaking):
                task.cancel()
            await asyncio.gather(driving, speaking, return_exceptions=True)
    return hearing_ms, zero_ms, read


async def _drive(http: httpx.AsyncClient) -> None:
    """So that a zero comes from the stop and not from the end of a lease."""
    epoch = (await http.get("/emergency-stop")).json()["epoch"]
    while True:
        lease = {"twist": {"linear_x": 0.2}, "source": "bench", "epoch": epoch, "duration_s": LEASE_S, "priority": 3}
        await http.post("/velocity", json=lease)
        await asyncio.sleep(LEASE_S / 3)


def table(told: list[Spoken]) -> str:
    lines = [
        "| sound | voice | said | not heard | hearing p50 | p99 | zero velocity p50 | p99 | most |",
        "|---|---|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for noise_db in NOISES_DB:
        for voice in ("all", *dict.fromkeys(one.voice for one in told)):
            some = [one for one in told if one.noise_db == noise_db and voice in {"all", one.voice}]
            sound = "clean" if noise_db is None else f"{noise_db:.0f} dB"
            lines.append(f"| {sound} | {voice} | {_figures(some)} |")
    lines += ["", "| said | times | not heard | hearing p50 | p99 | zero velocity p50 | p99 | most |"]
    lines.append("|---|---:|---:|---:|---:|---:|---:|---:|")
    lines += [f"| {said} | {_figures([one for one in told if one.said == said])} |" for said in SAYINGS]
    missed = [f"- {one.voice}, {one.said}, {one.noise_db}: {one.read}" for one in told if one.hearing_ms is None]
    return "\n".join([*lines, "", *missed]) + "\n"


def _figures(some: list[Spoken]) -> str:
    hearing = [one.hearing_ms for one in some if one.hearing_ms is not None]
    zero = [one.zero_ms for one in some if one.zero_ms is not None]
    if not zero:
        return f"{len(some)} | {len(some)} | | | | |"
    quantiles = (*np.percentile(hearing, [50, 99]), *np.percentile(zero, [50, 99, 100]))
    return " | ".join([str(len(some)), str(len(some) - len(hearing)), *(f"{one:.0f} ms" for one in quantiles)])
