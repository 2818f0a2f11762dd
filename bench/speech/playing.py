"""Has every command spoken, spoiled and read; each reading is kept, so that a run goes on where it was ended."""

import json
import time
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from bench.speech.grammar import commands, held_out
from bench.speech.voices import NOISES, spoiled, spoken, voices

BLOCK = 10
"""Commands that are read together."""
TUNING_FIRST = 5
"""Blocks of the tuning half that come before everything else."""


@dataclass(frozen=True, slots=True)
class Clip:
    command: str
    voice: str
    noise: str
    plain: str
    hot: str


def clips(path: Path) -> list[Clip]:
    """What was read so far; of each the last."""
    if not path.exists():
        return []
    found = [Clip(**json.loads(line)) for line in path.read_text(encoding="utf-8").splitlines()]
    return list({(one.command, one.voice, one.noise): one for one in found}.values())


def play(readings: Path, sounds: Path, seconds: float) -> bool:
    """Reads what is missing, for so long; True when nothing is."""
    from bench.speech.ear import Ear

    ends_s, ear = time.monotonic() + seconds, Ear()
    told = {(one.command, one.voice, one.noise) for one in clips(readings)}
    readings.parent.mkdir(parents=True, exist_ok=True)
    with readings.open("a", encoding="utf-8") as file:
        for block in _blocks():
            for voice, speak in voices().items():
                for noise, noise_db in NOISES.items():
                    some = [one for one in block if (one, voice, noise) not in told]
                    if not some:
                        continue
                    if time.monotonic() > ends_s:
                        return False
                    digests = [zlib.crc32(one.encode()) for one in some]
                    heard = [
                        spoiled(spoken(one, speak, sounds / voice / f"{digest:08x}.wav"), noise_db, digest)
                        for one, digest in zip(some, digests, strict=True)
                    ]
                    for one, (plain, hot) in zip(some, ear.readings(heard), strict=True):
                        file.write(json.dumps(asdict(Clip(one, voice, noise, plain, hot))) + "\n")
                    file.flush()
    return True


def _blocks() -> Iterator[Sequence[str]]:
    """Some of the tuning half, so that it can be worked on; then the other half; then the rest."""
    tuning, held = ([one for one in commands() if held_out(one) is half] for half in (False, True))
    halves = [[half[at : at + BLOCK] for at in range(0, len(half), BLOCK)] for half in (tuning, held)]
    yield from (*halves[0][:TUNING_FIRST], *halves[1], *halves[0][TUNING_FIRST:])
