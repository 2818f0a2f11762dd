"""Requirement A3, word by word."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from contracts.coco import COCO_LABELS
from contracts.vision import ParsedTarget, Target
from coordinator.queue.parse_validation import (
    check_description,
    check_parse,
    match_class,
    match_memory_object,
)


@pytest.mark.parametrize(
    ("claimed", "label"),
    [
        ("bottle", "bottle"),
        ("Bottle", "bottle"),
        ("bottles", "bottle"),
        ("phone", "cell phone"),
        ("ball", "sports ball"),
        ("teddy", "teddy bear"),
        ("wine bottle glass", "bottle"),
        ("television tv", "tv"),
        ("dining chair set", "chair"),
        ("a potted fern", "potted plant"),
        ("none", "none"),
        ("", "none"),
        ("spaceship", "none"),
        ("42", "none"),
    ],
)
def test_a_class_is_matched_exactly_then_partly_then_by_a_word(claimed: str, label: str) -> None:
    assert match_class(claimed) == label


@given(st.text(max_size=40))
def test_a_class_is_always_a_known_label_or_none(claimed: str) -> None:
    assert match_class(claimed) in {*COCO_LABELS, "none"}


@pytest.mark.parametrize("label", COCO_LABELS)
def test_every_known_label_matches_itself(label: str) -> None:
    assert match_class(label) == label


@pytest.mark.parametrize(
    ("claimed", "labels", "expected"),
    [
        ("bottle", ("cup", "bottle"), "bottle"),
        ("wine", ("cup", "wine glass"), "wine glass"),
        ("spoon", ("cup", "bottle"), "cup"),
        ("spoon", (), None),
        (None, ("cup",), None),
        ("none", ("cup",), None),
    ],
)
def test_a_memory_object_is_exact_then_partial_then_the_first_in_memory(
    claimed: str | None, labels: tuple[str, ...], expected: str | None
) -> None:
    assert match_memory_object(claimed, labels) == expected


@pytest.mark.parametrize(
    ("command", "claimed", "label", "expected"),
    [
        ("find the red bottle", "red bottle", "bottle", "red bottle"),
        ("find the bottle", "blue plastic bottle", "bottle", "bottle"),
        ("find the bottle", "tall bottle", "bottle", "tall bottle"),
        ("find my wooden chair", "brown wooden chair", "chair", "wooden chair"),
        ("find the gray cup", "grey cup", "cup", "grey cup"),
        ("find the red bottle", "bottle", "bottle", "red bottle"),
        ("find the bottle", "red", "bottle", "bottle"),
        ("find the bottle", "", "bottle", "bottle"),
        ("get an orange", "orange", "orange", "orange"),
        ("get a wine glass", "wine glass", "wine glass", "wine glass"),
        ("the book beside the red bottle", "book", "book", "book"),
    ],
)
def test_colours_and_materials_nobody_said_are_stripped(command: str, claimed: str, label: str, expected: str) -> None:
    assert check_description(command, claimed, label) == expected


@given(st.text(max_size=60), st.text(max_size=60), st.sampled_from(COCO_LABELS))
def test_a_description_is_never_empty_nor_too_long(command: str, claimed: str, label: str) -> None:
    assert 1 <= len(check_description(command, claimed, label)) <= 120


def test_a_command_that_names_nothing_known_is_refused() -> None:
    parsed = ParsedTarget(said="sing a song", yolo_class="none", parser="rules")
    assert check_parse(parsed, ("bottle",)) is None


def test_what_was_changed_is_noted() -> None:
    claim = {"said": "find my mug", "yolo_class": "mug cup", "memory_object": "bottles", "description": "white mug"}
    task = check_parse(ParsedTarget(**claim, parser="rules"), ("cup", "bottle"))
    assert task is not None
    assert task.target == Target(label="cup", description="mug")
    assert task.memory_object == "bottle"
    assert "taken as cup" in task.notes
