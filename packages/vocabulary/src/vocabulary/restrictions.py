"""What narrows a thing down: 'not the blue one', "the dog's", 'on the table', 'two', 'another'. Pure.

Read from the words alone, so that a person can be told which of them was not understood or is not held to.
"""

import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

from contracts.colours import COLOUR_WORDS, Colour
from contracts.reading import Restriction, RestrictionKind
from vocabulary.folding import Word, joined, words_of

VALUED = (RestrictionKind.NOT_COLOUR, RestrictionKind.ANY)
"""Read first; their words count for nothing else."""
PLAIN = (
    RestrictionKind.NOT_PLACE, RestrictionKind.WHICH, RestrictionKind.OTHER, RestrictionKind.DETAIL,
    RestrictionKind.OWNER, RestrictionKind.PLACE,
)  # fmt: skip


@dataclass(frozen=True)
class _Table:
    patterns: Mapping[RestrictionKind, tuple[re.Pattern[str], ...]]
    number: re.Pattern[str]
    numbers: Mapping[str, str]
    no_owners: frozenset[str]


def restrictions_in(text: str) -> tuple[Restriction, ...]:
    """Each kind once, colours one by one; numbers and colours with their value."""
    table, words = _table(), words_of(text)
    left = joined(words)
    found: list[Restriction] = []
    for kind in VALUED:
        for match in _matches(table.patterns[kind], left):
            found += [Restriction(kind=kind, said=match.group()[:120], value=one) for one in _colours(match.group())]
            left = left.replace(match.group(), " , ", 1)
    number = table.number.search(left)
    if number is not None:
        found.append(Restriction(kind=RestrictionKind.NUMBER, said=number.group().strip(), value=_value(number, table)))
    for kind in PLAIN:
        match = next(_matches(table.patterns[kind], left), None)
        said = match.group().strip() if match is not None else _owner(words) if kind is RestrictionKind.OWNER else ""
        if said:
            found.append(Restriction(kind=kind, said=said[:120]))
            left = left.replace(said, ",", 1)
    return tuple(dict.fromkeys(found))[:24]


def not_colours(restrictions: Sequence[Restriction]) -> tuple[Colour, ...]:
    """The colours that the thing must not have."""
    return tuple(dict.fromkeys(Colour(one.value) for one in restrictions if one.kind is RestrictionKind.NOT_COLOUR))


def _matches(patterns: Sequence[re.Pattern[str]], plain: str) -> Iterator[re.Match[str]]:
    for pattern in patterns:
        yield from pattern.finditer(plain)


def _colours(said: str) -> list[str]:
    return [COLOUR_WORDS[word].value for word in said.split() if word in COLOUR_WORDS]


def _owner(words: Sequence[Word]) -> str:
    """Said with an apostrophe, and something behind it."""
    none = _table().no_owners
    return next((f"{one.text[:-1]}'s" for one in words[:-1] if one.owner and one.text not in none), "")


def _value(number: re.Match[str], table: _Table) -> str:
    kind, said = number.lastgroup, number.group().strip()
    return {"pair": "2", "some": "several", "all": "all"}.get(kind or "", table.numbers.get(said, said))


@cache
def _table() -> _Table:
    table = tomllib.loads(files("vocabulary").joinpath("data/restrictions.toml").read_text(encoding="utf-8"))
    words: dict[str, str] = table["words"] | {"colours": "|".join(COLOUR_WORDS)}

    def compiled(pattern: str) -> re.Pattern[str]:
        for name, meaning in words.items():
            pattern = pattern.replace(f"<{name}>", meaning)
        return re.compile(pattern)

    kinds = {RestrictionKind(name): tuple(map(compiled, some)) for name, some in table["patterns"].items()}
    said = "|".join(sorted(table["numbers"], key=len, reverse=True))
    number = compiled(
        rf"\b(?P<pair>(?:a )?pair of) (?!<pairs>)|\b(?P<word>{said})\b(?! <times>\b)|\b(?P<some>a few|some(?= \w+s\b)"
        r"|(?<!how )many(?= \w+s\b))\b(?! <times>\b)|\b(?P<all>all)(?: of)? (?=(?:the|my|our|these|those) \w|\w+s\b)"
        r"|\b(?P<digits>\d{1,3}) (?!<times>\b)(?=[a-z])"
    )
    return _Table(kinds, number, table["numbers"], frozenset(words["no_owners"].split()))
