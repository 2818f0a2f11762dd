"""Cuts a command into the parts that each ask for one thing: 'find the red bottle, then the book'. Pure."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from contracts.vision import ParseTaskRequest
from inference.parsing.describing import ONES
from inference.parsing.lexicon import Lexicon, lexicon
from inference.parsing.mentions import ARTICLES, Mention, Role, find_mentions, groups_of, with_roles
from inference.parsing.parser import parse
from vocabulary.folding import Word, plain_words_of

PARTS_MAX = 8
"""What a command may ask for; the rest of a longer list stays unread."""
SEQUENCE = frozenset(("then", "afterwards", "afterward", "later", "finally", "plus", "also"))
"""Between two things these alone make two errands of them."""
LISTING = frozenset(("and", "as", "well", "me", "us", "for", "please", "it", "to", "here", "back", "up"))
"""With articles, attributes and words of asking, what may stand between two things of one list."""


@dataclass(frozen=True, slots=True)
class Part:
    """`said` are the command's own words; `meaning` is what to read, the same but where "the blue one" needs a noun."""

    said: str
    meaning: str


def split(command: str) -> tuple[Part, ...]:
    """At least one part, at most eight; a command that asks for one thing is left whole."""
    words = lexicon()
    tokens = plain_words_of(command)
    mentions = with_roles(tokens, find_mentions(tokens, words), words)
    nouns = _nouns(tokens, mentions, words)
    aside = _aside(tokens, mentions)
    cuts = [_cut(tokens, left, right, aside, words) for left, right in pairwise(nouns)]
    starts = [0, *(cut for cut in cuts if cut is not None)][:PARTS_MAX]
    ends = [*(tokens[start].start for start in starts[1:]), len(command)]
    whole = (Part(command, command),)
    if len(starts) == 1:
        return whole
    parts = [
        _part(command[tokens[start].start if start else 0 : end], tokens, start, nouns)
        for start, end in zip(starts, ends, strict=True)
    ]
    told: dict[tuple[str, str], Part] = {}
    for part in parts:  # "we are one spoon short, find a spoon" asks for one
        read = parse(ParseTaskRequest(command=part.meaning))
        told.setdefault((read.yolo_class, read.description or part.said), part)
    return tuple(told.values()) if len(told) > 1 else whole


def _nouns(tokens: Sequence[Word], mentions: Sequence[Mention], words: Lexicon) -> list[Mention]:
    """What is wanted, in order: named things, and 'the blue one' where a thing was named before it."""
    groups = groups_of(tokens, mentions)
    things = [
        Mention(group[0].start, group[-1].end, group[-1].label, group[-1].said)
        for group in groups
        if group[-1].label != "person" or len(groups) == 1
    ]
    ones = [
        Mention(at, at + 1, "", token.text)
        for at, token in enumerate(tokens)
        if token.text in ONES
        and at > 0
        and words.is_attribute(words.attribute(tokens[at - 1].text))
        and any(thing.end <= at for thing in things)
    ]
    return sorted([*things, *ones], key=lambda one: one.start)


def _aside(tokens: Sequence[Word], mentions: Sequence[Mention]) -> frozenset[int]:
    """The tokens of 'on the table': they may stand between two things of one list."""
    found: set[int] = set()
    for one in mentions:
        if one.role is Role.CONTEXT:
            opening = next((at for at in range(one.start - 1, -1, -1) if tokens[at].text == one.governor), one.start)
            found.update(range(opening, one.end))
    return frozenset(found)


def _cut(tokens: Sequence[Word], left: Mention, right: Mention, aside: frozenset[int], words: Lexicon) -> int | None:
    """The token at which a new part begins, where there is one between these two."""
    between = [at for at in range(left.end, right.start) if at not in aside]
    said = [tokens[at].text for at in between]
    if any(word in words.negations for word in said):
        return None
    in_turn = next((at for at in between if _in_turn(tokens, at)), None)
    if in_turn is not None:
        return in_turn - 1 if in_turn > left.end and tokens[in_turn - 1].text == "and" else in_turn
    listed = all(
        word in LISTING or word in ARTICLES or word in words.requests or words.is_attribute(words.attribute(word))
        for word in said
    )
    stops = [at for at in (*between, right.start) if tokens[at].opens]
    joints = [at for at in between if tokens[at].text == "and"]
    if not listed or not (stops or joints):
        return None
    if right.label == "" and not joints:  # "a cup, the blue one": the same cup
        return None
    return (joints or stops)[0]


def _in_turn(tokens: Sequence[Word], at: int) -> bool:
    following = tokens[at + 1].text if at + 1 < len(tokens) else ""
    match tokens[at].text:
        case "after":
            return following in ("that", "this", "which")
        case "next":
            return following != "to"
        case word:
            return word in SEQUENCE


def _part(said: str, tokens: Sequence[Word], start: int, nouns: Sequence[Mention]) -> Part:
    first = next(one for one in nouns if one.start >= start)
    kept = said.strip().rstrip(",;")
    earlier = [one for one in nouns if one.end <= start and one.label]
    if first.label or not earlier:
        return Part(kept, kept)
    offset = tokens[first.start].start - tokens[start].start
    return Part(kept, kept[:offset] + earlier[-1].said + kept[offset + len(first.said) :])
