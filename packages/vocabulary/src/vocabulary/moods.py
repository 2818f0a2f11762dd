"""What kind of saying it is: an asking, a denial, a statement, thanks, a question. Pure rules over clauses.

Only what is surely asked is asked: a denial that takes back what was said before it takes back all of it, and a mere
name ("the blue one") never outweighs a denial or a statement beside it.
"""

import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

from contracts.reading import Mood
from vocabulary.folding import Word, joined, words_of
from vocabulary.orders import order_in
from vocabulary.spelling import one_slip

OPENERS = frozenset(("find", "fetch", "bring", "get", "grab", "locate"))
"""With a thing named before it, such a verb begins a clause of its own: speech recognition writes no commas."""
WEIGHT = {
    "quoted": Mood.STATEMENT, "telling": Mood.STATEMENT, "later": Mood.LATER, "condition": Mood.CONDITION,
    "asking": Mood.FIND, "denied": Mood.DENIED, "thanks": Mood.THANKS, "find": Mood.FIND, "count": Mood.COUNT,
    "question": Mood.QUESTION,
}  # fmt: skip
"""Which group of patterns counts, and for what: the first that is found."""
SPLITS = frozenset(("but",))
CARRIERS = ("dont", "never", "find", "forget", "search", "fetch")
"""Words of the mood whose slips are taken for them, where a letter is missing or two are swapped."""
_DOUBLED = re.compile(
    r"\b(?:do not|don['\u2019]?t|never) (?:stop|quit|cease|forget to|give up on|fail to)\b", re.IGNORECASE
)
"""Two denials that make an asking: 'never stop looking'."""
_TORN = re.compile(r"\b(don|can|won|isn|aren|didn|doesn|wasn|couldn|wouldn|shouldn|haven|needn|mustn) t\b")


@dataclass(frozen=True, slots=True)
class Clause:
    text: str
    """As it was written."""
    plain: str
    """Its folded words, without the fillers it begins with."""
    mood: Mood
    asks: bool
    """A word of asking is in it; without one, FIND is a mere name."""
    found: bool = False


@dataclass(frozen=True, slots=True)
class Reading:
    """`asked` is the part that asks for something (all of it where nothing is denied), `about` the rest."""

    mood: Mood
    asked: str
    about: str = ""
    found: bool = False
    """It says that the thing is there already."""
    sure: bool = False
    """A word of asking is in it."""


def read(text: str) -> Reading:
    """The mood of the whole. Of an order with more behind it ('stop and find the cup'), of what is behind it."""
    order = order_in(text)
    if order is not None:
        behind = _weighed(clauses_of(order.rest), order.rest) if order.rest else None
        return (
            behind if behind is not None and behind.mood is Mood.FIND and behind.sure else Reading(order.mood, "", text)
        )
    return _weighed(clauses_of(text), text)


def clauses_of(text: str) -> list[Clause]:
    words = words_of(text)
    if not words:
        return []
    starts = [at for at, word in enumerate(words) if word.opens or _begins(words, at)]
    ends = [*starts[1:], len(words)]
    cut = [words[start:end] for start, end in zip(starts, ends, strict=True)]
    found = [_clause(text, some) for some in cut]
    return [clause for clause in found if clause is not None]


def _begins(words: Sequence[Word], at: int) -> bool:
    word, before = words[at].text, words[at - 1].text if at else ""
    return word in SPLITS or (word in OPENERS and at > 1 and before not in _table().leans_on)


def _clause(text: str, words: Sequence[Word]) -> Clause | None:
    table = _table()
    written = text[words[0].start : words[-1].end]
    at = 0
    while at < len(words) and words[at].text in table.fillers and not _denies(words[at:], table):
        at += 1
    plain = _spelt(joined(words[at:]))
    if not plain:
        bare = joined(words)
        return Clause(written, bare, Mood.DENIED, asks=False) if table.finds("denied", bare) else None
    return Clause(written, plain, *_mood_of(plain, table), found=table.finds("found", plain))


