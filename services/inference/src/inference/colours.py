"""How an image-text model is asked for a colour, and when its answer may be believed."""

import re
from collections.abc import Sequence

from contracts.colours import Colour


def with_colour(description: str, said: Colour, other: str) -> str:
    """The description with its first word for the colour `said` replaced by `other`: a contrast prompt."""
    return re.sub(rf"\b(?:{'|'.join(said.spellings)})\b", other, description.lower(), count=1)


def phrase(template: str, thing: str) -> str:
    """`thing` put into the model's template: 'a photo of {}' gives 'a photo of an orange cup'."""
    if template == "{}":
        return thing
    article = "an" if thing[:1] in "aeiou" else "a"
    return template.format(f"{article} {thing}")


def colour_prompts(template: str, label: str, colours: Sequence[Colour]) -> list[str]:
    """One prompt for each colour."""
    return [phrase(template, f"{colour} {label}") for colour in colours]


def pick_colour(colours: Sequence[Colour], scores: Sequence[float], margin: float) -> Colour | None:
    """The best of `colours` when it leads the next best by at least `margin` (cosine), else none."""
    ranked = sorted(range(len(colours)), key=lambda i: scores[i], reverse=True)
    if len(ranked) < 2 or scores[ranked[0]] - scores[ranked[1]] < margin:
        return None
    return colours[ranked[0]]
