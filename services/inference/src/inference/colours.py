"""Colour words: which a text names, how a colour is asked for, and when the answer may be believed."""

import re
from collections.abc import Collection, Sequence

from contracts.coco import COLOURS

SPELLINGS = {"gray": "grey", "violet": "purple"}
"""Other spellings people use; each stands for a colour word the system knows."""


def colours_in(text: str) -> tuple[str, ...]:
    """Colour words of `text` in the order said, in the system's spelling, each once."""
    found = (SPELLINGS.get(word, word) for word in re.findall(r"[a-z]+", text.lower()))
    return tuple(dict.fromkeys(word for word in found if word in COLOURS))


def colours_said(description: str, label: str) -> tuple[str, ...]:
    """The colours a description asks for; the fruit 'orange' is not one ('orange' as a label, said once)."""
    words = colours_in(description)
    if label == "orange" and len(re.findall(r"\boranges?\b", description.lower())) < 2:
        return tuple(word for word in words if word != "orange")
    return words


def with_colour(description: str, said: str, other: str) -> str:
    """The description with its first word for the colour `said` replaced by `other`: a contrast prompt."""
    spelled = "|".join(re.escape(word) for word in (said, *(k for k, v in SPELLINGS.items() if v == said)))
    return re.sub(rf"\b(?:{spelled})\b", other, description.lower(), count=1)


def phrase(template: str, thing: str) -> str:
    """`thing` put into the model's template: 'a photo of {}' gives 'a photo of an orange cup'."""
    if template == "{}":
        return thing
    article = "an" if thing[:1] in "aeiou" else "a"
    return template.format(f"{article} {thing}")


def colour_prompts(template: str, label: str, colours: Sequence[str]) -> list[str]:
    """One prompt for each colour."""
    return [phrase(template, f"{colour} {label}") for colour in colours]


def pick_colour(colours: Sequence[str], scores: Sequence[float], margin: float) -> str | None:
    """The best of `colours` when it leads the next best by at least `margin` (cosine), else none."""
    ranked = sorted(range(len(colours)), key=lambda i: scores[i], reverse=True)
    if len(ranked) < 2 or scores[ranked[0]] - scores[ranked[1]] < margin:
        return None
    return colours[ranked[0]]


def agrees(seen: str | None, wanted: Collection[str]) -> bool:
    """A colour not known, or not asked for, does not disagree; of several asked for, each will do."""
    return seen is None or not wanted or seen in wanted
