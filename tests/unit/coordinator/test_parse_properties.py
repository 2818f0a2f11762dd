"""Requirement A3 for every claim there is: it never raises, and no colour or material nobody said comes through."""

import re

from hypothesis import assume, given
from hypothesis import strategies as st

from contracts.coco import COCO_LABELS, COLOURS
from contracts.vision import ParsedTask
from coordinator.parse_validation import MATERIALS, check_parse

SAME = {"gray": "grey", "violet": "purple", "wood": "wooden", "golden": "gold", "metallic": "metal"}
ATTRIBUTES = {*COLOURS, *MATERIALS, *SAME}
WORDS = sorted({*ATTRIBUTES, *(word for label in COCO_LABELS for word in label.split()), "find", "the", "not", "mug"})
sentences = st.lists(st.sampled_from(WORDS), max_size=10).map(" ".join)
texts = st.one_of(sentences, st.text(max_size=60))
claims = st.builds(
    ParsedTask,
    yolo_class=st.one_of(st.sampled_from((*COCO_LABELS, "none", "mug", "bottles")), st.text(max_size=64)),
    memory_object=st.one_of(st.none(), st.sampled_from(COCO_LABELS), st.text(max_size=64)),
    description=texts,
    parser=st.just("model"),
)


@given(texts, claims, st.lists(st.sampled_from(COCO_LABELS), max_size=4).map(tuple))
def test_whatever_is_claimed_no_attribute_is_invented(command: str, claim: ParsedTask, memory: tuple[str, ...]) -> None:
    checked = check_parse(command, claim, memory)
    assume(checked is not None)
    assert checked is not None
    said = {SAME.get(word, word) for word in re.findall("[a-z]+", command.lower())}
    own = set(checked.target.label.split())
    told = {
        SAME.get(word, word) for word in checked.target.description.split() if word in ATTRIBUTES and word not in own
    }
    assert told <= said
    assert checked.target.label in COCO_LABELS
    assert checked.memory_object is None or checked.memory_object in memory
    assert checked.colour is None or checked.colour in said


def test_a_colour_may_be_claimed_in_its_other_spelling() -> None:
    claim = ParsedTask(yolo_class="umbrella", description="purple umbrella", parser="rules")
    checked = check_parse("find the violet umbrella", claim, ())
    assert checked is not None
    assert (checked.target.description, checked.colour) == ("purple umbrella", "purple")
