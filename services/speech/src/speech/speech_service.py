"""Listens, one call at a time, and speaks, one call at a time beside it; keeps neither sound nor words."""

import asyncio
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Final, ParamSpec, TypeVar

import structlog

from contracts.problem import Dependency
from contracts.speech import HEARD_CHARACTERS_MAX, SpeakRequest, SpeechRefusal, Transcript, Voice
from mesh.clock import Clock
from mesh.errors import NotFoundError, TooManyError, UnavailableError
from speech.end_of_speech import PROBABILITY_MIN, WINDOW_S, Listening, step
from speech.metrics import HEARD, READ, REFUSED, SPOKEN, WAITING
from speech.ports import Reading, Recognizer, Synthesizer, VoiceActivity
from speech.readings import agree, fitting
from speech.settings import Settings
from speech.sound import Samples, duration_s, to_wav
from vocabulary.folding import words_of
from vocabulary.hot_words import expected
from vocabulary.orders import stop_in, stop_words

P = ParamSpec("P")
T = TypeVar("T")

SPEECH_WINDOWS_MIN: Final = 4
"""A word of an eighth of a second; less is a click."""
EARS: Final = ("recognizer", "voice_activity")
"""The parts without which nobody is heard; the others are voices."""
RETRY_S: Final = 20.0
"""A server that was away may be back."""
STOP_S_MAX, STOP_WORDS_MAX = 3.5, 4
"""An order to stop is short, also in words, as it is read plainly. In more than that, a reading that leans towards one
finds it sooner or later: in "can you find my rucksack?"."""

log = structlog.get_logger()


class BusyError(TooManyError):
    """All turns are taken: 503 with Retry-After, because the request itself is well."""

    status = 503
    title = "Busy"