def _denies(words: Sequence[Word], table: "_Table") -> bool:
    return words[0].text == "no" and len(words) > 1 and words[1].text not in table.after_no


def _mood_of(plain: str, table: "_Table") -> tuple[Mood, bool]:
    """The mood, and whether a word of asking is in it."""
    asks = any(f" {word} " in f" {plain} " for word in table.asks)
    name = next((name for name in WEIGHT if table.finds(name, plain)), "")
    if name:
        return WEIGHT[name], asks or WEIGHT[name] is Mood.FIND
    if not asks and table.finds("statement", plain):
        return Mood.STATEMENT, False
    if not asks and table.finds("polite", plain):
        return Mood.UNKNOWN, False
    return Mood.FIND, asks


def _spelt(plain: str) -> str:
    """'don t' of speech recognition, and slips in the words that carry the mood ('nver mind', 'dont fidn')."""
    whole = _TORN.sub(r"\1t", plain)
    return " ".join(next((known for known in CARRIERS if _is_slip(word, known)), word) for word in whole.split())


def _is_slip(word: str, known: str) -> bool:
    swapped = sorted(word) == sorted(known)
    return len(word) >= 3 and word[0] == known[0] and (swapped or len(word) < len(known)) and one_slip(word, known)


def _weighed(clauses: Sequence[Clause], text: str) -> Reading:
    quoted = any(_table().finds("quoted", clause.plain) for clause in clauses)
    if quoted:
        return Reading(Mood.STATEMENT, "", text)
    clauses = _not_taken_back(clauses)
    moods = [clause.mood for clause in clauses]
    about = " ".join(clause.text for clause in clauses if clause.mood is not Mood.FIND)
    found = any(clause.found and clause.mood in {Mood.STATEMENT, Mood.THANKS, Mood.DENIED} for clause in clauses)
    for mood in (Mood.LATER, Mood.CONDITION):
        if mood in moods:
            return Reading(mood, "", text)
    asking = [clause for clause in clauses if clause.mood is Mood.FIND]
    sure = [clause for clause in asking if clause.asks]
    if sure and Mood.DENIED in moods:
        return Reading(Mood.FIND, ", ".join(clause.text for clause in asking), about, found, sure=True)
    if sure or not set(moods) - {Mood.FIND, Mood.UNKNOWN}:
        return Reading(Mood.FIND, _DOUBLED.sub("", text).strip() or text, "", found, sure=bool(sure))
    for mood in (Mood.DENIED, Mood.COUNT, Mood.QUESTION, Mood.THANKS, Mood.STATEMENT):
        if mood in moods:
            return Reading(mood, "", text, found)
    return Reading(Mood.UNKNOWN, "", text)


def _not_taken_back(clauses: Sequence[Clause]) -> Sequence[Clause]:
    """'find my phone... no, forget it': a denial that names nothing takes back what was said before it."""
    last = max(
        (at for at, one in enumerate(clauses) if at and one.mood is Mood.DENIED and _names_nothing(one)), default=None
    )
    return clauses if last is None else clauses[last:]


def _names_nothing(clause: Clause) -> bool:
    return len(clause.plain.split()) <= 2 or clause.plain in {"forget about it", "never mind that", "never mind it"}


@dataclass(frozen=True)
class _Table:
    fillers: frozenset[str]
    asks: tuple[str, ...]
    after_no: frozenset[str]
    leans_on: frozenset[str]
    patterns: Mapping[str, tuple[re.Pattern[str], ...]]

    def finds(self, name: str, plain: str) -> bool:
        return any(pattern.search(plain) for pattern in self.patterns[name])


@cache
def _table() -> _Table:
    table = tomllib.loads(files("vocabulary").joinpath("data/moods.toml").read_text(encoding="utf-8"))
    patterns = {name: tuple(re.compile(one) for one in some) for name, some in table["patterns"].items()}
    words = table["words"]
    return _Table(
        fillers=frozenset(words["fillers"]),
        asks=tuple(words["asks"]),
        after_no=frozenset(words["after_no"]),
        leans_on=frozenset(words["leans_on"].split()),
        patterns=patterns,
    )
