"""Any form of an answer is read; its content is taken as it is, or not at all."""

import contextlib
import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from inference.language.answers import WrongAnswerError, read
from inference.language.prompts import Answer, PresenceAnswer, ReasonAnswer, TaskAnswer
from inference.ports import Completion, Ending

CUP = TaskAnswer(yolo_class="cup", description="blue cup")
FIELDS = {"yolo_class": "cup", "description": "blue cup"}
JSON = json.dumps(FIELDS)
BOTTLE = JSON.replace("cup", "bottle")


@pytest.mark.parametrize(
    "text",
    [
        JSON,
        f"```\n{JSON}\n```",
        f"The braces {{}} of {{a cup}}: {JSON} {{",
        f"{JSON}\n\nOnce more: {JSON}",
        f"<think>{BOTTLE}</think>{JSON}",
        f"<THINKING>{BOTTLE}</THINKING>{JSON}",
        f"[THINK]{BOTTLE}[/THINK]{JSON}",
        f"so, {BOTTLE}? No.</think>{JSON}",
        f"{JSON}<think>and what if",
        f"\ufeff{JSON}",
        JSON.replace('"', "\u201d"),
        json.dumps({"YOLO_Class": " CUP ", "memory_object": None, "description": "blue cup", "sure": [1, {"a": {}}]}),
        json.dumps([[FIELDS]]),
        json.dumps({"answer": FIELDS}),
        json.dumps({"name": "answer", "arguments": FIELDS}),
        json.dumps({"name": "answer", "parameters": JSON}),
        f"<tool_call>{json.dumps({'type': 'function', 'function': {'name': 'a', 'arguments': FIELDS}})}</tool_call>",
    ],
)
def test_the_form_does_not_matter(text: str) -> None:
    assert read(Completion(text), TaskAnswer) == CUP


@pytest.mark.parametrize(
    ("said", "why"),
    [
        (Completion(""), "its answer was empty"),
        (Completion("", "Hm", Ending.CUT_OFF), "it thought aloud and gave no answer, its tokens were used up"),
        (Completion("", f"Perhaps {JSON}"), "it thought aloud and gave no answer"),
        (Completion(f"<think>{JSON}"), "it thought aloud and gave no answer"),
        (Completion(JSON[:-1] + "\n" * 400, ending=Ending.CUT_OFF), "its answer was cut off"),
        (Completion("A cup."), "no JSON in its answer: 'A cup.'"),
        (Completion("x" * 500), "…'"),
        (Completion("I will not", ending=Ending.REFUSED), "it refused: 'I will not'"),
        (Completion(f"{JSON} or {BOTTLE}"), "gave several answers that differ"),
        (Completion(f"[{JSON}, {BOTTLE}]"), "gave several answers that differ"),
        (Completion('{"class": "cup"}'), "yolo_class: Field required"),
        (Completion('{"yolo_class": ["cup"]}'), "yolo_class: Input should be a valid string"),
        (Completion('{"a":' * 5000), "no JSON in its answer"),
    ],
)
def test_what_is_wrong_is_told(said: Completion, why: str) -> None:
    with pytest.raises(WrongAnswerError) as raised:
        read(said, TaskAnswer)
    assert why in str(raised.value)


def test_thoughts_that_are_the_answer_and_nothing_else_are_the_answer() -> None:
    assert read(Completion("", JSON), TaskAnswer) == CUP


@pytest.mark.parametrize("nothing", ["null", '""', '"None"'])
def test_no_class_is_none(nothing: str) -> None:
    assert read(Completion(f'{{"yolo_class": {nothing}}}'), TaskAnswer).yolo_class == "none"


@pytest.mark.parametrize(
    ("text", "present"),
    [
        ("yes", "yes"),
        ("**No.**", "no"),
        ("PRESENT: yes", "yes"),
        ("**PRESENT:** no\nThe shelf is empty.", "no"),
        ("I look closely.\nPresent: **Yes**.", "yes"),
        ('```json\n{"Present": "Yes."}\n```', "yes"),
        ('{"present": false}', "no"),
    ],
)
def test_yes_and_no_are_understood_plainly(text: str, present: str) -> None:
    assert read(Completion(text), PresenceAnswer).present == present


@pytest.mark.parametrize(
    "text",
    [
        "PRESENT: yes or no.",
        "PRESENT: yes\nPRESENT: no",
        "PRESENT: yes, drive on",
        "Yes, and drive on",
        "yes\nno",
        "There is a bottle.",
        "present",
        '{"present": "maybe"}',
        '{"present": null}',
        '{"present": 1}',
        '{"present": "yes or no"}',
        '{"present": "no"} Or rather: {"present": "yes"}',
        '{"answer": "yes"} PRESENT: yes',
        "<think>PRESENT: yes",
    ],
)
def test_what_is_neither_yes_nor_no_is_no_answer(text: str) -> None:
    with pytest.raises(WrongAnswerError):
        read(Completion(text), PresenceAnswer)


SAID = st.builds(Completion, st.text(max_size=200), st.text(max_size=200), st.sampled_from(Ending))


@given(SAID, st.sampled_from((TaskAnswer, PresenceAnswer, ReasonAnswer)))
def test_whatever_is_said_there_is_an_answer_or_a_reason(said: Completion, kind: type[Answer]) -> None:
    with contextlib.suppress(WrongAnswerError):
        assert isinstance(read(said, kind), kind)


PROSE = st.text(st.characters(exclude_characters="{}<[\u201d\u201c"), max_size=60)


@given(PROSE, PROSE, st.text(st.characters(exclude_categories=("C", "Z")), min_size=1, max_size=100))
def test_prose_round_an_answer_changes_nothing(before: str, after: str, answer: str) -> None:
    said = json.dumps({"answer": answer}, ensure_ascii=False)
    assert read(Completion(f"{before}{said}{after}"), ReasonAnswer).answer == answer
