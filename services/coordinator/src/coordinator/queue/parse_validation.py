"""Checks every word a parser claims about a command (requirement A3): nothing a model says is trusted."""

from dataclasses import dataclass
from itertools import pairwise

from contracts.coco import COCO_LABELS
from contracts.colours import COLOUR_WORDS, colour_asked
from contracts.intent import WantedAction
from contracts.mission import SearchedRoom
from contracts.vision import ParsedTarget, Target
from vocabulary.actions import action_in
from vocabulary.folding import joined, plain_words_of
from vocabulary.looks import MATERIALS_AND_COLOURS, colour_meant, normalise
from vocabulary.restrictions import not_colours, restrictions_in

NONE = "none"


@dataclass(frozen=True, slots=True)
class CheckedTask:
    """What may be acted on; `notes` says what was changed."""

    target: Target
    memory_object: str | None
    parser: str
    notes: str
    action: WantedAction
    """What is to be done with it, by the words that ask for it."""
    rooms: tuple[SearchedRoom, ...] = ()
    """It is looked for in these alone; none: in the whole home."""


def check_parse(parsed: ParsedTarget, labels_in_memory: tuple[str, ...]) -> CheckedTask | None:
    """None when it is nothing a detector knows."""
    label = match_class(parsed.yolo_class)
    if label == NONE:
        return None
    notes: list[str] = [parsed.notes] if parsed.notes else []
    if label != parsed.yolo_class:
        notes.append(f"'{parsed.yolo_class}' taken as {label}")
    memory_object = match_memory_object(parsed.memory_object, labels_in_memory)
    if memory_object != parsed.memory_object and memory_object is not None:
        notes.append(f"looking first near: {memory_object}")
    description = check_description(parsed.said, parsed.description, label)
    if words(description) != words(parsed.description):
        notes.append(f"described as '{description}'")
    colour = colour_asked(label, description)
    excluded = tuple(one for one in not_colours(restrictions_in(parsed.said)) if one is not colour)
    target = Target(label=label, description=description, colour=colour, not_colours=excluded)
    return CheckedTask(target, memory_object, parsed.parser, "; ".join(notes), action_in(parsed.said))


def match_class(claimed: str) -> str:
    """Exact, then substring either way, then a shared word, else "none"."""
    text = " ".join(words(claimed))
    if text in COCO_LABELS:
        return text
    if not text or text == NONE:
        return NONE
    for label in COCO_LABELS:
        if text in label or label in text:
            return label
    for label in COCO_LABELS:
        if set(words(text)) & set(words(label)):
            return label
    return NONE


def match_memory_object(claimed: str | None, labels_in_memory: tuple[str, ...]) -> str | None:
    """Exact, then partial, then the first label in memory; none when nothing was claimed or nothing is remembered."""
    text = " ".join(words(claimed or ""))
    if not text or text == NONE or not labels_in_memory:
        return None
    if text in labels_in_memory:
        return text
    partial = next((label for label in labels_in_memory if text in label or label in text), None)
    return partial or labels_in_memory[0]


def check_description(command: str, claimed: str, label: str) -> str:
    """Without colours and materials the user never said, with the one he put before the thing; never empty.

    A colour that was said with a slip of the finger counts as said ("yelow").
    """
    said, own = {normalise(colour_meant(w) or w) for w in words(command)}, set(words(label))
    kept = [w for w in words(claimed) if w in own or w not in MATERIALS_AND_COLOURS or normalise(w) in said]
    if not any(w for w in kept if w not in MATERIALS_AND_COLOURS or w in own):
        kept += words(label)
    colour = _colour_before(command, {*kept, *own})
    if colour is not None and not any(normalise(w) == colour for w in kept):
        kept.insert(0, colour)
    return " ".join(kept)[:120].strip() or label


def words(text: str) -> list[str]:
    return joined(plain_words_of(text)).split()


def _colour_before(command: str, nouns: set[str]) -> str | None:
    said = words(command)
    for word, following in pairwise(said):
        if word in COLOUR_WORDS and following in nouns and word not in nouns:
            return normalise(word)
    return None
