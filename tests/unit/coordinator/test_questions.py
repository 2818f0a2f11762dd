"""What a question is about."""

import pytest

from contracts.asking import About
from coordinator.questions.parsed_question import ParsedQuestion, parse_question
from vocabulary.labels import label_in


@pytest.mark.parametrize(
    ("question", "asked"),
    [
        ("Where did you last see my mug?", ParsedQuestion(About.LAST_SEEN, "cup")),
        ("where are the red bottles", ParsedQuestion(About.LAST_SEEN, "bottle", "red")),
        ("Have you seen my phone?", ParsedQuestion(About.LAST_SEEN, "cell phone")),
        ("Where did you last see my keys?", ParsedQuestion(About.LAST_SEEN)),
        ("when did you see the teddy bear", ParsedQuestion(About.LAST_SEEN, "teddy bear")),
        ("What is in the kitchen?", ParsedQuestion(About.CONTENTS, room="kitchen")),
        ("what do you remember", ParsedQuestion(About.CONTENTS)),
        ("What are you doing?", ParsedQuestion(About.DOING)),
        ("did you find the cup", ParsedQuestion(About.HISTORY, "cup")),
        ("How full is the battery?", ParsedQuestion(About.BATTERY)),
        ("What did you discover?", ParsedQuestion(About.DISCOVERIES)),
        ("what have you explored so far", ParsedQuestion(About.DISCOVERIES)),
        ("sing a song", ParsedQuestion(About.UNKNOWN)),
        ("", ParsedQuestion(About.UNKNOWN)),
        ("where is the orange", ParsedQuestion(About.LAST_SEEN, "orange")),
    ],
)
def test_a_question_is_read_by_its_words(question: str, asked: ParsedQuestion) -> None:
    assert parse_question(question) == asked


@pytest.mark.parametrize(
    ("text", "label"),
    [
        ("two wine glasses", "wine glass"),
        ("the knives", "knife"),
        ("hot dogs", "hot dog"),
        ("a carpet", None),
        ("the telly", "tv"),
        ("my glass", "cup"),
        ("two tea cups", "cup"),
        ("toilet paper", None),
        ("the dishes", None),
    ],
)
def test_plurals_and_whole_words_lead_to_a_label(text: str, label: str | None) -> None:
    assert label_in(text) == label
