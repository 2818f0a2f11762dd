"""What the ear does next: woken, listening, asking back, speaking; a stop before everything else."""

from dataclasses import replace

import pytest

from contracts.intent import Choice, Intent, Understood, WantedAction
from contracts.reading import Mood
from ear import core, words
from ear.core import ALLOWED, ECHO_S, Ear, State, Tone, hears, step

NOW_S = 100.0


def intent(command: str, action: WantedAction = WantedAction.FIND, able: str = "") -> Intent:
    return Intent(action=action, command=command, mood=Mood.FIND, able=able)


CUP, CAP = (Choice(text=f"find the {one}", intent=intent(f"find the {one}")) for one in ("blue cup", "blue cap"))
QUESTION = Understood(question="Did you mean: find the blue cup, or find the blue cap?", choices=(CUP, CAP))


class Talk:
    """Events one after another; each answer is to the newest turn."""

    def __init__(self, ear: Ear | None = None, *, quiet: bool = False) -> None:
        self.ear = ear or Ear()
        self.quiet = quiet
        self.now_s = NOW_S
        self.states = [self.ear.state]
        self.actions: tuple[core.Action, ...] = ()

    def feed(self, event: core.Event) -> tuple[core.Action, ...]:
        self.ear, self.actions = step(self.ear, event, self.now_s, quiet=self.quiet)
        self.states.append(self.ear.state)
        return self.actions

    def said(self, *readings: str, spoke: bool = True) -> tuple[core.Action, ...]:
        return self.feed(core.HeardOut(self.ear.turn, readings, spoke))

    def meant(self, understood: Understood) -> tuple[core.Action, ...]:
        return self.feed(core.Meant(self.ear.turn, understood))

    def spoken(self) -> tuple[core.Action, ...]:
        self.feed(core.Sounding(self.ear.turn))
        return self.feed(core.Spoken(self.ear.turn))

    def asks(self) -> "Talk":
        self.feed(core.Woken())
        self.said("find the blue cup", "find the blue cap")
        self.meant(QUESTION)
        self.spoken()
        return self


def test_the_table_names_every_state_and_leads_out_of_each() -> None:
    assert set(ALLOWED) == set(State)
    assert all(ALLOWED.values())
    assert State.ASLEEP in set.union(*map(set, ALLOWED.values()))


def test_woken_it_listens_and_the_mission_stands() -> None:
    talk = Talk()
    assert talk.feed(core.Woken()) == (core.Sound(Tone.AWAKE), core.Hold(), core.Listen(talk.ear.turn))
    assert talk.ear.state is State.LISTENING


def test_what_was_said_is_understood_and_sent_and_the_mission_goes_on() -> None:
    talk = Talk()
    talk.feed(core.Woken())
    assert talk.said("find the bottle") == (core.Understand(talk.ear.turn, ("find the bottle",)),)
    wanted = intent("find the bottle")
    assert talk.meant(Understood(intent=wanted)) == (core.Send(talk.ear.turn, wanted),)
    assert talk.feed(core.Begun(talk.ear.turn)) == (core.Sound(Tone.DONE), core.LetGo())
    assert talk.ear.state is State.ASLEEP


def test_a_question_is_asked_aloud_and_the_next_saying_is_the_answer() -> None:
    talk = Talk()
    talk.feed(core.Woken())
    talk.said("find the blue cup", "find the blue cap")
    asked = talk.meant(QUESTION)
    assert asked == (core.Hold(), core.Say(talk.ear.turn, QUESTION.question))
    assert talk.spoken() == (core.Hold(), core.Listen(talk.ear.turn, again=True))
    assert talk.ear.state is State.ASKING
    assert talk.said("the cap") == (core.Send(talk.ear.turn, CAP.intent),)


def test_an_answer_that_names_none_of_them_is_understood_as_a_new_sentence() -> None:
    talk = Talk().asks()
    assert talk.said("find the ball") == (core.Understand(talk.ear.turn, ("find the ball",)),)


def test_the_second_time_it_asks_by_number_and_then_gives_up() -> None:
    talk = Talk().asks()
    talk.said("hm")
    assert talk.meant(QUESTION)[-1] == core.Say(talk.ear.turn, "one: find the blue cup. two: find the blue cap?")
    talk.spoken()
    talk.said("hm")
    assert talk.meant(QUESTION)[-1] == core.Say(talk.ear.turn, words.GAVE_UP)
    assert core.LetGo() in talk.spoken()
    assert talk.ear.state is State.ASLEEP


def test_neither_ends_it() -> None:
    talk = Talk().asks()
    assert talk.said("neither") == (core.LetGo(),)
    assert talk.ear.state is State.ASLEEP


def test_nobody_spoke() -> None:
    talk = Talk()
    talk.feed(core.Woken())
    assert talk.said(spoke=False) == (core.LetGo(),)


def test_after_the_wake_word_alone_it_listens_once_more_and_not_for_ever() -> None:
    talk = Talk()
    talk.feed(core.Woken())
    assert talk.said() == (core.Hold(), core.Listen(talk.ear.turn, again=True))
    assert talk.said() == (core.LetGo(),)


