"""Hours of other speech and noise through speech's own listening, faster than they last: stops that nobody said.

The sound waits for each reading, as if the recogniser took no time: more is read than in a home, never less.
"""

import asyncio
import json
import random
import time
import zlib
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np

from bench.results import quiet
from bench.speech.voices import RATE, Sound, spoiled, spoken, voices
from bench.voice_stop.other_speech import KINDS, SEED, Kind, babble, noises
from contracts.speech import Hearing
from mesh.clock import SystemClock
from speech.adapters.silero import SileroActivity
from speech.adapters.whisper import WhisperRecognizer
from speech.listening import listen
from speech.settings import Settings
from speech.speech_service import SpeechService

PIECE_S = 60.0
NOISE_MINUTES = 3.0
CHUNK = 2 * int(0.064 * RATE)
NOISES_DB = (None, 10.0)
"""Every second piece is spoiled."""


@dataclass(frozen=True, slots=True)
class Piece:
    """`turns`: how often somebody was taken to speak; `false`: what was read where a stop was told."""

    kind: str
    voice: str
    number: int
    seconds: float
    turns: int
    false: list[str]


class FileSocket:
    """What `listen` needs of a socket: it gives sound when nothing is being read, and keeps what is told."""

    def __init__(self, sound: bytes, at: int, speech: SpeechService) -> None:
        self._sound, self.at, self._speech = sound, at, speech
        self.told: list[Hearing] = []

    async def accept(self) -> None: ...

    async def close(self, code: int = 1000, reason: str = "") -> None: ...

    async def receive(self) -> dict[str, Any]:
        await asyncio.sleep(0)
        while not self._speech.idle:  # noqa: ASYNC110 - it has no event, and needs none
            await asyncio.sleep(0.002)
        chunk = self._sound[self.at : self.at + CHUNK]
        self.at += len(chunk)
        return {"type": "websocket.receive", "bytes": chunk}

    async def send_text(self, text: str) -> None:
        self.told.append(Hearing.model_validate_json(text))


async def listened(speech: SpeechService, sound: Sound) -> tuple[int, list[str]]:
    """How many turns, and of each that told a stop what was read first where it did."""
    raw = (np.clip(sound, -1.0, 1.0) * 32767).astype("<i2").tobytes()
    at, turns, false = 0, 0, list[str]()
    while at < len(raw):
        socket = FileSocket(raw, at, speech)
        await listen(cast(Any, socket), speech, (), held=False)
        turns += bool(socket.told) and not socket.told[-1].transcript.no_speech
        stops = [one for one in socket.told if one.stop]
        if stops:
            first = stops[0].transcript
            false.append(f"{'final' if stops[0].final else 'partial'}: {first.text} / {first.hot_text}"[:200])
        at = max(socket.at, at + CHUNK)
    return turns, false


def pieces(sounds: Path) -> Iterator[tuple[str, str, int, Sound]]:
    """(kind, voice, number, sound): noise, then people one at a time, then several at once."""
    draw = np.random.default_rng(SEED)
    for name, made in noises().items():
        for number in range(round(NOISE_MINUTES)):
            yield name, "noise", number, made(draw, int(PIECE_S * RATE))
    for number in range(max(round(kind.minutes) for kind in KINDS)):
        for kind in KINDS:
            for voice in voices():
                if number < kind.minutes:
                    sound = _joined(kind, voice, number, sounds)
                    yield kind.name, voice, number, spoiled(sound, NOISES_DB[number % 2], number)
    speakers = [_joined(KINDS[1], voice, 0, sounds) for voice in voices()]
    for number in range(round(NOISE_MINUTES)):
        yield "babble", "noise", number, babble(speakers, int(PIECE_S * RATE), draw)


def _joined(kind: Kind, voice: str, number: int, sounds: Path) -> Sound:
    """Sayings with pauses between, a minute; each voice and minute has its own."""
    draw = random.Random(f"{SEED} {kind.name} {voice} {number}")
    told, length_s = list[Sound](), 0.0
    for said in kind.sayings(draw):
        one = spoken(said, voices()[voice], sounds / voice / f"{zlib.crc32(said.encode()):08x}.wav")
        told += [one, np.zeros(int(draw.uniform(0.0, 1.2) * RATE), np.float32)]
        length_s += (len(told[-1]) + len(one)) / RATE
        if length_s >= PIECE_S:
            break
    return np.concatenate(told)


def kept(path: Path) -> list[Piece]:
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    return [Piece(**json.loads(line)) for line in lines]


async def play(path: Path, sounds: Path, seconds: float) -> None:
    """Listens to what was not yet, for so long."""
    quiet()
    ends_s = time.monotonic() + seconds
    settings = Settings()
    recognizer = WhisperRecognizer("", language="en", threads=settings.threads, download=False)
    speech = SpeechService(
        settings=settings, clock=SystemClock(), recognizer=recognizer, activity=SileroActivity(), synthesizers=[]
    )
    await speech.load()
    done = {(one.kind, one.voice, one.number) for one in kept(path)}
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a", encoding="utf-8") as file:
        for kind, voice, number, sound in pieces(sounds):
            if (kind, voice, number) in done:
                continue
            if time.monotonic() > ends_s:
                break
            turns, false = await listened(speech, sound)
            piece = Piece(kind, voice, number, round(len(sound) / RATE, 1), turns, false)
            file.write(json.dumps(asdict(piece)) + "\n")
            file.flush()
    speech.close()


def table(told: list[Piece]) -> str:
    lines = ["| sound | minutes | turns heard | false stops |", "|---|---:|---:|---:|"]
    for kind in dict.fromkeys(one.kind for one in told):
        some = [one for one in told if one.kind == kind]
        minutes = sum(one.seconds for one in some) / 60
        lines.append(
            f"| {kind} | {minutes:.1f} | {sum(one.turns for one in some)} | {sum(len(one.false) for one in some)} |"
        )
    wrong = [f"- {one.kind}, {one.voice}, minute {one.number}: {said}" for one in told for said in one.false]
    return "\n".join([*lines, "", *wrong]) + "\n"