@dataclass
class _Turns:
    """One call at a time on a thread of its own; how many wait or run."""

    name: str
    waiting: int = 0
    _pool: ThreadPoolExecutor = field(init=False)

    def __post_init__(self) -> None:
        self._pool = ThreadPoolExecutor(1, self.name)

    @contextmanager
    def turn(self, waiting_max: int) -> Generator[None]:
        """Raises `BusyError` where as many wait already."""
        if self.waiting >= waiting_max:
            REFUSED.labels(SpeechRefusal.BUSY).inc()
            raise BusyError(f"{self.waiting} calls wait already", code=SpeechRefusal.BUSY)
        self.waiting += 1
        try:
            yield
        finally:
            self.waiting -= 1

    async def run(self, function: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T:
        return await asyncio.get_running_loop().run_in_executor(self._pool, lambda: function(*args, **kwargs))

    def close(self) -> None:
        self._pool.shutdown(wait=False, cancel_futures=True)


@dataclass
class SpeechService:
    settings: Settings
    clock: Clock
    recognizer: Recognizer
    activity: VoiceActivity
    synthesizers: Sequence[Synthesizer]
    _hearing: _Turns = field(default_factory=lambda: _Turns("hearing"))
    _speaking: _Turns = field(default_factory=lambda: _Turns("speaking"))
    """Apart: no stop waits until a sentence has been spoken, or a voice loaded."""
    _listeners: int = 0
    _away: dict[str, str] = field(init=False)
    """By part: why it does not work now."""
    _stop_hint: str = field(init=False)

    def __post_init__(self) -> None:
        self._stop_hint = ", ".join(stop_words(self.settings.language))
        self._away = dict.fromkeys(self._parts(), "is being loaded")

    async def load(self) -> None:
        """Until all are there: whoever cannot be loaded is named in `/ready` and tried again; the rest works."""
        while True:
            ears = [name for name in self._away if name in EARS]
            voices = [name for name in self._away if name not in EARS]
            await asyncio.gather(self._load_all(self._hearing, ears), self._load_all(self._speaking, voices))
            if not self._away:
                return
            await self.clock.sleep(RETRY_S)

    async def _load_all(self, turns: _Turns, names: Sequence[str]) -> None:
        for name in names:
            await self._load(turns, name)

    async def _load(self, turns: _Turns, name: str) -> None:
        try:
            await turns.run(self._parts()[name].load)
        except UnavailableError as error:
            if error.said != self._away[name]:
                log.warning("cannot be loaded", part=name, why=error.said)
            self._away[name] = error.said
        else:
            del self._away[name]

    def _parts(self) -> dict[str, Recognizer | VoiceActivity | Synthesizer]:
        voices = {f"voice_{number}": one for number, one in enumerate(self.synthesizers)}
        return {"recognizer": self.recognizer, "voice_activity": self.activity, **voices}

    async def transcribe(self, samples: Samples, hot_words: Sequence[str] = ()) -> Transcript:
        """Both readings, the second leaning towards how commands begin, `hot_words`, and the common names, as many as
        the engine takes. Raises `BusyError`, and `UnavailableError` where the recogniser is away."""
        self._require("recognizer")
        self._require("voice_activity")
        began_s = self.clock.now_s()
        with self._hearing.turn(self.settings.waiting_max), READ.time():
            plain, hot, stop = await self._hearing.run(self._read_both, samples, expected(hot_words))
        told = self._transcript(samples, began_s, plain, hot, stop=stop)
        HEARD.labels("no_speech" if told.no_speech else "agree" if told.agree else "differ").inc()
        if self.settings.log_text:
            log.info("heard", text=plain.text, hot_text=hot.text)
        return told

    async def read_partially(self, samples: Samples, *, look_for_stop: bool) -> Transcript:
        """The plain reading alone, told as both: for what is still being said. Its `stop` is one whatever follows;
        with `look_for_stop` a second reading that leans towards it is made, which hears it in noise too. Raises as
        `transcribe`."""
        self._require("recognizer")
        began_s = self.clock.now_s()
        with self._hearing.turn(self.settings.waiting_max):
            plain, stop = await self._hearing.run(self._read_plain, samples, look_for_stop)
        return self._transcript(samples, began_s, plain, plain, stop=stop)

    async def turn_of(self, was: Listening, samples: Samples, fresh: int, *, held: bool = False) -> Listening:
        """How far the speaker is after the last `fresh` windows of 32 ms of these samples; those before help to judge
        them. `held`: a button is, and silence is no end. Costs 0.4 ms a window, and waits for no turn."""
        self._require("voice_activity")
        likely = await asyncio.to_thread(self.activity.probabilities, samples)
        for probability in likely[-fresh:]:
            was = step(was, probability, WINDOW_S, held=held)
        return was

    async def speak(self, request: SpeakRequest) -> bytes:
        """A WAV. Raises `NotFoundError` where no voice has that name, and `BusyError`."""
        for number, one in enumerate(self.synthesizers):
            names = [] if f"voice_{number}" in self._away else [voice.name for voice in one.voices]
            if names and request.voice in {None, *names}:
                if self.settings.log_text:
                    log.info("speaks", text=request.text)
                with self._speaking.turn(self.settings.waiting_max), SPOKEN.time():
                    said = await self._speaking.run(one.speak, request.text, request.voice or names[0], request.speed)
                return to_wav(said.samples, said.rate_hz)
        if request.voice is None:
            raise UnavailableError("voice", "no voice is installed here")
        raise NotFoundError(f"no voice {request.voice}")

    def voices(self) -> list[Voice]:
        there = (one for number, one in enumerate(self.synthesizers) if f"voice_{number}" not in self._away)
        return [voice for one in there for voice in one.voices]

    def dependencies(self) -> list[Dependency]:
        return [Dependency.of(name, ok=name not in self._away, detail=self._away.get(name, "")) for name in EARS] + [
            Dependency.of("voice", ok=bool(self.voices()), detail="" if self.voices() else "none is installed")
        ]

    @contextmanager
    def listener(self) -> Generator[None]:
        """Raises `BusyError` where too many listen already."""
        if self._listeners >= self.settings.listeners_max:
            REFUSED.labels(SpeechRefusal.BUSY).inc()
            raise BusyError(f"{self._listeners} are being listened to", code=SpeechRefusal.BUSY)
        self._listeners += 1
        try:
            yield
        finally:
            self._listeners -= 1

    @property
    def idle(self) -> bool:
        """Nobody waits to be read."""
        return self._hearing.waiting == 0

    def measure(self) -> None:
        WAITING.set(self._hearing.waiting + self._speaking.waiting)

    def close(self) -> None:
        self._hearing.close()
        self._speaking.close()

    def _read_both(self, samples: Samples, names: Sequence[str]) -> tuple[Reading, Reading, bool]:
        """Blocks: plain, with hot words, and whether to stop. Nobody speaks: Whisper is known to make up words there,
        and is not asked."""
        likely = [one >= PROBABILITY_MIN for one in self.activity.probabilities(samples)]
        if sum(likely) < SPEECH_WINDOWS_MIN:
            nothing = Reading("", self.settings.language)
            return nothing, nothing, False
        hints = ("", fitting(names, self.recognizer.tokens_of), self._stop_hint)
        readings = self.recognizer.readings(samples, hints)
        plain, hot = next(readings), next(readings)
        leaning = _is_short(samples, plain) and (stop_in(hot.text) or stop_in(next(readings).text, whole=False))
        return plain, hot, stop_in(plain.text) or leaning

    def _read_plain(self, samples: Samples, look_for_stop: bool) -> tuple[Reading, bool]:
        readings = self.recognizer.readings(samples, ("", self._stop_hint))
        plain = next(readings)
        stop = stop_in(plain.text, whole=False)
        leaning = look_for_stop and _is_short(samples, plain)
        return plain, stop or (leaning and stop_in(next(readings).text, whole=False))

    def _require(self, part: str) -> None:
        if part in self._away:
            raise UnavailableError(part, self._away[part])

    def _transcript(self, samples: Samples, began_s: float, plain: Reading, hot: Reading, *, stop: bool) -> Transcript:
        return Transcript(
            text=plain.text[:HEARD_CHARACTERS_MAX],
            hot_text=hot.text[:HEARD_CHARACTERS_MAX],
            agree=agree(plain.text, hot.text),
            stop=stop,
            no_speech=not (plain.text or hot.text),
            language=plain.language,
            duration_s=duration_s(samples),
            took_ms=max(0.0, (self.clock.now_s() - began_s) * 1000),
            engine=self.recognizer.name,
        )


def _is_short(samples: Samples, plain: Reading) -> bool:
    return duration_s(samples) <= STOP_S_MAX and len(words_of(plain.text)) <= STOP_WORDS_MAX
