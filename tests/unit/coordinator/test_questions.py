"""What a question is about."""

import pytest

from contracts.asking import About
from coordinator.questions.parsed_question import Asked, label_in, understand


@pytest.mark.parametrize(
    ("question", "asked"),
    [
        ("Where did you last see my mug?", Asked(About.LAST_SEEN, "cup")),
        ("where are the red bottles", Asked(About.LAST_SEEN, "bottle", "red")),
        ("Have you seen my phone?", Asked(About.LAST_SEEN, "cell phone")),
        ("Where did you last see my keys?", Asked(About.LAST_SEEN)),
        ("when did you see the teddy bear", Asked(About.LAST_SEEN, "teddy bear")),
        ("What is in the kitchen?", Asked(About.CONTENTS, room="kitchen")),
        ("what do you remember", Asked(About.CONTENTS)),
        ("What are you doing?", Asked(About.DOING)),
        ("did you find the cup", Asked(About.HISTORY, "cup")),
        ("How full is the battery?", Asked(About.BATTERY)),
        ("sing a song", Asked(About.UNKNOWN)),
        ("", Asked(About.UNKNOWN)),
        ("where is the orange", Asked(About.LAST_SEEN, "orange")),
    ],
)
def test_a_question_is_read_by_its_words(question: str, asked: Asked) -> None:
    assert understand(question) == asked


@pytest.mark.parametrize(
    ("text", "label"),
    [("two wine glasses", "wine glass"), ("the knives", "knife"), ("hot dogs", "hot dog"), ("a carpet", None)],
)
def test_plurals_and_whole_words_lead_to_a_label(text: str, label: str | None) -> None:
    assert label_in(text) == label
