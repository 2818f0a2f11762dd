"""What answers a need that is said without a name: 'I am thirsty'. Pure."""

from collections.abc import Sequence

from inference.parsing.lexicon import Pattern
from vocabulary.folding import Word

GAP_MAX = 3
"""Words a '*' may stand for."""


def find_need(
    tokens: Sequence[Word],
    patterns: Sequence[tuple[Pattern, tuple[str, ...]]],
    labels_in_memory: Sequence[str],
) -> str | None:
    """The label that answers the longest pattern said; of several labels, the first that was seen before."""
    said = [token.text for token in tokens]
    for pattern, labels in patterns:
        if any(_matches(said, at, pattern) for at in range(len(said))):
            return next((label for label in labels if label in labels_in_memory), labels[0])
    return None


def _matches(said: Sequence[str], at: int, pattern: Pattern) -> bool:
    if not pattern:
        return True
    if pattern[0] == "*":
        return any(_matches(said, at + gap, pattern[1:]) for gap in range(GAP_MAX + 1))
    return at < len(said) and said[at] == pattern[0] and _matches(said, at + 1, pattern[1:])
