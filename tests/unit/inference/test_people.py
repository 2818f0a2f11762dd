"""What people say, read by the rules: a table of which half was written before them and never tuned on."""

import pytest

from bench import people
from contracts.reading import Mood
from contracts.vision import ParsedTarget, ParsedTask, ParseTaskRequest
from inference.language.providers import Providers
from inference.parsing.task_parsing import Reader
from inference.ports import Completion, LanguageModel, Prompt
from mesh.clock import SystemClock

NOTHING = (ParsedTarget(said="?", yolo_class="none", parser="rules"),)
TUNED = people.rows("tuned")
HELD_OUT = people.rows("held_out")


def reader(*models: LanguageModel) -> Reader:
    clock = SystemClock()
    before, after = (Providers.of(some, retry_after_s=1.0, clock=clock) for some in (models, ()))
    return Reader(before, after, deadline_s=5.0)


async def read(text: str, *models: LanguageModel) -> ParsedTask:
    return await reader(*models).parse(ParseTaskRequest(command=text))


class Willing:
    """A language model that takes every saying for a wish for a cup, and remembers what it was asked."""

    name = "ollama:willing"

    def __init__(self) -> None:
        self.asked: list[str] = []

    async def complete(self, prompt: Prompt) -> Completion:
        self.asked.append(prompt.question)
        return Completion('{"yolo_class": "cup", "memory_object": "", "description": "cup"}')


@pytest.mark.parametrize("row", TUNED, ids=[row["text"] for row in TUNED])
async def test_a_saying_is_taken_as_it_was_meant(row: people.Row) -> None:
    assert people.faults(row, await read(row["text"])) == set()


async def test_of_sayings_nobody_tuned_it_to_nine_in_ten_are_taken_right() -> None:
    told = people.report([(row, await read(row["text"])) for row in HELD_OUT])
    assert min(told["right"].values()) >= 0.9, told


async def test_nothing_starts_that_was_not_asked_for() -> None:
    every = [(row, await read(row["text"])) for row in (*TUNED, *HELD_OUT)]
    assert [row["text"] for row, task in every if row["mood"] == Mood.DENIED and people.starts(task)] == []
    told = people.report(every)
    assert (told["denied_that_start"], told["denied"] >= 25) == (0, True)


async def test_the_table_is_large_and_half_of_it_is_held_out() -> None:
    assert len(TUNED) + len(HELD_OUT) >= 200
    assert abs(len(TUNED) - len(HELD_OUT)) <= 10
    assert {row["mood"] for row in HELD_OUT} == {mood.value for mood in Mood}


@pytest.mark.parametrize(
    "text",
    [
        "don't find the cup",
        "I already found the cup",
        "thanks for the cup",
        "such die Tasse nicht",
        "stop",
        "find the cup later",
    ],
)
async def test_no_model_is_asked_about_what_asks_for_nothing(text: str) -> None:
    model = Willing()
    task = await read(text, model)
    assert (task.targets, model.asked) == ((), [])


async def test_of_a_half_denied_command_a_model_reads_the_asked_half_alone() -> None:
    model = Willing()
    task = await read("don't find the bottle, find the cup", model)
    assert task.mood is Mood.FIND
    assert ["bottle" in asked for asked in model.asked] == [False]
    assert "don't find the bottle" in task.notes


@pytest.mark.parametrize(
    ("text", "label"),
    [
        ("kırmızı şişeyi bul", "none"), ("xyz bul qwe", "none"), ("find the botle", "bottle"), ("botle", "bottle"),
        ("find the bike lights", "none"), ("find the bike", "bicycle"), ("where is the gato", "cat"),
        ("where is my Handy", "cell phone"),
    ],
)  # fmt: skip
async def test_a_slip_is_mended_among_known_words_alone(text: str, label: str) -> None:
    assert [one.yolo_class for one in (await read(text)).targets or NOTHING] == [label]
