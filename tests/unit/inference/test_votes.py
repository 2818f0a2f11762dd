"""The votes: who wins, who may abstain, and what the image-text model's vote rests on."""

import itertools

import pytest

from contracts.vision import Detection, Verdict, Vote
from inference.validation.votes import ClipScores, abstain, clip_vote, decide, detector_vote

CONFIRMED = frozenset(("yyy", "yyn", "yya", "yny", "yay", "nyy", "ayy"))
ALL = ["".join(code) for code in itertools.product("yna", repeat=3)]
VERDICTS = {"y": Verdict.YES, "n": Verdict.NO, "a": Verdict.ABSTAIN}


def votes(code: str) -> tuple[Vote, ...]:
    return tuple(Vote(voter=who, verdict=VERDICTS[c]) for who, c in zip(("detector", "clip", "vlm"), code, strict=True))


@pytest.mark.parametrize("code", ALL)
def test_two_of_those_that_can_vote_must_agree(code: str) -> None:
    decision = decide(votes(code))
    assert decision.confirmed is (code in CONFIRMED)
    assert decision.reason


def test_the_reason_names_who_said_what() -> None:
    assert decide(votes("yyn")).reason == "detector and clip agree, vlm disagreed"
    assert decide(votes("yna")).reason == "only detector agreed, clip disagreed; vlm abstained"
    assert decide(votes("yaa")).reason == "only 1 of 3 could vote, 2 are needed; clip and vlm abstained"


@pytest.mark.parametrize(
    ("score", "contrast", "verdict"),
    [
        (0.50, {}, Verdict.YES),
        (0.40, {}, Verdict.YES),
        (0.39, {}, Verdict.NO),
        (0.50, {"blue": 0.30, "green": 0.49}, Verdict.YES),
        (0.50, {"blue": 0.60, "green": 0.10}, Verdict.NO),
        (0.50, {"blue": 0.50}, Verdict.NO),
        (0.39, {"blue": 0.10}, Verdict.NO),
    ],
)
def test_clip_says_yes_when_threshold_and_contrast_both_hold(
    score: float, contrast: dict[str, float], verdict: Verdict
) -> None:
    vote = clip_vote(ClipScores("red bottle", score, contrast), threshold=0.40, margin=0.0, model="small", took_ms=2.5)
    assert (vote.verdict, vote.score, vote.threshold, vote.model, vote.took_ms) == (verdict, score, 0.40, "small", 2.5)


def test_the_clip_vote_tells_its_strongest_rival() -> None:
    scores = ClipScores("red bottle", 0.5, {"blue": 0.61, "green": 0.1}, frame_score=0.3)
    vote = clip_vote(scores, threshold=0.4, margin=0.0, model="", took_ms=0)
    assert vote.reason == "'red bottle' 0.50, 0.40 needed; but blue 0.61"
    assert (vote.rival, vote.rival_score, vote.frame_score) == ("blue", 0.61, 0.3)


@pytest.mark.parametrize(("margin", "verdict"), [(0.0, Verdict.YES), (0.05, Verdict.YES), (0.11, Verdict.NO)])
def test_the_lead_over_the_other_colours_must_be_the_models_own(margin: float, verdict: Verdict) -> None:
    vote = clip_vote(ClipScores("red bottle", 0.5, {"pink": 0.4}), threshold=0.4, margin=margin, model="", took_ms=0)
    assert vote.verdict is verdict


@pytest.mark.parametrize("code", ALL)
def test_a_vote_that_is_alone_confirms_only_where_that_was_allowed(code: str) -> None:
    decision = decide(votes(code), allow_single_vote=True)
    alone = code in {"yaa", "aya", "aay"}
    assert (decision.confirmed, decision.by_single_vote) == (code in CONFIRMED or alone, alone)
    assert ("which was allowed" in decision.reason) is alone


def test_the_detector_votes_with_its_confidence_or_says_what_it_did_not_see() -> None:
    found = Detection(label="bottle", confidence=0.81, bbox_xyxy=(0, 0, 1, 1))
    yes = detector_vote(found, label="bottle", threshold=0.3, model="yolo", took_ms=20)
    no = detector_vote(None, label="bottle", threshold=0.3, model="yolo", took_ms=20)
    assert (yes.verdict, yes.score, no.verdict, no.reason) == (Verdict.YES, 0.81, Verdict.NO, "no bottle in the frame")


def test_an_abstention_carries_its_reason() -> None:
    assert abstain("vlm", "past its deadline").reason == "past its deadline"
