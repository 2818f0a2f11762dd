"""What the ear does next: asleep, listening, understanding, asking back, speaking. Pure; time comes from outside."""

from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Final, assert_never

from contracts.intent import Choice, Intent, Understood, WantedAction
from ear import words
from ear.choices import Neither, chosen
from ear.messages import (
    Action,
    Away,
    Begun,
    Event,
    HeardOut,
    Hold,
    LetGo,
    Listen,
    Meant,
    News,
    Replied,
    Say,
    Send,
    Sound,
    Sounding,
    Spoken,
    StopHeard,
    Stopped,
    StopRobot,
    Tone,
    Understand,
    Woken,
)

ECHO_S: Final = 0.3
"""So long a room goes on sounding after the loudspeaker has ended."""
QUESTIONS_MAX: Final = 2
"""Asked back once more, and not again: a third question helps nobody."""
LISTENS_MAX: Final = 2
"""Once more where only the wake word itself was heard."""
NEWS_MAX: Final = 3
"""What waits to be said; the oldest is left out."""
STOPPING: Final = frozenset({WantedAction.STOP, WantedAction.EMERGENCY})


class State(StrEnum):
    """What the ear is at."""

    ASLEEP = "asleep"
    """Waits for the wake word. Of all else only an order to stop is looked for."""
    LISTENING = "listening"
    """Takes down what is said; the robot stands."""
    UNDERSTANDING = "understanding"
    """Others are asked: what was meant, or that it be done."""
    ASKING = "asking"
    """Takes down the answer to its own question; no wake word is needed, the robot stands."""
    SPEAKING = "speaking"
    """Has a sentence made, and plays it: while it sounds nothing is heard, and the robot stands."""


ALLOWED: Final[dict[State, frozenset[State]]] = {
    State.ASLEEP: frozenset({State.LISTENING, State.SPEAKING, State.UNDERSTANDING}),
    State.LISTENING: frozenset({State.UNDERSTANDING, State.ASLEEP}),
    State.UNDERSTANDING: frozenset({State.SPEAKING, State.ASLEEP}),
    State.ASKING: frozenset({State.UNDERSTANDING, State.ASLEEP}),
    State.SPEAKING: frozenset({State.ASKING, State.ASLEEP, State.UNDERSTANDING}),
}


@dataclass(frozen=True, slots=True)
class Ear:
    """`question` is the one being asked, or answered; `news` waits to be said."""

    state: State = State.ASLEEP
    turn: int = 0
    question: Understood | None = None
    questions: int = 0
    listens: int = 0
    holds: bool = False
    sounding: bool = False
    deaf_until_s: float = 0.0
    news: tuple[str, ...] = ()


def hears(ear: Ear, now_s: float) -> bool:
    """Half duplex: false while the loudspeaker sounds, and until its echo is gone."""
    return not ear.sounding and now_s >= ear.deaf_until_s


def step(ear: Ear, event: Event, now_s: float, *, quiet: bool = False) -> tuple[Ear, tuple[Action, ...]]:
    """`quiet`: it says nothing, and asks nothing back; only a stop that did not reach the robot is said all the same.
    An answer of an older turn changes nothing.
    """
    doing = _Step(ear, now_s, quiet)
    if not isinstance(event, Woken | StopHeard | News) and event.turn != ear.turn:
        return ear, ()
    doing.take(event)
    return doing.ear, tuple(doing.actions)


