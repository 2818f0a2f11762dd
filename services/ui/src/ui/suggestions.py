"""What the command box offers: what memory holds first, then every class the detector knows. Pure."""

from typing import Final

from contracts.coco import COCO_LABELS
from contracts.reading import Mood
from ui.latest_facts import Remembered
from vocabulary.moods import read

NEVER_OFFERED: Final = frozenset({"person"})
OFFERED_MAX: Final = 120


def suggestions(remembered: Remembered) -> tuple[str, ...]:
    """Commands as a person would type them, each once."""
    things = [one.description for one in sorted(remembered.objects, key=lambda one: (-one.belief, one.description))]
    coloured = [f"{view.colour} {view.label}" for view in remembered.views if view.colour]
    labels = [count.label for count in remembered.labels]
    known = [label for label in COCO_LABELS if label not in NEVER_OFFERED]
    return tuple(dict.fromkeys(f"find the {what}" for what in (*things, *coloured, *labels, *known)))[:OFFERED_MAX]


def is_question(text: str) -> bool:
    """Asked rather than ordered: by its mark, or by its words ('how many bottles have you seen')."""
    return text.rstrip().endswith("?") or read(text).mood in {Mood.QUESTION, Mood.COUNT}
