"""What it says aloud, each in one short sentence, and what it was told without the word that woke it. Pure."""

from typing import Final

from contracts.intent import Understood
from contracts.mission import EndCause, Mission, MissionKind, Outcome
from vocabulary.folding import words_of

SENTENCE_CHARACTERS_MAX: Final = 160
"""About ten seconds: nothing is heard meanwhile."""
STOPPED: Final = "I have stopped."
STOP_LOST: Final = "The stop did not reach me. Press the stop button."
GAVE_UP: Final = "I did not understand. I do nothing."
READINGS_MAX: Final = 4
READING_CHARACTERS_MAX: Final = 500
WAKING: Final = frozenset({
    "hey", "hi", "okay", "ok", "jarvis", "nabu", "naboo", "navu", "alexa", "mycroft", "rhasspy", "raspy",
})  # fmt: skip
"""The parts of the words that wake it, as a recogniser writes them."""


def question(understood: Understood, *, again: bool) -> str:
    """`again`: it was asked before, and the answer named nothing: a number is heard more surely than a name."""
    if not again or len(understood.choices) < 2:
        return short(understood.question)
    numbers = ("one", "two", "three", "four")
    return short(
        ". ".join(f"{number}: {one.text}" for number, one in zip(numbers, understood.choices, strict=False)) + "?"
    )


def away(service: str, why: str) -> str:
    return short(f"{service.replace('_', ' ').capitalize()}: {why.rstrip('.')}.")


def ending(mission: Mission) -> str:
    """How a mission ended. '' = nobody needs to hear of it."""
    what = f"the {mission.target.description}" if mission.target is not None else "it"
    by = mission.report.ended_by if mission.report is not None else None
    if by in {EndCause.STOPPED, EndCause.PERSON}:  # who did it knows
        return ""
    docking = mission.kind is MissionKind.DOCK
    told = {
        Outcome.FOUND: f"I found {what}.",
        Outcome.NOT_FOUND: f"I did not find {what}.",
        Outcome.UNSURE: f"I am not sure whether I found {what}.",
        Outcome.DOCKED: "I am on my dock.",
        Outcome.DONE: "I have done that.",
        Outcome.ABORTED: "I did not get onto my dock." if docking else f"I gave up on {what}.",
    }
    return short(told.get(mission.outcome, "")) if mission.outcome is not None else ""


def readings_of(*said: str, woken: bool = True) -> tuple[str, ...]:
    """As the coordinator takes them: printable, each once, the first ones first; without the word that woke it, where
    one did: an "okay" may be an answer.
    """
    told = (_printable(_woken(one) if woken else one) for one in said)
    return tuple(dict.fromkeys(one for one in told if words_of(one)))[:READINGS_MAX]


def short(sentence: str) -> str:
    """To the end of a sentence or of a word within `SENTENCE_CHARACTERS_MAX`, the colons of a program left out."""
    plain = " ".join(sentence.split())
    if len(plain) <= SENTENCE_CHARACTERS_MAX:
        return plain
    cut = plain[:SENTENCE_CHARACTERS_MAX]
    for end in (". ", "; ", ": ", ", "):
        at = cut.rfind(end)
        if at > SENTENCE_CHARACTERS_MAX // 3:
            return f"{cut[:at]}."
    return f"{cut.rpartition(' ')[0]}."


def _woken(said: str) -> str:
    """What stands behind the wake word, where it opens the saying."""
    start = 0
    for word in words_of(said):
        if word.text not in WAKING:
            return said[word.start :] if start else said
        start = word.end
    return ""


def _printable(said: str) -> str:
    return "".join(one if one.isprintable() else " " for one in said).strip()[:READING_CHARACTERS_MAX]
