"""What people call things: the phrases the small CLIP is taught, and the words it knows."""

import random
from collections.abc import Iterable
from dataclasses import dataclass

from contracts.coco import COCO_LABELS
from contracts.colours import Colour

OTHER_NAMES: dict[str, tuple[str, ...]] = {
    "cup": ("mug", "coffee mug", "coffee cup"),
    "couch": ("sofa",),
    "sports ball": ("ball",),
    "teddy bear": ("teddy", "stuffed bear", "toy bear"),
    "backpack": ("rucksack", "school bag"),
    "tv": ("television", "tv screen"),
    "refrigerator": ("fridge",),
    "dining table": ("table",),
    "potted plant": ("plant", "pot plant"),
    "suitcase": ("luggage",),
    "laptop": ("notebook computer",),
    "vase": ("flower vase",),
    "bowl": ("dish",),
    "bottle": ("flask", "water bottle"),
    "chair": ("seat",),
    "clock": ("alarm clock",),
    "cell phone": ("phone", "mobile phone"),
    "remote": ("remote control",),
    "handbag": ("bag", "purse"),
}
FRAMES: tuple[str, ...] = (
    *("{}", "{}", "{}", "a {}", "the {}", "a photo of a {}", "a picture of the {}", "find the {}", "look for a {}"),
    *("where is the {}", "bring me the {}", "there is a {} here", "a small {}", "a {} on the floor", "my {}"),
)
FILLERS: tuple[str, ...] = ("plastic", "glass", "old", "new", "nice", "big", "little", "round", "that", "this")


@dataclass(frozen=True, order=True)
class Meaning:
    """What a phrase is about: a kind, and a colour or none said."""

    kind: str
    colour: str = ""

    @property
    def plain(self) -> str:
        """The phrase a validator asks with: "red bottle"."""
        return f"{self.colour} {self.kind}".strip()


def compared(meanings: Iterable[Meaning]) -> set[Meaning]:
    """Each kind that comes in colours, in every colour a vote compares it with, whichever it has."""
    return {Meaning(one.kind, colour.value) for one in meanings if one.colour for colour in Colour}


def phrase(meaning: Meaning, draw: random.Random) -> str:
    """One of the many ways to say it; now and then with a word the model does not know."""
    kind = draw.choice((meaning.kind, meaning.kind, *OTHER_NAMES.get(meaning.kind, ())))
    words = [draw.choice(Colour(meaning.colour).spellings), kind] if meaning.colour else [kind]
    if draw.random() < 0.15:
        words.insert(draw.randrange(len(words)), draw.choice((*FILLERS, "qqq")))
    return draw.choice(FRAMES).format(" ".join(words))


def vocabulary() -> tuple[str, ...]:
    """Every word the text tower knows, sorted: fixed, so that a later training can go on from an earlier one."""
    said = [*FRAMES, *FILLERS, *COCO_LABELS, *Colour]
    for names in (*OTHER_NAMES.values(), *(one.spellings for one in Colour)):
        said.extend(names)
    return tuple(sorted({word for text in said for word in text.replace("{}", " ").split()}))
