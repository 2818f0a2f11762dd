"""The shell round the core: half duplex, a stop that is insisted on, a mission held and let go, quiet hours."""

import contextlib
from collections.abc import AsyncGenerator
from dataclasses import dataclass, field
from datetime import time
from typing import Any

import pytest
from pydantic import ValidationError

from contracts.intent import Choice, Intent, Understood, WantedAction
from contracts.mission import EventKind
from contracts.reading import Mood
from ear import words
from ear.core import ECHO_S, State, Tone
from ear.mouth import LATE_S
from ear.ports import CHUNK_BYTES
from ear.robot_ear import HEARD_S_MAX, INSIST_S, LEAD_S, SHORT_SAYINGS_MAX, RobotEar
from ear.settings import Settings
from ear.tones import wav_of
from mesh.tasks import Tasks
from support.ear_fakes import (
    RUNNING,
    FakeCoordinator,
    FakeEars,
    FakeLoudspeaker,
    FakeRobot,
    FakeSource,
    FakeSpeech,
    FakeWakeWord,
    transcript,
    understood,
)
from support.fake_clock import FakeClock
from support.waiting import until

SILENCE = bytes(CHUNK_BYTES)
WAKING = FakeWakeWord.WORD.ljust(CHUNK_BYTES, b"\0")
LOUD = b"\x00\x20" * (CHUNK_BYTES // 2)
LOUDER = b"\x00\x30" * (CHUNK_BYTES // 2)
SAYING = [*[LOUD] * 5, *[SILENCE] * 4]
SAYING_OF_ANOTHER = [*[LOUDER] * 5, *[SILENCE] * 4]


@dataclass
class Heard:
    """An ear with everything round it in memory."""

    clock: FakeClock = field(default_factory=FakeClock)
    source: FakeSource = field(default_factory=FakeSource)
    loudspeaker: FakeLoudspeaker = field(default_factory=FakeLoudspeaker)
    wake_word: FakeWakeWord = field(default_factory=FakeWakeWord)
    speech: FakeSpeech = field(default_factory=FakeSpeech)
    coordinator: FakeCoordinator = field(default_factory=FakeCoordinator)
    robot: FakeRobot = field(default_factory=FakeRobot)
    ear: RobotEar = field(init=False)

    @contextlib.asynccontextmanager
    async def running(self, **settings: Any) -> AsyncGenerator["Heard"]:
        died: list[str] = []
        async with Tasks(on_death=lambda: died.append("a task died")) as tasks:
            self.ear = RobotEar(
                settings=Settings(**settings),
                clock=self.clock,
                time_of_day=lambda: time(23, 0),
                tasks=tasks,
                source=self.source,
                loudspeaker=self.loudspeaker,
                wake_word=self.wake_word,
                speech=self.speech,
                coordinator=self.coordinator,
                robot=self.robot,
                memory=None,
            )
            tasks.start("ear", self.ear.run(), forever=False)
            yield self
        assert died == []

    def hears(self, *chunks: bytes) -> None:
        for chunk in chunks:
            self.source.given.put_nowait(chunk)

    async def woken(self) -> FakeEars:
        """The line to speech that the wake word opened."""
        lines = len(self.speech.lines)
        self.hears(WAKING)
        await until(lambda: len(self.speech.lines) > lines)
        return self.speech.lines[-1]

    async def asleep(self) -> None:
        await until(lambda: self.ear.ear.state is State.ASLEEP)
        await self.ear._standing.settled()


async def test_what_is_said_after_the_wake_word_is_sent_to_the_coordinator() -> None:
    async with Heard().running() as heard:
        line = await heard.woken()
        heard.hears(LOUD, SILENCE)
        await until(lambda: line.sent[-2:] == [LOUD, SILENCE])
        line.tell(transcript("Find the red bottle.", "find the red bottle"))
        await until(lambda: heard.coordinator.commands == ["find the red bottle"])
        assert heard.coordinator.asked == [("find the red bottle", "Find the red bottle.")]
        assert heard.loudspeaker.played[0] == wav_of(Tone.AWAKE)


async def test_what_stands_just_before_the_wake_words_end_goes_along_and_no_more() -> None:
    async with Heard().running(stop_without_wake_word=False) as heard:
        heard.hears(*[SILENCE] * 20)
        line = await heard.woken()
        await until(lambda: len(line.sent) > 0)
        await until(lambda: line.sent[-1] == WAKING)
        assert len(line.sent) == round(LEAD_S / 0.08)


async def test_a_stop_in_a_partial_reading_stops_before_the_last_one_is_there() -> None:
    async with Heard().running() as heard:
        line = await heard.woken()
        line.tell(transcript("stop", stop=True), final=False)
        await until(lambda: heard.robot.stops == ["said: stop"])
        await until(lambda: heard.speech.spoken == [words.STOPPED])
        assert heard.coordinator.asked == []


async def test_a_stop_that_does_not_arrive_is_asked_for_again() -> None:
    heard = Heard(robot=FakeRobot(deaf=3))
    async with heard.running() as heard:
        line = await heard.woken()
        line.tell(transcript("stop", stop=True), final=False)
        await until(lambda: heard.robot.deaf == 2)
        await heard.clock.advance(INSIST_S / 2)
        assert heard.robot.stops == ["said: stop"]


async def test_a_stop_that_never_arrives_is_said() -> None:
    heard = Heard(robot=FakeRobot(deaf=10_000))
    async with heard.running(quiet_hours="22:00-07:00") as heard:
        line = await heard.woken()
        line.tell(transcript("stop", stop=True), final=False)
        await until(lambda: heard.robot.deaf < 10_000)
        await heard.clock.advance(INSIST_S + 1.0)
        await until(lambda: heard.speech.spoken == [words.STOP_LOST])


async def test_a_stop_is_heard_without_the_wake_word_while_a_mission_runs() -> None:
    heard = Heard(coordinator=FakeCoordinator(running=RUNNING), speech=FakeSpeech(short=transcript("stop", stop=True)))
    async with heard.running() as heard:
        heard.hears(*[SILENCE] * 4, *SAYING)
        await until(lambda: heard.robot.stops == ["said: stop"])
        assert len(heard.speech.read[0]) == 12 * CHUNK_BYTES
        assert heard.speech.lines == []


async def test_a_stop_is_heard_without_the_wake_word_while_it_is_understood_what_was_said() -> None:
    heard = Heard(speech=FakeSpeech(short=transcript("stop", stop=True)))
    heard.coordinator.understands.clear()
    async with heard.running() as heard:
        (await heard.woken()).tell(transcript("find the red bottle"))
        await until(lambda: heard.coordinator.asked != [])
        heard.hears(*[SILENCE] * 4, *SAYING)
        await until(lambda: heard.robot.stops == ["said: stop"])
        await until(lambda: heard.speech.spoken == [words.STOPPED])
        heard.coordinator.understands.set()
        await heard.clock.settle()
        assert heard.coordinator.commands == [], "what was under way comes too late"


async def test_a_stop_is_heard_without_the_wake_word_from_the_moment_a_mission_is_asked_for() -> None:
    heard = Heard(speech=FakeSpeech(short=transcript("stop", stop=True)))
    async with heard.running() as heard:
        line = await heard.woken()
        heard.coordinator.says_how_it_is.clear()
        line.tell(transcript("find the red bottle"))
        await until(lambda: heard.coordinator.commands == ["find the red bottle"])
        await until(lambda: heard.ear.ear.state is State.ASLEEP)
        heard.hears(*[SILENCE] * 4, *SAYING)
        await until(lambda: heard.robot.stops == ["said: stop"])


async def test_a_stop_goes_out_before_the_line_it_was_heard_on_is_closed() -> None:
    heard = Heard()
    heard.speech.closes.clear()
    async with heard.running() as heard:
        (await heard.woken()).tell(transcript("stop", stop=True), final=False)
        await until(lambda: heard.robot.stops == ["said: stop"])
        heard.speech.closes.set()


async def test_of_the_short_sayings_that_wait_the_newest_are_read() -> None:
    heard = Heard(coordinator=FakeCoordinator(running=RUNNING))
    heard.speech.reads.clear()
    async with heard.running() as heard:
        for _ in range(5):
            heard.hears(*SAYING)
        heard.hears(*SAYING_OF_ANOTHER)
        await until(lambda: len(heard.wake_word.told) == 6 * len(SAYING))
        heard.speech.reads.set()
        await until(lambda: len(heard.speech.read) == 1 + SHORT_SAYINGS_MAX)
        assert SAYING_OF_ANOTHER[0] in heard.speech.read[-1]


async def test_while_it_is_understood_what_was_said_the_mission_is_held_again() -> None:
    heard = Heard(coordinator=FakeCoordinator(running=RUNNING))
    heard.coordinator.understands.clear()
    async with heard.running(hold_s=20.0) as heard:
        (await heard.woken()).tell(transcript("find the red bottle"))
        await until(lambda: heard.coordinator.asked != [])
        await heard.clock.advance(20.0)
        assert heard.coordinator.holds == [20.0] * 4


async def test_a_mission_that_begins_while_it_speaks_stands_too() -> None:
    heard = Heard(coordinator=FakeCoordinator(running=RUNNING))
    heard.loudspeaker.waits = True
    async with heard.running() as heard:
        heard.coordinator.happens(EventKind.FOUND, heard.clock.now_s())
        await until(lambda: heard.loudspeaker.played == [b"I found the red bottle."])
        heard.coordinator.running = RUNNING.model_copy(update={"id": "m2"})
        heard.coordinator.happens(EventKind.START, heard.clock.now_s())
        await until(lambda: heard.coordinator.held == ["m1", "m2"])


async def test_it_says_nothing_before_the_mission_stands() -> None:
    heard = Heard(coordinator=FakeCoordinator(running=RUNNING))
    heard.coordinator.obeys.clear()
    async with heard.running() as heard:
        heard.coordinator.happens(EventKind.FOUND, heard.clock.now_s())
        await until(lambda: heard.coordinator.holds != [] and heard.speech.spoken != [])
        await heard.clock.settle()
        assert heard.loudspeaker.played == []
        heard.coordinator.obeys.set()
        await until(lambda: heard.loudspeaker.played == [b"I found the red bottle."])


async def test_speech_that_never_comes_to_an_end_is_left_and_a_tone_says_so() -> None:
    async with Heard().running() as heard:
        await heard.woken()
        await heard.clock.advance(HEARD_S_MAX)
        await until(lambda: heard.loudspeaker.played == [wav_of(Tone.AWAKE), wav_of(Tone.TROUBLE)])
        assert heard.ear.ear.state is State.ASLEEP


async def test_a_loudspeaker_that_never_comes_to_an_end_leaves_it_hearing() -> None:
    heard = Heard(coordinator=FakeCoordinator(running=RUNNING))
    heard.loudspeaker.waits = True
    async with heard.running() as heard:
        heard.coordinator.happens(EventKind.FOUND, heard.clock.now_s())
        await until(lambda: heard.loudspeaker.played == [b"I found the red bottle."])
        await heard.clock.advance(LATE_S + ECHO_S)
        await heard.asleep()
        await heard.woken()


@pytest.mark.parametrize("why", ["no mission runs", "it is not wanted"])
async def test_without_the_wake_word_nothing_is_read_where(why: str) -> None:
    heard = Heard(coordinator=FakeCoordinator(running=RUNNING if why == "it is not wanted" else None))
    async with heard.running(stop_without_wake_word=why != "it is not wanted") as heard:
        await heard.clock.settle()
        heard.hears(*[SILENCE] * 4, *SAYING)
        await until(lambda: len(heard.wake_word.told) == 13)
        assert heard.speech.read == []


async def test_it_does_not_hear_itself() -> None:
    heard = Heard(coordinator=FakeCoordinator(running=RUNNING))
    heard.loudspeaker.waits = True
    async with heard.running() as heard:
        heard.coordinator.happens(EventKind.FOUND, heard.clock.now_s())
        await until(lambda: heard.loudspeaker.played == [b"I found the red bottle."])
        heard.hears(WAKING, *[LOUD] * 3)
        await until(heard.source.given.empty)
        await heard.clock.settle()
        assert heard.wake_word.told == []
        heard.loudspeaker.quiet.set()
        await heard.asleep()
        heard.hears(WAKING)
        await until(heard.source.given.empty)
        await heard.clock.settle()
        assert heard.wake_word.told == [], "the room still sounds"
        await heard.clock.advance(0.3)
        heard.hears(SILENCE)
        await until(lambda: heard.wake_word.told == [SILENCE])


async def test_while_somebody_speaks_the_mission_stands_and_then_it_goes_on() -> None:
    heard = Heard(coordinator=FakeCoordinator(running=RUNNING))
    async with heard.running(hold_s=20.0) as heard:
        line = await heard.woken()
        await until(lambda: heard.coordinator.holds == [20.0])
        line.tell(transcript(""))
        await until(lambda: heard.coordinator.holds == [20.0, 0.0])


async def test_a_mission_that_a_person_paused_is_neither_held_nor_let_go() -> None:
    paused = RUNNING.model_copy(update={"paused": True})
    heard = Heard(coordinator=FakeCoordinator(running=paused))
    async with heard.running() as heard:
        line = await heard.woken()
        line.tell(transcript(""))
        await heard.asleep()
        await heard.clock.settle()
        assert heard.coordinator.holds == []


async def test_a_refusal_is_said() -> None:
    heard = Heard(coordinator=FakeCoordinator(refuses="the emergency stop is latched: reset it first"))
    async with heard.running() as heard:
        (await heard.woken()).tell(transcript("find the red bottle"))
        await until(lambda: heard.speech.spoken == ["the emergency stop is latched: reset it first"])


async def test_an_okay_is_an_answer_and_no_wake_word() -> None:
    wanted = Intent(action=WantedAction.FIND, command="find the blue cup", mood=Mood.FIND)
    question = Understood(
        question="Did you mean: find the blue cup?", choices=(Choice(text=wanted.command, intent=wanted),)
    )
    async with Heard(coordinator=FakeCoordinator(means=question)).running() as heard:
        line = await heard.woken()
        line.tell(transcript("okay nabu find the blue cub"))
        await until(lambda: len(heard.speech.lines) == 2)
        assert heard.coordinator.asked == [("find the blue cub",)]
        heard.speech.lines[-1].tell(transcript("Okay."))
        await until(lambda: heard.coordinator.commands == ["find the blue cup"])


async def test_a_new_sentence_in_place_of_an_answer_may_begin_with_the_wake_word() -> None:
    question = Understood(question="Did you mean the cup?", choices=())
    async with Heard(coordinator=FakeCoordinator(means=question)).running() as heard:
        (await heard.woken()).tell(transcript("find the cub"))
        await until(lambda: len(heard.speech.lines) == 2)
        heard.coordinator.means = understood("find the ball")
        heard.speech.lines[-1].tell(transcript("Hey Jarvis, find the ball."))
        await until(lambda: heard.coordinator.asked[1:] == [("find the ball.",)])


async def test_old_news_is_not_said() -> None:
    async with Heard().running() as heard:
        heard.coordinator.happens(EventKind.FOUND, heard.clock.now_s() - 61.0)
        heard.coordinator.happens(EventKind.FOUND, heard.clock.now_s())
        await until(lambda: heard.speech.spoken == ["I found the red bottle."])


async def test_in_quiet_hours_a_find_is_not_said() -> None:
    async with Heard().running(quiet_hours="22:00-07:00") as heard:
        heard.coordinator.happens(EventKind.FOUND, heard.clock.now_s())
        await until(heard.coordinator.happened.empty)
        await heard.clock.settle()
        assert heard.speech.spoken == []


async def test_without_speech_a_tone_of_its_own_says_so() -> None:
    heard = Heard(speech=FakeSpeech(away=True))
    async with heard.running() as heard:
        heard.hears(WAKING)
        await until(lambda: heard.loudspeaker.played == [wav_of(Tone.AWAKE), wav_of(Tone.TROUBLE)])
        await heard.asleep()


@pytest.mark.parametrize("wrong", [{"quiet_hours": "at night"}, {"sound": "nowhere.wav"}, {"hold_s": 61.0}])
def test_a_wrong_setting_is_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        Settings(**wrong)
