"""The shell round the core: sound goes in, what is decided is done, one thing of a conversation at a time."""

import asyncio
import contextlib
from collections import deque
from collections.abc import Callable, Coroutine, Sequence
from dataclasses import dataclass, field
from datetime import time
from typing import Any, Final, assert_never

import structlog

from contracts.mission import Mission
from contracts.robot import EmergencyStopRequest
from contracts.speech import Hearing, SpeakRequest
from ear import core, words
from ear.deadlines import within
from ear.following import Following
from ear.mouth import Mouth
from ear.ports import (
    CHUNK_BYTES,
    CHUNK_S,
    Coordinator,
    Ears,
    Loudspeaker,
    Memory,
    Robot,
    SoundError,
    Source,
    Speech,
    WakeWordDetector,
)
from ear.quiet_hours import QuietHours
from ear.sayings import Sayings
from ear.settings import Settings
from ear.standing import Standing
from mesh.clock import Clock
from mesh.errors import MeshError, UnavailableError, UpstreamError
from mesh.tasks import Tasks

log = structlog.get_logger()

LEAD_S: Final = 1.6
"""The wake word itself goes along, as people speak on without waiting: a recogniser that hears half of it makes other
words of that ("let us find", "and just find")."""
SILENCE_S: Final = 2.0
"""Behind the end of a recording, so that the end of what was said is found."""
INSIST_S: Final = 5.0
"""So long a stop that did not reach the robot is asked for,"""
AGAIN_S: Final = 0.3
"""each time so long after the last answer."""
NAMES_S: Final = 60.0
HEARD_S_MAX: Final = 60.0
"""Speech ends a saying long before."""
SHORT_SAYINGS_MAX: Final = 3
"""What waits to be read for a stop; the oldest is left out."""


