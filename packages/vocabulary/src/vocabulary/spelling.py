"""Takes a word for the one that was meant: plurals, slips of the finger, and spelling by ear. Pure."""

import re
from collections.abc import Sequence
from functools import lru_cache

from rapidfuzz.distance import OSA

IRREGULAR = {
    "knives": "knife", "loaves": "loaf", "shelves": "shelf", "glasses": "glass", "benches": "bench", "couches": "couch",
    "mice": "mouse", "geese": "goose", "people": "person", "buses": "bus", "skis": "skis", "scissors": "scissors",
    "sandwiches": "sandwich", "dishes": "dish", "toothbrushes": "toothbrush", "watches": "watch", "puppies": "puppy",
}  # fmt: skip
BY_EAR_MIN = 4
"""Letters from which a word may be taken for one that only sounds alike."""
BY_EAR_STEPS = 0.5
LENGTHS_APART_MAX = 4
_BY_EAR = (
    ("ph", "f"), ("th", "f"), ("ck", "k"), ("sci", "si"), ("sce", "se"), ("ce", "se"), ("ci", "si"), ("cy", "si"),
    ("qu", "kw"), ("c", "k"), ("z", "s"), ("y", "i"), ("x", "ks"), ("kh", "k"), ("gh", "g"), ("wh", "w"),
)  # fmt: skip


def singular_forms(word: str) -> tuple[str, ...]:
    """What `word` may be the plural of, the likeliest first; the word itself is not among them."""
    if word in IRREGULAR:
        return (IRREGULAR[word],)
    if not word.endswith("s") or word.endswith("ss") or len(word) < 4:
        return ()
    forms = [word[:-1]]
    if word.endswith("ies"):
        forms.insert(0, word[:-3] + "y")
    elif word.endswith("ves"):
        forms += [word[:-3] + "f", word[:-3] + "fe"]
    elif word.endswith("es"):
        forms.append(word[:-2])
    return tuple(forms)


def correction(word: str, words: Sequence[str]) -> str | None:
    """The one of `words` that `word` is a slip of: none when all are too far, or two are as near.

    One slip (a letter too many, too few, wrong, or swapped with its neighbour) is allowed, two from eight letters on.
    Short words must keep their first letter (or swap their first two): "look" is not a misspelt "book".
    """
    distances = {known: steps for known in words if (steps := _steps(word, known)) is not None}
    least = min(distances.values(), default=None)
    best = [known for known, steps in distances.items() if steps == least]
    return best[0] if len(best) == 1 else None


def one_slip(word: str, known: str) -> bool:
    """One letter too many, too few, wrong, or swapped with its neighbour."""
    return OSA.distance(word, known, score_cutoff=1) == 1


def same_start(word: str, known: str) -> bool:
    """The first letter is right, or the first two are swapped."""
    return word[:1] == known[:1] or word[:2] == known[1::-1]


def _steps(word: str, known: str) -> float | None:
    if word == known:
        return 0.0
    if doubled(word, known):
        return BY_EAR_STEPS
    if min(len(word), len(known)) < BY_EAR_MIN or abs(len(word) - len(known)) > LENGTHS_APART_MAX:
        return None
    allowed = 1 if len(word) < 8 else 2
    if same_start(word, known) or len(word) >= 7:
        distance = OSA.distance(word, known, score_cutoff=allowed)
        if distance <= allowed:
            return float(distance)
    return BY_EAR_STEPS + allowed if by_ear(word) == by_ear(known) else None


def doubled(word: str, known: str) -> bool:
    """'cupp', 'boook', 'gren': only the number of times a letter is repeated differs."""
    return min(len(word), len(known)) >= 3 and max(len(word), len(known)) >= 4 and _squeezed(word) == _squeezed(known)


@lru_cache(maxsize=4096)
def by_ear(word: str) -> str:
    """'fone' and 'phone', 'sizzors' and 'scissors' are the same to it."""
    for written, heard in _BY_EAR:
        word = word.replace(written, heard)
    return _squeezed(word)


@lru_cache(maxsize=4096)
def _squeezed(word: str) -> str:
    return re.sub(r"(.)\1+", r"\1", word)
