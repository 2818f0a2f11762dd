"""The parser's word table (`data/words.toml`), read once and indexed for matching."""

import tomllib
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

from contracts.coco import COCO_LABELS, COLOURS
from inference.colours import SPELLINGS

IRREGULAR = {
    "knives": "knife", "loaves": "loaf", "shelves": "shelf", "glasses": "glass", "benches": "bench", "couches": "couch",
    "mice": "mouse", "geese": "goose", "people": "person", "buses": "bus", "skis": "skis", "scissors": "scissors",
    "sandwiches": "sandwich", "dishes": "dish", "toothbrushes": "toothbrush", "watches": "watch", "puppies": "puppy",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Name:
    """One thing a person can name: its words, the class it means ("none": known, but no detector class)."""

    words: tuple[str, ...]
    label: str


@dataclass(frozen=True)
class Lexicon:
    names: dict[tuple[str, ...], Name]
    needs: tuple[tuple[tuple[str, ...], tuple[str, ...]], ...]
    """(words, labels that answer it), longest first."""
    near: dict[str, tuple[str, ...]]
    vocabulary: frozenset[str]
    """Every single word that is part of a name."""
    correctable: tuple[str, ...]
    """The words a typo may be taken for."""
    attributes: frozenset[str]
    colours: frozenset[str]
    places: frozenset[str]
    negations: frozenset[str]
    fillers: frozenset[str]
    afterwords: frozenset[str]
    """May stand between a thing and its colour: 'the bottle that is red', 'a cup, the blue one'."""
    never_corrected: frozenset[str]
    longest: int
    """Words in the longest name."""


@cache
def lexicon() -> Lexicon:
    table = tomllib.loads(files("inference").joinpath("data/words.toml").read_text(encoding="utf-8"))
    names: dict[tuple[str, ...], Name] = {}
    for label in COCO_LABELS:
        for said in (label, *table["names"].get(label, ())):
            _add(names, said, label)
    seen_words = {word for words in names for word in words}
    for said in table["words"]["unseen"]:
        names.setdefault(tuple(said.split()), Name(tuple(said.split()), "none"))
    words = table["words"]
    colours = frozenset((*COLOURS, *SPELLINGS))
    plain = frozenset(words["fillers"]) | frozenset(words["places"]) | frozenset(words["negations"])
    needs = sorted(((tuple(k.split()), tuple(v)) for k, v in table["needs"].items()), key=lambda n: -len(n[0]))
    need_words = {word for said, _ in needs for word in said}
    vocabulary = frozenset(word for said in names for word in said)
    return Lexicon(
        names=names,
        needs=tuple(needs),
        near={label: tuple(labels) for label, labels in table["near"].items()},
        vocabulary=vocabulary,
        correctable=tuple(sorted(word for word in seen_words if len(word) >= 4)),
        attributes=frozenset(words["attributes"]),
        colours=colours,
        places=frozenset(words["places"]),
        negations=frozenset(words["negations"]),
        fillers=frozenset(words["fillers"]),
        afterwords=frozenset(words["afterwords"]),
        never_corrected=plain | need_words | colours | frozenset(words["attributes"]) | frozenset(words["confusable"]),
        longest=max(len(said) for said in names),
    )


def _add(names: dict[tuple[str, ...], Name], said: str, label: str) -> None:
    """A name of several words is also known joined ("teddybear")."""
    words = tuple(said.split())
    names.setdefault(words, Name(words, label))
    if len(words) == 2:
        names.setdefault(("".join(words),), Name(words, label))


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


def correction(word: str, words: tuple[str, ...]) -> str | None:
    """The one of `words` a slip of the finger away from `word`: none when it is too far, or two are as near.

    Short words must keep their first letter (or swap their first two): "look" is not a misspelt "book".
    """
    if len(word) < 4:
        return None
    allowed = 1 if len(word) < 8 else 2
    nearest = {known: edits(word, known) for known in words if _comparable(word, known, allowed)}
    distance = min(nearest.values(), default=allowed + 1)
    best = [known for known, steps in nearest.items() if steps == distance]
    return best[0] if distance <= allowed and len(best) == 1 else None


def _comparable(word: str, known: str, allowed: int) -> bool:
    if abs(len(known) - len(word)) > allowed:
        return False
    same_start = word[0] == known[0] or word[:2] == known[1::-1]
    return same_start or len(word) >= 7


def edits(a: str, b: str) -> int:
    """Optimal string alignment distance: insertions, deletions, substitutions, swaps of neighbours."""
    rows = [list(range(len(b) + 1))]
    for i, x in enumerate(a, start=1):
        row = [i]
        for j, y in enumerate(b, start=1):
            cost = min(rows[i - 1][j] + 1, row[j - 1] + 1, rows[i - 1][j - 1] + (x != y))
            if i > 1 and j > 1 and x == b[j - 2] and a[i - 2] == y:
                cost = min(cost, rows[i - 2][j - 2] + 1)
            row.append(cost)
        rows.append(row)
    return rows[-1][-1]
