"""The words that tell the right one of its kind: colours, materials and sizes said of a thing, and no others. Pure."""

from collections.abc import Sequence

from contracts.colours import COLOUR_WORDS
from inference.parsing.lexicon import Lexicon
from inference.parsing.mentions import ARTICLES, Mention, Role
from vocabulary.folding import Word

DESCRIPTION_WORDS_MAX = 4
LOOK_AHEAD = 8
"""Words behind a thing in which its colour may still come."""
LINKS = frozenset(("and", "coloured", "colored"))
COPULAS = frozenset(("is", "are", "be", "made", "thats", "its", "was"))
ONES = frozenset(("one", "ones"))


def description_of(
    tokens: Sequence[Word], group: Sequence[Mention], mentions: Sequence[Mention], words: Lexicon
) -> str:
    """At most four words in the order said: attributes, the names before the last, the last."""
    head = group[-1]
    first = group[0].start
    said, start = _before(tokens, first, words)
    beside = [one.said for one in group[:-1] if one.label != "person" and _is_literal(tokens, one)]
    modifier = [] if beside else _modifier(tokens, first, start, words)
    if modifier:
        said, _ = _before(tokens, first - 1, words)
    if not any(word in words.colours for word in said):
        said = [*_after(tokens, head, mentions, words), *said]
    spelled = dict.fromkeys(COLOUR_WORDS.get(word, word) for word in " ".join([*said, *modifier, *beside]).split())
    room = max(1, DESCRIPTION_WORDS_MAX - len(head.said.split()))
    return " ".join([*list(spelled)[-room:], head.said])


def _is_literal(tokens: Sequence[Word], one: Mention) -> bool:
    """Said in these very words, no translation of them, and not as an owner: "the cat's bowl"."""
    literal = "".join(token.text for token in tokens[one.start : one.end])
    return not tokens[one.end - 1].owner and all(word in literal for word in one.said.split())


def _before(tokens: Sequence[Word], end: int, words: Lexicon) -> tuple[list[str], int]:
    """Attributes directly before token `end`, and where they begin."""
    said: list[str] = []
    at = end - 1
    while at >= 0:
        word = words.attribute(tokens[at].text)
        if words.is_attribute(word):
            said.insert(0, word)
        elif word not in LINKS or not said:
            break
        at -= 1
    return said, at + 1


def _modifier(tokens: Sequence[Word], first: int, start: int, words: Lexicon) -> list[str]:
    """An unknown word between article and thing: 'the swivel chair', 'my electric toothbrush'."""
    if start != first or first < 2 or tokens[first].opens or tokens[first - 1].opens:
        return []
    word = tokens[first - 1]
    before = tokens[first - 2].text
    unknown = not (words.is_plain(word.text) or word.owner or word.text in words.vocabulary)
    return [word.text] if unknown and (before in ARTICLES or words.is_attribute(words.attribute(before))) else []


def _after(tokens: Sequence[Word], head: Mention, mentions: Sequence[Mention], words: Lexicon) -> list[str]:
    """'the bottle that is red', 'a cup, the blue one', 'a cup that is both small and white'."""
    named = {
        at
        for one in mentions
        for at in range(one.start, one.end)
        if one is not head and not words.is_attribute(tokens[at].text)
    }
    said: list[str] = []
    copula = False
    for at in range(head.end, min(len(tokens), head.end + LOOK_AHEAD)):
        word = words.attribute(tokens[at].text)
        if words.is_attribute(word) and (copula or word in words.colours):
            said.append(word)
        elif (said and word not in LINKS) or at in named or word not in words.afterwords:
            describes_another = bool(said) and not tokens[at].opens and _is_noun(tokens[at].text, words)
            return [] if at in named or describes_another else said
        copula = copula or word in COPULAS
    return said


def _is_noun(word: str, words: Lexicon) -> bool:
    return word not in ONES and not words.is_plain(word) and word not in words.afterwords


def colour_of_the_other(
    tokens: Sequence[Word], mentions: Sequence[Mention], words: Lexicon
) -> tuple[Mention, list[str]] | None:
    """'not the red bottle but the green one': the thing 'one' stands for, and what it is like."""
    for at, token in enumerate(tokens):
        if token.text not in ONES:
            continue
        said, start = _before(tokens, at, words)
        if not said or _denied(tokens, start, words):
            continue
        earlier = [one for one in mentions if one.end <= start]
        meant = earlier[-1] if earlier else next((one for one in mentions if one.start > at), None)
        if meant is not None and (meant.role is not Role.CONTEXT):
            return meant, said
    return None


def _denied(tokens: Sequence[Word], start: int, words: Lexicon) -> bool:
    before = [token.text for token in tokens[max(0, start - 2) : start]]
    if any(word in words.negations for word in before):
        return True
    return "but" in before and any(token.text in ("any", "anything", "all", "every") for token in tokens[:start])
