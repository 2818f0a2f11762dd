"""The rule-based parser: a table of commands, and what holds for every text there is."""

import csv
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from contracts.coco import COCO_LABELS, COLOURS
from contracts.vision import ParseTaskRequest
from inference.colours import SPELLINGS
from inference.lexicon import correction, edits, lexicon, singular_forms
from inference.parser import parse

TABLE = Path(__file__).parents[2] / "data" / "commands.csv"
ROWS = list(csv.DictReader(TABLE.read_text(encoding="utf-8").splitlines()))
WORDS = sorted(
    {word for name in lexicon().names for word in name} | set(COLOURS) | {"the", "on", "not", "of", "and", "that", "is"}
)


def read(command: str, *memory: str) -> tuple[str, str | None, str]:
    task = parse(ParseTaskRequest(command=command, labels_in_memory=memory))
    return task.yolo_class, task.memory_object, task.description


@pytest.mark.parametrize("row", ROWS, ids=[row["command"] for row in ROWS])
def test_a_command_is_read_as_a_person_means_it(row: dict[str, str]) -> None:
    label, _, description = read(row["command"])
    assert (label, description) == (row["yolo_class"], row["description"])


def test_the_table_is_large_and_names_only_labels_there_are() -> None:
    assert len(ROWS) >= 60
    assert {row["yolo_class"] for row in ROWS} <= {*COCO_LABELS, "none"}


@pytest.mark.parametrize("label", COCO_LABELS)
def test_every_class_is_understood_by_its_own_name(label: str) -> None:
    assert read(f"find the {label}")[0] == label
    assert read(f"where is the red {label}") == (label, None, f"red {label}")


@pytest.mark.parametrize(
    ("command", "memory", "expected"),
    [
        ("find the mug", ("bottle", "cup"), "cup"),
        ("find the mug", ("bottle", "bed"), "bottle"),
        ("find the mug", ("bed",), None),
        ("find the cup near the laptop", ("cup", "laptop"), "laptop"),
        ("bring me something to drink", ("cup",), "cup"),
        ("bring me something to drink from the fridge", ("cup", "refrigerator"), "refrigerator"),
    ],
)
def test_the_place_to_look_first_is_one_that_memory_knows(
    command: str, memory: tuple[str, ...], expected: str | None
) -> None:
    assert read(command, *memory)[1] == expected


def test_a_need_is_answered_with_what_was_seen_before() -> None:
    assert read("I am thirsty", "cup", "bed") == ("cup", "cup", "cup")


def test_it_says_who_answered_and_what_it_took_for_a_slip() -> None:
    task = parse(ParseTaskRequest(command="find the botle"))
    assert task.parser == "rules"
    assert "'botle' was read as 'bottle'" in task.notes


@given(st.text(min_size=1, max_size=500))
def test_no_text_whatever_makes_it_fail(text: str) -> None:
    task = parse(ParseTaskRequest(command=text))
    assert task.yolo_class in {*COCO_LABELS, "none"}


@given(st.lists(st.sampled_from(WORDS), min_size=1, max_size=12).map(" ".join), st.lists(st.sampled_from(COCO_LABELS)))
def test_no_attribute_is_ever_invented(command: str, memory: list[str]) -> None:
    task = parse(ParseTaskRequest(command=command, labels_in_memory=tuple(memory)))
    said = {SPELLINGS.get(word, word) for word in re.findall("[a-z]+", command)}
    told = task.description.split()
    attributes = (set(COLOURS) | lexicon().attributes) - set(task.yolo_class.split())  # wine glass
    assert {word for word in told if word in attributes} <= said
    assert len(told) <= 5
    assert task.memory_object is None or task.memory_object in memory
    assert (task.yolo_class == "none") == (task.description == "")


@pytest.mark.parametrize(
    ("a", "b", "distance"),
    [("", "abc", 3), ("bottle", "bottle", 0), ("botle", "bottle", 1), ("bottel", "bottle", 1), ("cat", "dog", 3)],
)
def test_edits_count_swaps_as_one(a: str, b: str, distance: int) -> None:
    assert edits(a, b) == edits(b, a) == distance


def test_a_word_as_near_to_two_names_is_left_alone() -> None:
    assert correction("bxttle", ("bottle", "battle")) is None
    assert correction("botlte", ("bottle", "bowl")) == "bottle"
    assert correction("cup", ("cup",)) is None


def test_plurals_are_undone() -> None:
    assert singular_forms("puppies") == ("puppy",)
    assert "bus" in singular_forms("buses")
    assert singular_forms("glass") == ()
