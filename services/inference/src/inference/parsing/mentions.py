"""Finds the things a command names, and tells what is wanted from what is only spoken of. Pure."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

from inference.parsing.lexicon import Lexicon
from vocabulary.folding import Word
from vocabulary.labels import Name
from vocabulary.spelling import singular_forms

NONE = "none"
TORN_MIN = 6
"""Letters of a name that is looked for in two misspelt words."""
ARTICLES = frozenset((
    "the", "a", "an", "my", "our", "your", "this", "that", "his", "her", "their", "of", "any", "some", "da", "teh",
    "one", "two", "three", "both", "all", "every", "another", "other", "these", "those", "its",
))  # fmt: skip
PARTS = frozenset(("front", "top", "side", "middle", "corner", "edge", "left", "right", "back"))
"""'in front of the tv', 'on top of the table'."""
JOINTS = frozenset(("and", "or", "nor"))
CLAUSE_STARTS = frozenset(("and", "but", "then", "so", "because", "while"))
UNCERTAIN = frozenset(("something", "anything", "somewhere", "someplace"))
"""'something to carry my books in': what follows is what it is for."""
WHATEVER = frozenset(("any", "anything", "all", "every", "everything"))
"""Before 'but': 'any cup but the red one'."""
AFTER_VERBS = frozenset(("a", "an", "the", "my", "me", "us", "your", "with"))
"""'book a flight', 'bear with me': no thing at the start of a sentence is followed by these."""


class Role(StrEnum):
    """Why a thing is named."""

    WANTED = "wanted"
    CONTEXT = "context"
    """Says where, or what for: 'on the table'."""
    NEGATED = "negated"
    """'not the cup'."""


@dataclass(frozen=True, slots=True)
class Mention:
    """A name found in the command: tokens `start` to `end` (exclusive)."""

    start: int
    end: int
    label: str
    said: str
    corrected: bool = False
    role: Role = Role.WANTED
    governor: str = ""
    """The word it depends on."""


def find_mentions(tokens: Sequence[Word], words: Lexicon) -> list[Mention]:
    """Names from left to right, the longest at each place, none overlapping; the roles are not yet told."""
    forms = [words.forms(token.text) for token in tokens]
    found: list[Mention] = []
    at = 0
    while at < len(tokens):
        mention = _longest_at(tokens, forms, at, words)
        if mention is None or _is_no_thing(tokens, mention, words):
            at += 1
        else:
            found.append(mention)
            at = mention.end
    return found


def _longest_at(tokens: Sequence[Word], forms: Sequence[tuple[str, ...]], at: int, words: Lexicon) -> Mention | None:
    for length in range(min(words.longest, len(tokens) - at), 0, -1):
        if any(token.opens for token in tokens[at + 1 : at + length]):
            continue
        for said in _readings(forms[at : at + length]):
            name = words.names.get(said)
            if name is not None and not (name.foreign and not _introduced(tokens, at, words)):
                literal = [token.text for token in tokens[at : at + length]]
                plural = all(a == b or b in singular_forms(a) for a, b in zip(literal, said, strict=True))
                return Mention(at, at + length, name.label, name.shown, corrected=not plural)
        if length == 2:
            torn = _torn_apart(tokens[at].text, tokens[at + 1].text, words)
            if torn is not None:
                return Mention(at, at + length, torn.label, torn.shown, corrected=True)
    return None


def _torn_apart(first: str, second: str, words: Lexicon) -> Name | None:
    """'suit case', 'bak pack': one name written as two words."""
    joined = first + second
    literal = words.names.get((joined,))
    if literal is not None and not literal.foreign and literal.label != NONE:
        return literal
    known = [words.is_plain(word) or word in words.vocabulary for word in (first, second)]
    if any(known) or len(joined) < TORN_MIN:
        return None
    read = (words.names.get((form,)) for form in words.forms(joined))
    return next((name for name in read if name is not None and name.label != NONE and not name.foreign), None)


def _readings(forms: Sequence[tuple[str, ...]]) -> list[tuple[str, ...]]:
    """Each way to read a run of words, at most 16, the literal one first."""
    runs: list[tuple[str, ...]] = [()]
    for options in forms:
        runs = [(*run, option) for run in runs for option in options][:16]
    return runs


def _introduced(tokens: Sequence[Word], at: int, words: Lexicon) -> bool:
    """A foreign word is taken for a thing only where one is due: 'my Handy', not 'that would be handy'."""
    if at == 0:
        return len(tokens) == 1
    before = tokens[at - 1].text
    return before in ARTICLES or before in words.requests or words.is_attribute(before) or before in ("me", "us")


def _is_no_thing(tokens: Sequence[Word], one: Mention, words: Lexicon) -> bool:
    """A verb ('book a flight'), a colour or material before another word ('the orange cup'), 'can you'."""
    if one.end - one.start != 1 or one.corrected:
        return False
    word = tokens[one.start].text
    following = tokens[one.end] if one.end < len(tokens) else None
    opens = all(token.text in words.fillers for token in tokens[: one.start]) or tokens[one.start].opens
    no_article = one.start == 0 or tokens[one.start - 1].text not in ARTICLES
    if opens and no_article and following is not None and not following.opens and following.text in AFTER_VERBS:
        return True
    if word == "can":
        return following is None or following.text in words.fillers
    if not words.is_attribute(word) or following is None or following.text in words.fillers or following.opens:
        return False
    return words.is_attribute(following.text) or any(form in words.vocabulary for form in words.forms(following.text))


def with_roles(tokens: Sequence[Word], mentions: Sequence[Mention], words: Lexicon) -> list[Mention]:
    """The same mentions, each with its role."""
    told: list[Mention] = []
    for one in mentions:
        role, governor = _role(tokens, one, told, words)
        told.append(replace(one, role=role, governor=governor))
    return [_where(tokens, one, told[at + 1 :], words) for at, one in enumerate(told)]


def _role(tokens: Sequence[Word], one: Mention, earlier: Sequence[Mention], words: Lexicon) -> tuple[Role, str]:
    """Walks left over articles and attributes to the word that governs the mention, and on to a negation of it."""
    if _is_purpose(tokens, one):
        return Role.CONTEXT, "something"
    beside = next((other for other in earlier if other.end == one.start and not tokens[one.start].opens), None)
    if beside is not None:  # 'coffee table': one thing of two names
        return beside.role, beside.governor
    at, denying = one.start - 1, False
    while at >= 0 and not (tokens[at + 1].opens and not words.is_attribute(tokens[at + 1].text)):
        word = tokens[at].text
        told = _said_by(tokens, at, earlier, words)
        if told is not None and (told is not Role.CONTEXT or not denying):
            return told, word
        joined = next((other for other in earlier if other.end == at), None) if word in JOINTS else None
        if joined is not None:
            return (joined.role, joined.governor) if _shares(joined, word) else (Role.WANTED, "")
        denying = denying or word in words.denied
        if word not in words.denied and (denying or not _is_transparent(word, words)):
            return Role.WANTED, word
        at -= 1
    return Role.WANTED, ""


def _said_by(tokens: Sequence[Word], at: int, earlier: Sequence[Mention], words: Lexicon) -> Role | None:
    """What the word at `at` makes of the thing behind it, where it makes anything of it."""
    word = tokens[at].text
    if any(other.start <= at < other.end for other in earlier):
        return None
    denies = word in words.negations or (word == "but" and any(token.text in WHATEVER for token in tokens[:at]))
    if denies or (word == "about" and at > 0 and tokens[at - 1].text in words.negations):
        return Role.NEGATED
    return Role.CONTEXT if word in words.places and word not in ARTICLES else None


def _is_transparent(word: str, words: Lexicon) -> bool:
    return word in ARTICLES or words.is_attribute(word) or word in PARTS


def _is_purpose(tokens: Sequence[Word], one: Mention) -> bool:
    for at in range(one.start - 1, -1, -1):
        if tokens[at + 1].opens:
            return False
        if tokens[at].text in UNCERTAIN and "to" in [token.text for token in tokens[at + 1 : one.start]]:
            return True
    return False


def _shares(joined: Mention, joint: str) -> bool:
    """'between the couch and the tv', 'not the cup or the bottle'."""
    return joined.governor in ("between", "neither") or (joined.role is Role.NEGATED and joint in ("or", "nor"))


def _where(tokens: Sequence[Word], one: Mention, later: Sequence[Mention], words: Lexicon) -> Mention:
    """'check the fridge for an apple': the fridge is where to look."""
    if one.governor not in words.searched:
        return one
    sought = next((other for other in later if other.role is Role.WANTED), None)
    if sought is None or "for" not in [token.text for token in tokens[one.end : sought.start]]:
        return one
    return replace(one, role=Role.CONTEXT)


def groups_of(tokens: Sequence[Word], mentions: Sequence[Mention]) -> list[list[Mention]]:
    """What is wanted, names that stand side by side together: 'dog bowl' is a bowl."""
    groups: list[list[Mention]] = []
    for one in mentions:
        if one.role is not Role.WANTED:
            continue
        if groups and groups[-1][-1].end == one.start and not tokens[one.start].opens:
            groups[-1].append(one)
        else:
            groups.append([one])
    return groups


def is_asked(tokens: Sequence[Word], one: Mention, words: Lexicon) -> bool:
    """Whether a word of asking stands before it in its clause: 'I have a fork, I *need* a knife'."""
    for at in range(one.start - 1, -1, -1):
        if tokens[at].text in words.requests:
            return True
        if tokens[at + 1].opens or tokens[at].text in CLAUSE_STARTS:
            return False
    return False
