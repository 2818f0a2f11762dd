"""Whether a saying is in another language than English: its small words tell. Pure."""

import tomllib
from functools import cache
from importlib.resources import files

from vocabulary.folding import words_of


def is_foreign(text: str) -> bool:
    """True when more of its small words are another language's than English: 'such den Ball nicht'.

    A loan keeps a saying English: 'where is my Handy'.
    """
    words = [word.text for word in words_of(text)]
    english, foreign = _small_words()
    strange = sum(word in foreign for word in words) + any(not word.isascii() for word in words)
    return strange > sum(word in english for word in words)


@cache
def _small_words() -> tuple[frozenset[str], frozenset[str]]:
    table = tomllib.loads(files("vocabulary").joinpath("data/moods.toml").read_text(encoding="utf-8"))["languages"]
    return frozenset(table["english"].split()), frozenset(table["foreign"].split())
