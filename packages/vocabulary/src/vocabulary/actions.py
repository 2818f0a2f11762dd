"""What is to be done with the thing that is asked for: find, bring, pour, go, dock. Pure rules over folded words."""

import re
from typing import Final

from contracts.intent import WantedAction
from vocabulary.folding import joined, words_of

DOCKING: Final = re.compile(
    r"((please|now|robot|hey|ok) )*((can|could|will) you )?((go|drive|return|get|come|head) )?(back )?"
    r"(to )?((your|the) )?(dock|charger|home|charge|docking station|charging station)( (now|please))*"
)
POURING: Final = re.compile(r"\bpour\b")
BRINGING: Final = re.compile(
    r"\b(bring|fetch|deliver|retrieve|grab)\b|\b(give|hand|pass|get) (me|us|him|her|it|my|the|a|an|some|our|your)\b"
)
GOING: Final = re.compile(
    r"\b(go|drive|head|walk|roll|come|move)( (back|over|up|now))* (to|into|towards|near|next to)\b|\btake me to\b"
    r"|\bcome here\b"
)
FINDING: Final = re.compile(r"\b(find|look|search|locate|seek|where)\b")


def is_docking(text: str) -> bool:
    """Nothing but the way to the dock is said."""
    return DOCKING.fullmatch(joined(words_of(text))) is not None


def action_in(text: str) -> WantedAction:
    """Of words that ask for a thing; the one that asks most of the robot. FIND where none is said."""
    said = joined(words_of(text))
    if POURING.search(said) and not (FINDING.search(said) and "to pour" in said):  # "find something to pour from"
        return WantedAction.POUR
    if BRINGING.search(said):
        return WantedAction.BRING
    return WantedAction.GO if GOING.search(said) and not FINDING.search(said) else WantedAction.FIND
