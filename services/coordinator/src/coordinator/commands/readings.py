"""Several readings of one saying, weighed: the same intent goes on, different ones are asked back. Pure."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from contracts.colours import COLOUR_WORDS
from contracts.intent import Choice, Intent, Understood, WantedAction
from contracts.reading import Mood
from vocabulary.folding import joined, words_of
from vocabulary.rooms import called
from vocabulary.sounding import sound_of

GRAVEST: Final = (WantedAction.EMERGENCY, WantedAction.STOP, WantedAction.PAUSE)
"""One reading of these is enough: a robot that stands still too often is a nuisance."""
VERBS: Final = {
    WantedAction.FIND: "find", WantedAction.BRING: "bring", WantedAction.POUR: "pour", WantedAction.GO: "go to",
}  # fmt: skip
NOT_UNDERSTOOD: Final = "I did not understand. Please say it again"


@dataclass(frozen=True, slots=True)
class HeardIntent:
    """`sure`: every word of it was known, and none is left over."""

    intent: Intent
    sure: bool


def understood(heard: Sequence[HeardIntent]) -> Understood:
    """The likeliest reading first. Goes on where all mean the same and one of them is sure; a reading that asks for
    nothing known is no choice.
    """
    readings = [one.intent for one in heard]
    for action in GRAVEST:
        order = next((one for one in readings if one.action is action), None)
        if order is not None:
            return Understood(intent=order)
    told: dict[tuple[object, ...], Intent] = {}
    for one in readings:
        told.setdefault(meaning(one), one)
    if len(told) == 1 and any(one.sure for one in heard):
        return Understood(intent=readings[0])
    ranked = [one for one in told.values() if _says_something(one)]
    if not ranked:
        return Understood(question=NOT_UNDERSTOOD)
    choices = tuple(Choice(text=in_words(one)[:200], intent=one) for one in ranked[:4])
    return Understood(question=f"Did you mean: {', or '.join(one.text for one in choices)}?"[:500], choices=choices)


def meaning(intent: Intent) -> tuple[object, ...]:
    """Two readings with the same one are the same wish."""
    things = tuple((one.label, sound_of(one.description), one.not_colours) for one in intent.targets)
    return (intent.action, things, intent.room, intent.about, intent.mood)


def uses_all_colours(intent: Intent) -> bool:
    """Each colour that was heard is one of a thing, or is excluded: 'the red cup at the green one' lost a 'not'."""
    if not intent.targets:
        return True
    said = {COLOUR_WORDS[word] for word in joined(words_of(intent.command)).split() if word in COLOUR_WORDS}
    used = {COLOUR_WORDS[word] for one in intent.targets for word in one.description.split() if word in COLOUR_WORDS}
    return said <= used.union(*(one.not_colours for one in intent.targets))


def in_words(intent: Intent) -> str:
    """For a person."""
    verb = VERBS.get(intent.action)
    if verb is None:
        return intent.command
    things = " and ".join(f"the {one.description}" for one in intent.targets)
    where = called(intent.room) if intent.room is not None else ""
    return f"{verb} {things} in {where}" if things and where else f"{verb} {things or where}"


def _says_something(intent: Intent) -> bool:
    return bool(intent.targets or intent.room) or (
        intent.action is not WantedAction.NOTHING and intent.action not in VERBS
    ) or intent.mood is Mood.DENIED  # fmt: skip
