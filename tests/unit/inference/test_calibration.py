"""What a vote is worth: by the table that was measured for the weights, and for no other."""

import hashlib
import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from contracts.vision import LOG_ODDS_MAX, Verdict, Vote
from inference.validation.calibration import FILE, UNMEASURED, Curve, read_calibration

WEIGHTS = Path(__file__).parents[3] / "sim" / "weights"
NEAR, FAR = (0.0, 0.0, 80.0, 120.0), (0.0, 0.0, 8.0, 20.0)
TABLE = read_calibration(WEIGHTS)


def clip(score: float, rival_score: float, *, model: str = "", verdict: Verdict = Verdict.YES) -> Vote:
    assert TABLE.clip_colour is not None
    named = model or TABLE.clip_colour.model
    return Vote(
        voter="clip", verdict=verdict, score=score, threshold=0.44, rival="grey", rival_score=rival_score, model=named
    )


def worth(vote: Vote, bbox: tuple[float, float, float, float] | None = NEAR) -> float | None:
    return TABLE.weighed((vote,), bbox, 250)[0].log_odds


def says(vote: Vote, bbox: tuple[float, float, float, float] = NEAR) -> float:
    log_odds = worth(vote, bbox)
    assert log_odds is not None
    return log_odds


@pytest.mark.parametrize(("voter", "weights"), [("detector", "detector.pt"), ("clip_colour", "clip.safetensors")])
def test_the_table_was_measured_on_the_weights_it_stands_beside(voter: str, weights: str) -> None:
    measured = json.loads((WEIGHTS / FILE).read_text())[voter]["sha256"]
    assert measured == hashlib.sha256((WEIGHTS / weights).read_bytes()).hexdigest()


def test_a_clear_lead_speaks_for_it_and_a_clear_rival_against_it() -> None:
    sure, doubtful, refused = (says(clip(score, 0.5)) for score in (0.9, 0.52, 0.2))
    assert sure > 1.0 > doubtful > refused
    assert refused < -2.0


def test_a_detector_that_saw_none_of_the_kind_says_more_where_the_box_is_large() -> None:
    assert TABLE.detector is not None
    none_seen = Vote(voter="detector", verdict=Verdict.NO, threshold=0.3, model=TABLE.detector.model)
    assert says(none_seen, NEAR) < says(none_seen, FAR) < 0.0


def test_a_colour_that_was_excluded_is_as_clear_a_no_as_there_is() -> None:
    assert worth(clip(0.9, 0.2, verdict=Verdict.NO)) == worth(clip(-1.0, 1.0, verdict=Verdict.NO))


def test_votes_of_another_model_or_on_no_box_or_withheld_stay_without_log_odds() -> None:
    withheld = Vote(voter="clip", verdict=Verdict.ABSTAIN)
    assert [worth(clip(0.9, 0.2, model="ViT-B-32")), worth(clip(0.9, 0.2), None), worth(withheld)] == [None] * 3
    assert UNMEASURED.weighed((clip(0.9, 0.2),), NEAR, 250)[0].log_odds is None


@given(score=st.floats(-1, 1), more=st.floats(0, 1), rival=st.floats(-1, 1))
def test_a_better_score_is_no_worse_evidence_and_none_is_without_bounds(
    score: float, more: float, rival: float
) -> None:
    assert -LOG_ODDS_MAX <= says(clip(score, rival)) <= says(clip(score + more, rival)) <= LOG_ODDS_MAX


def test_a_damaged_table_leaves_the_votes_uncalibrated(tmp_path: Path) -> None:
    (tmp_path / FILE).write_text('{"detector": 3}')
    assert read_calibration(tmp_path) == read_calibration(tmp_path / "nowhere") == UNMEASURED


def test_a_curve_may_not_fall() -> None:
    with pytest.raises(ValueError, match="slope"):
        Curve(side_share_min=0.0, intercept=0.0, slope=-1.0, lowest=-1.0, highest=1.0)
