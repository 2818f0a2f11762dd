"""Requirement A3 for every claim there is: it never raises, and no colour or material nobody said comes through."""

import re
import string

import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from rapidfuzz.distance import OSA

from contracts.coco import COCO_LABELS
from contracts.colours import Colour
from contracts.vision import ParsedTarget
from coordinator.queue.parse_validation import check_description, check_parse
from vocabulary.looks import MATERIALS_AND_COLOURS, NOT_COLOURS, colour_meant

SAME = {"gray": "grey", "violet": "purple", "wood": "wooden", "golden": "gold", "metallic": "metal"}
ATTRIBUTES = {*MATERIALS_AND_COLOURS, *SAME}
WORDS = sorted({*ATTRIBUTES, *(word for label in COCO_LABELS for word in label.split()), "find", "the", "not", "mug"})
sentences = st.lists(st.sampled_from(WORDS), max_size=10).map(" ".join)
texts = st.one_of(sentences, st.text(max_size=60))
claims = st.builds(
    ParsedTarget,
    said=texts.filter(bool),
    yolo_class=st.one_of(st.sampled_from((*COCO_LABELS, "none", "mug", "bottles")), st.text(max_size=64)),
    memory_object=st.one_of(st.none(), st.sampled_from(COCO_LABELS), st.text(max_size=64)),
    description=texts,
    parser=st.just("model"),
)
OTHER_WORDS = sorted({
    *NOT_COLOURS, *(word for label in COCO_LABELS for word in label.split() if word not in ATTRIBUTES), "find", "the",
    "write", "back", "grown", "cold", "sink", "door", "drink", "good", "old", "read", "led", "clue", "glue",
    "crown", "fellow", "hello", "lack", "tray", "play", "great", "people", "range", "orchard", "down", "with", "wait",
    "would", "block", "then", "bring", "thing", "link", "purpose", "tea", "grape", "blow",
})  # fmt: skip


@st.composite
def slips(draw: st.DrawFn) -> tuple[str, str]:
    """A colour, and the same with one letter too many, too few, wrong or swapped with its neighbour; not the first."""
    colour = draw(st.sampled_from([one for one in Colour if len(one) >= 4]))
    at = draw(st.integers(1, len(colour) - 1))
    letter = draw(st.sampled_from(string.ascii_lowercase))
    before, after = colour[:at], colour[at:]
    written = draw(
        st.sampled_from(
            (before + letter + after, before + after[1:], before + letter + after[1:], _swapped(colour, at))
        )
    )
    return colour, written


def _swapped(word: str, at: int) -> str:
    return word[: at - 1] + word[at] + word[at - 1] + word[at + 1 :]


def slip_of(word: str, colour: str) -> bool:
    """What a slip is, told by another's measure of distance."""
    undoubled = [re.sub(r"(.)\1+", r"\1", one) for one in (word, colour)]
    return word not in NOT_COLOURS and (undoubled[0] == undoubled[1] or OSA.distance(word, colour) <= 1)


@given(claims, st.lists(st.sampled_from(COCO_LABELS), max_size=4).map(tuple))
def test_whatever_is_claimed_no_attribute_is_invented(claim: ParsedTarget, memory: tuple[str, ...]) -> None:
    checked = check_parse(claim, memory)
    assume(checked is not None)
    assert checked is not None
    said = {SAME.get(word, word) for word in re.findall("[a-z]+", claim.said.lower())}
    said |= {SAME.get(one, one) for one in (*Colour, *SAME) if any(slip_of(word, one) for word in said)}
    own = set(checked.target.label.split())
    told = {
        SAME.get(word, word) for word in checked.target.description.split() if word in ATTRIBUTES and word not in own
    }
    assert told <= said
    assert checked.target.label in COCO_LABELS
    assert checked.memory_object is None or checked.memory_object in memory
    assert checked.target.colour is None or checked.target.colour in said


def test_a_colour_may_be_claimed_in_its_other_spelling() -> None:
    said = "find the violet umbrella"
    claim = ParsedTarget(said=said, yolo_class="umbrella", description="purple umbrella", parser="rules")
    checked = check_parse(claim, ())
    assert checked is not None
    assert (checked.target.description, checked.target.colour) == ("purple umbrella", "purple")


@given(slips())
@example(("yellow", "yelow"))
@example(("black", "balck"))
@example(("white", "whtie"))
@example(("grey", "garey"))
@example(("red", "redd"))
def test_a_colour_that_was_misspelt_is_kept(slip: tuple[str, str]) -> None:
    colour, written = slip
    assume(written not in {*NOT_COLOURS, *ATTRIBUTES, *COCO_LABELS})
    others = {SAME.get(one, one) for one in (*Colour, *SAME) if slip_of(written, one)}
    assume(others == {colour})
    assert check_description(f"find the {written} cup", f"{colour} cup", "cup") == f"{colour} cup"


@given(st.text(string.ascii_lowercase, max_size=9))
@example("")
@example("grn")
def test_a_word_is_taken_for_a_colour_only_when_it_is_a_slip_of_it(word: str) -> None:
    meant = colour_meant(word)
    assert meant is None or any(slip_of(word, one) for one in (*Colour, *SAME) if SAME.get(one, one) == meant)


@given(st.lists(st.sampled_from(OTHER_WORDS), max_size=8).map(" ".join), st.sampled_from((*Colour, "gray", "violet")))
@example("open the back door, the bottle is there", "black")
@example("write down where the bottle is", "white")
@example("the bottle that the grown ups hid", "brown")
@example("a cold drink in a bottle", "gold")
@example("the bottle by the sink", "pink")
def test_words_of_another_meaning_are_no_colours(command: str, colour: str) -> None:
    assume(not re.search(rf"\b(?:{'|'.join(ATTRIBUTES)})\b", command))
    assert check_description(command, f"{colour} bottle", "bottle") == "bottle"


@pytest.mark.parametrize("word", sorted(word for label in COCO_LABELS for word in label.split()))
def test_no_thing_has_the_name_of_a_misspelt_colour(word: str) -> None:
    assert colour_meant(word) is None
