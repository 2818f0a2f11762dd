"""Checks every word a parser claims about a command (requirement A3): nothing a model says is trusted."""

import re
from dataclasses import dataclass
from itertools import pairwise, takewhile

from contracts.coco import COCO_LABELS, NOT_COLOURS
from contracts.colours import COLOUR_WORDS, colour_asked
from contracts.vision import ParsedTask, Target
from vocabulary.restrictions import not_colours, restrictions_in

NONE = "none"

MATERIALS: frozenset[str] = frozenset({
    "wooden", "wood", "metal", "metallic", "steel", "iron", "plastic", "glass", "ceramic", "porcelain", "leather",
    "paper", "cardboard", "rubber", "stone", "marble", "cotton", "woolen", "silver", "golden", "gold", "copper",
})  # fmt: skip

_COLOUR_WORDS = frozenset({*COLOUR_WORDS, "beige", "turquoise", "magenta", "cyan", "navy", "maroon"})
_SAME: dict[str, str] = {"wood": "wooden", "golden": "gold", "metallic": "metal"} | COLOUR_WORDS


@dataclass(frozen=True, slots=True)
class CheckedTask:
    """What may be acted on; `notes` says what was changed."""

    target: Target
    memory_object: str | None
    notes: str


def check_parse(command: str, parsed: ParsedTask, labels_in_memory: tuple[str, ...]) -> CheckedTask | None:
    """None when the command names nothing a detector knows."""
    label = match_class(parsed.yolo_class)
    if label == NONE:
        return None
    notes: list[str] = [parsed.notes] if parsed.notes else []
    if label != parsed.yolo_class:
        notes.append(f"'{parsed.yolo_class}' taken as {label}")
    memory_object = match_memory_object(parsed.memory_object, labels_in_memory)
    if memory_object != parsed.memory_object and memory_object is not None:
        notes.append(f"looking first near: {memory_object}")
    description = check_description(command, parsed.description, label)
    if words(description) != words(parsed.description):
        notes.append(f"described as '{description}'")
    colour = colour_asked(label, description)
    excluded = tuple(one for one in not_colours(restrictions_in(command)) if one is not colour)
    target = Target(label=label, description=description, colour=colour, not_colours=excluded)
    return CheckedTask(target, memory_object, "; ".join(notes))


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
    said, own = {_plain(colour_meant(w) or w) for w in words(command)}, set(words(label))
    kept = [w for w in words(claimed) if w in own or not _is_attribute(w) or _plain(w) in said]
    if not any(w for w in kept if not _is_attribute(w) or w in own):
        kept += words(label)
    colour = _colour_before(command, {*kept, *own})
    if colour is not None and not any(_plain(w) == colour for w in kept):
        kept.insert(0, colour)
    return " ".join(kept)[:120].strip() or label


def colour_meant(word: str) -> str | None:
    """The one colour that `word` is a slip of: a letter too many, too few, wrong or swapped, or letters doubled.

    None for words of their own ("back", "write") and where two colours are as near. The beginning must be right, and
    colours of three letters are known by doubled ones alone: too many words are a letter away from "red".
    """
    if word in NOT_COLOURS or _is_attribute(word):
        return None
    doubled = {_plain(colour) for colour in COLOUR_WORDS if _undoubled(word) == _undoubled(colour)}
    slips = doubled or {_plain(colour) for colour in COLOUR_WORDS if _is_slip(word, colour)}
    return slips.pop() if len(slips) == 1 else None


def words(text: str) -> list[str]:
    return re.findall(r"[a-z]+", text.lower())


def _is_slip(word: str, colour: str) -> bool:
    if len(colour) < 4 or not (word[:1] == colour[0] or word[:2] == colour[1::-1]):
        return False
    same = sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], zip(word, colour, strict=False)))
    written, meant = word[same:], colour[same:]
    swapped = written[1::-1] + written[2:]
    return meant in (written[1:], swapped) or meant[1:] in (written, written[1:])


def _undoubled(word: str) -> str:
    return re.sub(r"(.)\1+", r"\1", word)


def _is_attribute(word: str) -> bool:
    return word in _COLOUR_WORDS or word in MATERIALS


def _plain(word: str) -> str:
    return _SAME.get(word, word)


def _colour_before(command: str, nouns: set[str]) -> str | None:
    said = words(command)
    for word, following in pairwise(said):
        if word in COLOUR_WORDS and following in nouns and word not in nouns:
            return _plain(word)
    return None
