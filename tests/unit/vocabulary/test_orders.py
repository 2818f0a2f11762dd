"""Stop, wait, go on, in whatever form and language they are shouted; and what only looks like them."""

import tomllib
from importlib.resources import files
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from contracts.reading import Mood
from vocabulary.folding import words_of
from vocabulary.orders import order_in, stop_in, stop_words
from vocabulary.spelling import one_slip

TABLE: dict[str, Any] = tomllib.loads(files("vocabulary").joinpath("data/orders.toml").read_text(encoding="utf-8"))
ORDERS = (Mood.EMERGENCY, Mood.STOP, Mood.PAUSE, Mood.RESUME)


def phrases(mood: Mood) -> list[str]:
    group = TABLE[mood.value]
    own = [*group.get("opens", ()), *group.get("alone", ())]
    return [
        *own,
        *(said for key in ("languages", "languages_alone") for some in group.get(key, {}).values() for said in some),
    ]


SAID = [(mood, said) for mood in ORDERS for said in phrases(mood)]
LANGUAGES = ("de", "es", "fr", "it", "nl", "pt", "tr", "vi")


def read(text: str) -> Mood | None:
    order = order_in(text)
    return order.mood if order is not None else None


@pytest.mark.parametrize("mood", ORDERS)
def test_every_word_of_the_table_is_heard_however_it_is_shouted(mood: Mood) -> None:
    forms = ("{}", "{}!", "  {}...", "please {}", "no, {}!!", "{} {}", "{}, {}, {}!", "Hey robot, {} now")
    shouted = [form.replace("{}", said) for said in phrases(mood) for form in forms]
    missed = [
        text
        for text in (*shouted, *map(str.upper, shouted))
        if read(text) is not mood and read(text) not in graver(mood)
    ]
    assert missed == []


def graver(mood: Mood) -> set[Mood]:
    """One word means two things in two languages: the graver counts."""
    return set(ORDERS[: ORDERS.index(mood)])


@pytest.mark.parametrize("mood", ORDERS[1:])
@pytest.mark.parametrize("language", LANGUAGES)
def test_each_order_is_known_in_every_language(language: str, mood: Mood) -> None:
    assert len(TABLE[mood.value]["languages"][language]) >= 2
    assert len(TABLE["emergency"]["languages"][language]) >= 1


@pytest.mark.parametrize(
    "text",
    [
        "stop!", "halt", "wait, stop", "cancel that", "stop moving", "no, stop it", "freeze", "that's enough",
        "that’s enough", "abort", "stop looking for the bottle", "Stop. Stop. STOP!", "sotp", "stpo!!", "stopp", "hatl",
        "no! Stop!", "find the cup no stop", "ok google stop", "she said stop", "would you stop it please",
        "I want you to stop", "how do I make you stop?", "don't move", "do not move!", "look out stop", "hör auf",
        "HALT SOFORT ANHALTEN", "Dừng lại!", "¡Alto!", "arrêtez-vous", "fermati subito", "dur, dur!", "停",
        "стоп!", "don't stop. I mean stop!", "I said halt", "for heaven's sake stop", "cancel the search for the cup",
    ],
)  # fmt: skip
def test_a_stop_is_heard(text: str) -> None:
    assert read(text) is Mood.STOP


@pytest.mark.parametrize(
    "text",
    [
        "find the stop sign", "stop sign", "find the stop watch", "find the stop-watch", "where is the bus stop",
        "look for the door stop", "don't stop", "don’t stop!", "never stop looking for the cup", "it stopped",
        "why did you stop", "when will you stop", "find the book called Stop the Clock", "I can't wait for a banana",
        "wait for me to find the cup", "no wait find the vase", "find the cup and stop", "a full stop", "shop", "salt",
        "hat", "find the hat", "top", "bottle", "cancelled", "", "   ", "...", "👍", "turn off the light",
        "find the cup that stops leaks", "don't stop looking for my phone", "emergency exit sign",
    ],
)  # fmt: skip
def test_what_only_looks_like_a_stop_is_none(text: str) -> None:
    assert read(text) is None


@pytest.mark.parametrize(
    "text",
    [
        "emergency stop",
        "EMERGENCY!!",
        "e-stop",
        "hit the emergency stop",
        "Not-Aus!",
        "noodstop",
        "stop! emergency stop!",
    ],
)
def test_an_emergency_is_graver_than_a_stop(text: str) -> None:
    assert read(text) is Mood.EMERGENCY


@pytest.mark.parametrize(
    ("text", "rest"),
    [
        ("stop and find the cup", "find the cup"),
        ("stop looking for the cup and find the book", "find the book"),
        ("cancel that and get the spoon", "get the spoon"),
        ("Stop! Find the cup instead", "Find the cup instead"),
        ("find the cup. stop", ""),
        ("stop looking for the cup", ""),
    ],
)
def test_what_is_said_behind_a_stop_is_kept_apart(text: str, rest: str) -> None:
    order = order_in(text)
    assert order is not None
    assert (order.mood, order.rest) == (Mood.STOP, rest)


@given(st.text(max_size=600))
def test_no_text_makes_it_fail(text: str) -> None:
    order = order_in(text)
    assert order is None or order.mood in {Mood.STOP, Mood.PAUSE, Mood.RESUME, Mood.EMERGENCY}


@given(
    st.sampled_from([said for mood, said in SAID if mood in {Mood.STOP, Mood.EMERGENCY}]),
    st.lists(st.sampled_from("!?.,… \n"), max_size=6),
)
def test_punctuation_never_hides_a_stop(said: str, around: list[str]) -> None:
    assert read("".join(around) + said + "".join(around)) in {Mood.STOP, Mood.EMERGENCY}


@pytest.mark.parametrize(
    ("written", "slip"),
    [("sotp", True), ("stp", True), ("stopp", True), ("stip", True), ("stop", False), ("pots", False), ("st", False)],
)
def test_a_slip_is_one_letter(written: str, slip: bool) -> None:
    assert one_slip(written, "stop") is slip


def test_words_keep_their_place_in_the_text() -> None:
    text = "Hör  auf, the dog's ball"
    assert [text[word.start : word.end] for word in words_of(text)] == ["Hör", "auf", "the", "dog's", "ball"]
    assert [word.text for word in words_of(text) if word.owner] == ["dogs"]


@pytest.mark.parametrize("begun", ["Stop", "stop the", "Halt.", "please stop", "Find the cup. No, stop!", "Emergency"])
def test_what_begins_as_a_stop_is_one_whatever_follows(begun: str) -> None:
    assert stop_in(begun, whole=False)
    assert stop_in(begun)


@pytest.mark.parametrize(
    "begun", ["don't", "end", "hold", "off", "break", "find a good place to stop", "wait", "go on", ""]
)
def test_what_may_still_become_something_else_is_no_stop_yet(begun: str) -> None:
    assert not stop_in(begun, whole=False)


def test_alone_and_done_it_is_one() -> None:
    assert [stop_in(said) for said in ("don't", "hold", "wait", "go on")] == [True, True, False, False]


@pytest.mark.parametrize("language", ["en", "de", "vi", "xx", ""])
def test_each_word_that_speech_listens_for_is_a_stop(language: str) -> None:
    assert all(stop_in(word, whole=False) for word in stop_words(language))
    assert 1 <= len(stop_words(language)) <= 4
