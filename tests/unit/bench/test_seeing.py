"""The counting behind the votes' report: questions, shares, and where a line is drawn."""

import numpy as np
import pytest

from bench.seeing.statistics import share, wilson
from bench.seeing.voting import Answer, Question, questions
from bench.votes import Judged, at_cut, best_margin, summary
from contracts.vision import Verdict
from sim.training.records import Box, Frame

BOTTLE = Box("bottle_1", "bottle", "red", (10, 10, 40, 90), 1.2, 900)
FAR = Box("cup_1", "cup", "blue", (100, 10, 120, 30), 3.0, 200)
BEAR = Box("bear_1", "teddy bear", "brown", (150, 10, 200, 80), 1.0, 900)


def judged(colour: str, *, confirmed: bool, score: float = 0.6, lead: float = 0.2, spotted: bool = True) -> Judged:
    question = Question(BOTTLE, "bottle", colour)
    right = confirmed and question.right
    return Judged(
        question, Answer(spotted, right, confirmed and not right, Verdict.YES, score, lead, clip_ms=2.0, reason="")
    )


def test_what_is_in_range_is_asked_about_in_every_colour_and_as_another_kind() -> None:
    asked = list(questions(Frame("a.jpg", 1, (BOTTLE, FAR, BEAR)), 2.5, np.random.default_rng(0)))
    of_the_bottle = [one for one in asked if one.box is BOTTLE]
    assert sorted(one.kind_of for one in of_the_bottle) == ["other colour"] * 7 + ["other kind", "right"]
    assert {one.box.kind for one in asked} == {"bottle", "teddy bear"}
    assert [one.kind_of for one in asked if one.box is BEAR].count("other kind") == 0


def test_a_share_comes_with_its_interval() -> None:
    assert share(0, 300) == {"n": 0, "of": 300, "share": 0.0, "wilson_95": [0.0, 0.0126]}
    assert wilson(18, 25) == pytest.approx((0.524, 0.857), abs=0.001)
    assert wilson(0, 0) == (0.0, 1.0)


def test_the_report_tells_a_miss_of_the_detector_from_a_refusal() -> None:
    told = summary(
        [
            judged("red", confirmed=True),
            judged("red", confirmed=False),
            judged("red", confirmed=False, spotted=False),
            judged("blue", confirmed=True),
            judged("green", confirmed=False),
        ]
    )
    assert (told["right_refused_of_spotted"]["n"], told["right_refused_of_spotted"]["of"]) == (1, 2)
    assert (told["right_refused_of_all"]["n"], told["right_refused_of_all"]["of"]) == (2, 3)
    assert (told["other_colour_confirmed"]["n"], told["other_colour_confirmed"]["of"]) == (1, 2)
    assert (told["precision"], told["confusion"]["red"]["blue"]) == (0.5, [1, 1])


def test_a_line_refuses_what_lies_below_it_and_passes_what_lies_above() -> None:
    right = [judged("red", confirmed=True, score=score, lead=0.2) for score in (0.3, 0.5, 0.6, 0.7)]
    wrong = [judged("blue", confirmed=False, score=0.5, lead=lead) for lead in (-0.1, 0.0, 0.05, 0.1)]
    assert at_cut([*right, *wrong], 0.4, 0.0) == (0.25, 0.5)
    assert at_cut([*right, *wrong], 0.4, 0.1) == (0.25, 0.25)
    assert at_cut([], 0.4, 0.1) == (0.0, 0.0)


def test_a_colour_is_named_from_the_margin_at_which_few_names_are_wrong() -> None:
    leads = [(0.01, False)] * 5 + [(0.02, True)] * 20 + [(0.3, True)] * 75
    assert best_margin(leads) == {"margin": 0.02, "named": 0.95, "wrong_of_named": 0.0, "things": 100}
