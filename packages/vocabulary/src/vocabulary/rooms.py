"""Rooms by their names. No map names its rooms: a room is what lies near the things that make it one. Pure."""

from vocabulary.folding import joined, plain_words_of

ROOMS: dict[str, tuple[str, ...]] = {
    "kitchen": ("oven", "refrigerator", "sink", "microwave", "toaster"),
    "bathroom": ("toilet", "toothbrush", "hair drier"),
    "bedroom": ("bed",),
    "living room": ("couch", "tv"),
    "dining room": ("dining table",),
    "office": ("laptop", "keyboard", "mouse"),
}
"""Its COCO classes, the surest first."""


def room_in(text: str) -> str | None:
    """The first that is named; None where none is."""
    said = joined(plain_words_of(text))
    return next((room for room in ROOMS if room in said), None)