@dataclass
class RobotEar:
    settings: Settings
    clock: Clock
    time_of_day: Callable[[], time]
    tasks: Tasks
    source: Source
    loudspeaker: Loudspeaker
    wake_word: WakeWordDetector
    speech: Speech
    coordinator: Coordinator
    robot: Robot
    memory: Memory | None
    ear: core.Ear = field(default_factory=core.Ear)
    _quiet_hours: QuietHours | None = None
    _recent: deque[bytes] = field(default_factory=lambda: deque[bytes](maxlen=round(LEAD_S / CHUNK_S)))
    _sayings: Sayings = field(default_factory=Sayings)
    _listening: "asyncio.Queue[bytes] | None" = None
    _short: "asyncio.Queue[bytes]" = field(default_factory=lambda: asyncio.Queue[bytes](SHORT_SAYINGS_MAX))
    _names: Sequence[str] = ()
    _doing: "asyncio.Task[Any] | None" = None
    _mouth: Mouth = field(init=False)
    _standing: Standing = field(init=False)
    _following: Following = field(init=False)

    def __post_init__(self) -> None:
        self._quiet_hours = QuietHours.read(self.settings.quiet_hours)
        self._mouth = Mouth(self.loudspeaker, self.clock)
        self._standing = Standing(self.coordinator, self.clock, self.settings.hold_s)
        self._following = Following(
            self.coordinator,
            self.clock,
            self.tasks,
            begun=self._standing.again,
            ended=lambda sentence: self.feed(core.News(sentence)),
        )

    async def run(self) -> None:
        """Until the sound ends, which a microphone's does not. Raises `SoundError`."""
        for name, forever in (
            ("hold", self._standing.hold_and_let_go()),
            ("hold again", self._standing.keep_renewing()),
            ("follow", self._following.follow()),
            ("may it move", self._following.keep_sure()),
            ("tones", self._mouth.play_tones()),
            ("short sayings", self._read_short_sayings()),
            ("names", self._keep_names()),
        ):
            self.tasks.start(name, forever)
        async for chunk in self.source.chunks():
            await self._hear(chunk)
        for _ in range(round(SILENCE_S / CHUNK_S)):
            await self.clock.sleep(CHUNK_S)
            await self._hear(bytes(CHUNK_BYTES))
        while self.ear.state is not core.State.ASLEEP:
            await self.clock.sleep(CHUNK_S)
        await self._standing.settled()

    def feed(self, event: core.Event) -> None:
        before = self.ear.state
        self.ear, actions = core.step(self.ear, event, self.clock.now_s(), quiet=self._is_quiet())
        if self.ear.state is not before:
            log.info("ear", state=self.ear.state.value, before=before.value)
        for action in actions:
            self._do(action)

    def _is_quiet(self) -> bool:
        return self._quiet_hours is not None and self._quiet_hours.covers(self.time_of_day())

    # sound in

    async def _hear(self, chunk: bytes) -> None:
        if not core.hears(self.ear, self.clock.now_s()):
            self._forget()
            return
        self._recent.append(chunk)
        if self._listening is not None:
            await self._listening.put(chunk)
            return
        self._look_for_a_stop(chunk)
        if self.ear.state is core.State.ASLEEP and await asyncio.to_thread(self.wake_word.heard, chunk):
            self.wake_word.forget()
            self.feed(core.Woken())

    def _look_for_a_stop(self, chunk: bytes) -> None:
        """Without the wake word: while the robot moves, or may be about to. Nothing is kept at any other time."""
        about_to = self._following.may_move or self.ear.state is core.State.UNDERSTANDING
        if not (self.settings.stop_without_wake_word and about_to):
            self._sayings.forget()
            return
        saying = self._sayings.take(chunk)
        if saying is not None:
            if self._short.full():
                self._short.get_nowait()
            self._short.put_nowait(saying)

    def _forget(self) -> None:
        """What it says itself is followed by nothing."""
        if self._recent:
            self._recent.clear()
            self._sayings.forget()
            self.wake_word.forget()

    async def _read_short_sayings(self) -> None:
        while True:
            saying = await self._short.get()
            with contextlib.suppress(MeshError):  # away or busy: the next one is asked again
                transcript = await self.speech.transcribe(saying)
                if transcript.stop:
                    self.feed(core.StopHeard(transcript.text))

    # what was decided

    def _do(self, action: core.Action) -> None:
        match action:
            case core.StopRobot():
                self._leave()
                self.tasks.start("stop", self._stop_robot(action), forever=False)
            case core.Listen():
                self._converse(self._listen(action))
            case core.Understand():
                self._converse(self._understand(action))
            case core.Send():
                self._converse(self._send(action))
            case core.Say():
                self._converse(self._say(action))
            case core.Sound(tone):
                self._mouth.sound(tone)
            case core.Hold() | core.LetGo():
                self._standing.take(action)
            case _:
                assert_never(action)

    def _converse(self, coroutine: Coroutine[Any, Any, None]) -> None:
        self._leave()
        self._doing = self.tasks.start("conversation", coroutine, forever=False)

    def _leave(self) -> None:
        """What was under way is given up, unless it is what decides this."""
        if self._doing is not None and self._doing is not asyncio.current_task():
            self._doing.cancel()
        self._doing = None

    async def _stop_robot(self, action: core.StopRobot) -> None:
        request = EmergencyStopRequest(reason=f"said: {action.words[:100]}", by="ear")
        until_s = self.clock.now_s() + INSIST_S
        while True:
            try:
                await self.robot.emergency_stop(request)
            except MeshError as error:
                log.warning("a spoken stop did not reach the robot", why=error.detail)
                if self.clock.now_s() >= until_s:
                    self.feed(core.Stopped(action.turn, reached=False))
                    return
                await self.clock.sleep(AGAIN_S)
            else:
                self.feed(core.Stopped(action.turn, reached=True))
                return

    async def _listen(self, action: core.Listen) -> None:
        samples: asyncio.Queue[bytes] = asyncio.Queue()
        for chunk in () if action.again else self._recent:
            samples.put_nowait(chunk)
        self._recent.clear()
        self._listening = samples
        try:
            async with self.speech.listen(self._names) as ears:
                event = await self._heard_by(ears, samples, action.turn)
                self._end_of(samples)
                self.feed(event)  # before the line is closed, which takes a second where the other side is slow
        except MeshError as error:
            self._end_of(samples)
            self.feed(core.Away(action.turn, "speech", error.detail))
        finally:
            self._end_of(samples)

    def _end_of(self, samples: "asyncio.Queue[bytes]") -> None:
        if self._listening is samples:
            self._listening = None
            self.wake_word.forget()
            self._sayings.forget()

    async def _heard_by(self, ears: Ears, samples: "asyncio.Queue[bytes]", turn: int) -> core.Event:
        """The first stop, or the final reading. Raises `MeshError`, also where neither comes."""
        sending = asyncio.create_task(_send_on(samples, ears))
        try:
            hearing = await within(self.clock, HEARD_S_MAX, _told(ears))
        except TimeoutError:
            raise UnavailableError("speech", f"no last reading within {HEARD_S_MAX:.0f} s") from None
        finally:
            sending.cancel()
            await asyncio.gather(sending, return_exceptions=True)
        if hearing.stop:
            return core.StopHeard(hearing.transcript.text)
        return _heard_out(hearing, turn, woken=self.ear.state is core.State.LISTENING)

    async def _understand(self, action: core.Understand) -> None:
        event: core.Event
        try:
            event = core.Meant(action.turn, await self.coordinator.understand(action.readings))
        except MeshError as error:
            event = _failed(action.turn, error)
        self.feed(event)

    async def _send(self, action: core.Send) -> None:
        event: core.Event
        command = action.intent.command
        try:
            if action.intent.action.is_question:
                event = core.Replied(action.turn, words.short((await self.coordinator.ask(command)).answer))
            else:
                begun = await self.coordinator.start(command)
                mission = isinstance(begun, Mission)
                self._following.expect()
                event = core.Begun(action.turn, words.short(action.intent.able)) if mission else core.Replied(
                    action.turn, words.short(begun.text)
                )  # fmt: skip
        except MeshError as error:
            event = _failed(action.turn, error)
        self.feed(event)

    async def _say(self, action: core.Say) -> None:
        event: core.Event = core.Spoken(action.turn)
        try:
            wav = await self.speech.speak(SpeakRequest(text=action.sentence, voice=self.settings.voice or None))
            await self._standing.before_a_sentence()
            self.feed(core.Sounding(action.turn))
            await self._mouth.play(wav)
        except MeshError as error:
            event = core.Away(action.turn, "speech", error.detail)
        except SoundError as error:
            log.warning("it cannot be said", why=str(error))
        self.feed(event)

    # beside the conversation

    async def _keep_names(self) -> None:
        while True:
            if self.memory is not None:
                with contextlib.suppress(MeshError):
                    self._names = await self.memory.names()
            await self.clock.sleep(NAMES_S)


async def _send_on(samples: "asyncio.Queue[bytes]", ears: Ears) -> None:
    while True:
        await ears.send(await samples.get())


async def _told(ears: Ears) -> Hearing:
    """The first with a stop, or the last one. Raises `MeshError`."""
    async for hearing in ears.hearings():
        if hearing.stop or hearing.final:
            return hearing
    raise UnavailableError("speech", "it ended without a last reading")


def _heard_out(hearing: Hearing, turn: int, *, woken: bool) -> core.HeardOut:
    transcript = hearing.transcript
    readings = words.readings_of(transcript.hot_text, transcript.text, woken=woken)
    return core.HeardOut(turn, readings, not transcript.no_speech)


def _failed(turn: int, error: MeshError) -> core.Event:
    match error:
        case UpstreamError():
            return core.Replied(turn, words.short(error.said))
        case UnavailableError():
            return core.Away(turn, error.service, error.said)
        case _:
            return core.Away(turn, "coordinator", error.detail)