@dataclass
class _Step:
    ear: Ear
    now_s: float
    quiet: bool
    actions: list[Action] = field(default_factory=list[Action])

    def take(self, event: Event) -> None:  # noqa: PLR0912 - one per event
        match event:
            case StopHeard():
                self._stop(event.words)
            case Woken():
                if self.ear.state is State.ASLEEP:
                    self._sound(Tone.AWAKE)
                    self.ear = replace(self.ear, question=None, questions=0, listens=0)
                    self._listen(State.LISTENING)
            case HeardOut():
                self._heard_out(event)
            case Meant():
                self._meant(event.understood)
            case Begun():
                if event.able:
                    self._say(event.able)
                else:
                    self._sound(Tone.DONE)
                    self._rest()
            case Replied():
                self._say(event.sentence)
            case Stopped():
                self._say(words.STOPPED if event.reached else words.STOP_LOST, urgent=not event.reached)
            case Away():
                self._away(event)
            case Sounding():
                self.ear = replace(self.ear, sounding=True)
            case Spoken():
                self._spoken()
            case News():
                self.ear = replace(self.ear, news=(*self.ear.news, event.sentence)[-NEWS_MAX:])
                if self.ear.state is State.ASLEEP:
                    self._rest()
            case _:
                assert_never(event)

    # hearing

    def _listen(self, state: State, *, again: bool = False) -> None:
        self._to(state)
        self.ear = replace(self.ear, listens=self.ear.listens + 1, holds=True)
        self.actions += [Hold(), Listen(self.ear.turn, again=again)]

    def _heard_out(self, event: HeardOut) -> None:
        question = self.ear.question
        if not event.readings and event.spoke and self.ear.listens < LISTENS_MAX:
            self._listen(self.ear.state, again=True)
        elif not event.readings:
            self._rest()
        elif question is None:
            self._understand(event.readings)
        else:
            self._answered(question, event.readings)

    def _answered(self, question: Understood, readings: tuple[str, ...]) -> None:
        match chosen(question.choices, readings):
            case Choice(intent=intent):
                self._to(State.UNDERSTANDING)
                self._do(intent)
            case Neither():
                self._rest()
            case None:  # it may be a new sentence, with the word that wakes it before it
                self._understand(words.readings_of(*readings) or readings)

    def _understand(self, readings: tuple[str, ...]) -> None:
        self._to(State.UNDERSTANDING)
        self.actions.append(Understand(self.ear.turn, readings))

    # what was meant

    def _meant(self, understood: Understood) -> None:
        if understood.intent is not None:
            self._do(understood.intent)
        elif self.ear.questions >= QUESTIONS_MAX:
            self.ear = replace(self.ear, question=None)
            self._say(words.GAVE_UP)
        else:
            self.ear = replace(self.ear, question=understood, questions=self.ear.questions + 1, listens=1)
            self._say(words.question(understood, again=self.ear.questions > 1))

    def _do(self, intent: Intent) -> None:
        self.ear = replace(self.ear, question=None)
        if intent.action in STOPPING:
            self._stop(intent.command)
        else:
            self.actions.append(Send(self.ear.turn, intent))

    def _stop(self, said: str) -> None:
        """Before anything else, whatever was under way: its answers come too late."""
        self._quieten()
        self.ear = replace(self.ear, question=None)
        self._to(State.UNDERSTANDING)
        self.actions.insert(0, StopRobot(self.ear.turn, said))

    def _away(self, event: Away) -> None:
        if self.ear.state is State.UNDERSTANDING:
            self._say(words.away(event.service, event.why))
        else:  # speech: neither a reading nor a voice
            self._sound(Tone.TROUBLE)
            self.ear = replace(self.ear, news=())
            self._quieten()
            self._rest()

    # speaking

    def _say(self, sentence: str, *, urgent: bool = False) -> None:
        if self.quiet and not urgent:
            self.ear = replace(self.ear, question=None)
            self._rest()
            return
        self._to(State.SPEAKING)
        self.ear = replace(self.ear, holds=True)
        self.actions += [Hold(), Say(self.ear.turn, sentence)]

    def _spoken(self) -> None:
        self._quieten()
        if self.ear.question is not None:
            self._listen(State.ASKING, again=True)
        else:
            self._rest()

    def _quieten(self) -> None:
        if self.ear.sounding:
            self.ear = replace(self.ear, sounding=False, deaf_until_s=self.now_s + ECHO_S)

    def _rest(self) -> None:
        """What waits to be said is said first; then the mission goes on, and it sleeps."""
        waiting = () if self.quiet else self.ear.news
        self.ear = replace(self.ear, question=None, news=waiting[1:])
        self._to(State.ASLEEP)
        if waiting:
            self._say(waiting[0])
        elif self.ear.holds:
            self.ear = replace(self.ear, holds=False)
            self.actions.append(LetGo())

    def _sound(self, tone: Tone) -> None:
        if not self.quiet:
            self.actions.append(Sound(tone))

    def _to(self, state: State) -> None:
        was = self.ear.state
        if state is not was and state not in ALLOWED[was]:
            raise AssertionError(f"{was} does not lead to {state}")
        self.ear = replace(self.ear, state=state, turn=self.ear.turn + 1)