@pytest.mark.parametrize("state", State)
def test_a_stop_comes_first_in_every_state(state: State) -> None:
    talk = Talk(replace(Ear(), state=state, turn=4, holds=True, question=QUESTION, sounding=state is State.SPEAKING))
    assert talk.feed(core.StopHeard("stop")) == (core.StopRobot(5, "stop"),)
    assert talk.ear.state is State.UNDERSTANDING
    late = talk.feed(core.Meant(4, Understood(intent=intent("find the bottle"))))
    assert late == (), "what was under way comes too late"
    assert talk.feed(core.Stopped(5, reached=True))[-1] == core.Say(6, words.STOPPED)


@pytest.mark.parametrize("action", [WantedAction.STOP, WantedAction.EMERGENCY])
def test_what_the_coordinator_understands_as_a_stop_is_the_emergency_stop(action: WantedAction) -> None:
    talk = Talk()
    talk.feed(core.Woken())
    talk.said("halt")
    assert talk.meant(Understood(intent=intent("halt", action))) == (core.StopRobot(talk.ear.turn, "halt"),)


def test_a_stop_that_did_not_arrive_is_said_even_in_quiet_hours() -> None:
    talk = Talk(quiet=True)
    talk.feed(core.StopHeard("stop"))
    assert talk.feed(core.Stopped(talk.ear.turn, reached=False))[-1] == core.Say(talk.ear.turn, words.STOP_LOST)


def test_in_quiet_hours_it_hears_and_does_and_says_nothing() -> None:
    talk = Talk(quiet=True)
    assert talk.feed(core.Woken()) == (core.Hold(), core.Listen(talk.ear.turn))
    talk.said("find the bottle")
    talk.meant(Understood(intent=intent("find the bottle", able="I carry nothing")))
    assert talk.feed(core.Begun(talk.ear.turn, "I carry nothing")) == (core.LetGo(),)
    assert talk.feed(core.News("I found the bottle.")) == ()
    talk.feed(core.StopHeard("stop"))
    assert talk.feed(core.Stopped(talk.ear.turn, reached=True)) == ()
    assert talk.ear.state is State.ASLEEP


def test_a_question_of_quiet_hours_is_not_waited_for() -> None:
    talk = Talk(quiet=True)
    talk.feed(core.Woken())
    talk.said("find the cup")
    assert talk.meant(QUESTION) == (core.LetGo(),)
    assert (talk.ear.state, talk.ear.question) == (State.ASLEEP, None)


def test_it_hears_nothing_while_it_sounds_and_until_the_echo_is_gone() -> None:
    talk = Talk()
    talk.feed(core.News("I found the bottle."))
    assert hears(talk.ear, NOW_S), "nothing sounds yet"
    talk.feed(core.Sounding(talk.ear.turn))
    assert not hears(talk.ear, NOW_S)
    talk.feed(core.Spoken(talk.ear.turn))
    assert not hears(talk.ear, NOW_S + ECHO_S - 0.01)
    assert hears(talk.ear, NOW_S + ECHO_S)


def test_while_it_speaks_the_mission_stands() -> None:
    talk = Talk()
    assert talk.feed(core.News("I found the bottle."))[0] == core.Hold()
    assert talk.spoken() == (core.LetGo(),)


def test_news_waits_until_the_talk_is_over_and_the_oldest_is_left_out() -> None:
    talk = Talk()
    talk.feed(core.Woken())
    for number in range(5):
        assert talk.feed(core.News(f"news {number}")) == ()
    told = [talk.said(spoke=False)[-1], talk.spoken()[-1], talk.spoken()[-1], talk.spoken()[-1]]
    assert [one.sentence for one in told if isinstance(one, core.Say)] == ["news 2", "news 3", "news 4"]
    assert told[-1] == core.LetGo()


def test_without_speech_a_tone_says_so_and_it_sleeps() -> None:
    talk = Talk()
    talk.feed(core.Woken())
    assert talk.feed(core.Away(talk.ear.turn, "speech", "busy")) == (core.Sound(Tone.TROUBLE), core.LetGo())


def test_without_the_coordinator_it_says_who_is_away() -> None:
    talk = Talk()
    talk.feed(core.Woken())
    talk.said("find the bottle")
    told = talk.feed(core.Away(talk.ear.turn, "coordinator", "not reachable"))
    assert told[-1] == core.Say(talk.ear.turn, "Coordinator: not reachable.")


def test_a_voice_that_is_away_leaves_nothing_open() -> None:
    talk = Talk()
    talk.feed(core.News("I found the bottle."))
    talk.feed(core.Away(talk.ear.turn, "speech", "not reachable"))
    assert (talk.ear.state, talk.ear.sounding, talk.ear.holds) == (State.ASLEEP, False, False)


def test_a_wake_word_in_a_talk_begins_none() -> None:
    talk = Talk()
    talk.feed(core.Woken())
    assert talk.feed(core.Woken()) == ()


def test_an_answer_of_an_older_turn_changes_nothing() -> None:
    talk = Talk()
    talk.feed(core.Woken())
    before = talk.ear
    assert talk.feed(core.HeardOut(talk.ear.turn - 1, ("find the bottle",), True)) == ()
    assert talk.ear == before
