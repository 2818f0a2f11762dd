"""A faulted mission is drawn from its seed, goes to disk and back, and its ending is judged by what was injected."""

import json
from typing import Any

import pytest

from bench.campaigning.__main__ import summary
from bench.campaigning.episode import FaultedEpisode, drawn, faulted
from bench.campaigning.verdict import judged
from bench.search.episode import Asked, Command, Episode
from bench.world.faults import KINDS, Errors, Faults, Outage
from contracts.geometry import Pose2D
from contracts.mission import EndCause, Mission, Outcome, Report
from contracts.vision import Verdict as Said
from contracts.vision import Vote

BEFORE_IT = {"false_find": False, "horizontal_distance_m": 0.5, "correct": True}
BEFORE_NOTHING = {"false_find": True}


@pytest.fixture(scope="module")
def plain() -> FaultedEpisode:
    asked = Asked(kind="bottle", colour="red")
    one = Episode(
        set_name="unseen", number=0, seed=1, home_seed=7000, tour=False, start=Pose2D(x=0.0, y=0.0, yaw=0.0),
        commands=(Command(text="find the red bottle", asked=(asked,)),),
    )  # fmt: skip
    return FaultedEpisode(seed=4, episode=one, faults=Faults())


def with_faults(plain: FaultedEpisode, **faults: Any) -> FaultedEpisode:
    return plain.model_copy(update={"faults": Faults(**faults)})


def ended(outcome: Outcome | None, **fields: Any) -> Mission:
    return Mission.model_validate({
        "id": "m", "request_id": "r", "command": "find the red bottle", "state": "IDLE", "outcome": outcome,
        "reason": "", "started_s": 1.0,
    } | fields)  # fmt: skip


def test_a_seed_is_one_mission_and_survives_its_json(plain: FaultedEpisode) -> None:
    assert drawn(4) == drawn(4) != drawn(5)
    assert FaultedEpisode.model_validate(json.loads(plain.model_dump_json())) == plain
    died = with_faults(plain, outages=(Outage("memory", 1.0, 2.0),))
    assert FaultedEpisode.model_validate(json.loads(died.model_dump_json())) == died


def test_every_kind_of_fault_is_drawn_and_a_fifth_has_none() -> None:
    plans = [drawn(seed)[1] for seed in range(200)]
    assert {name for faults in plans for name in faults.names} == set(KINDS)
    assert 20 < sum(not faults.names for faults in plans) < 60


def test_poor_light_is_the_light_of_the_home_and_some_missions_begin_on_the_dock() -> None:
    dark = faulted(0, faults=Faults(names=("poor light",), errors=Errors(dark=True)))
    assert dark.episode.light < 0.5 < faulted(0, faults=Faults()).episode.light
    assert 20 < sum(drawn(seed)[2] for seed in range(200)) < 60


@pytest.mark.parametrize(
    ("outcome", "fields", "faults", "dishonest"),
    [
        (None, {}, {}, "it never ended"),
        (Outcome.CANCELED, {}, {}, "nobody cancelled it"),
        (Outcome.CANCELED, {}, {"cancel_s": 3.0}, ""),
        (Outcome.INTERRUPTED, {}, {}, "nothing interrupted it"),
        (Outcome.INTERRUPTED, {}, {"coordinator_dies_s": 3.0}, ""),
        (Outcome.NOT_FOUND, {}, {}, "it does not say how much was looked at"),
        (Outcome.ABORTED, {}, {}, "no cause was told"),
        (Outcome.FOUND, {"measured_distance_m": 0.5}, {}, ""),
        (Outcome.FOUND, {"measured_distance_m": 2.0}, {}, "told 2.00 m, it is 0.50 m"),
        (Outcome.FOUND, {"measured_distance_m": 2.0}, {"depth_lie": 0.2}, ""),
    ],
)
def test_an_ending_is_judged_by_what_was_injected(
    plain: FaultedEpisode, outcome: Outcome | None, fields: dict[str, Any], faults: dict[str, Any], dishonest: str
) -> None:
    assert judged(with_faults(plain, **faults), ended(outcome, **fields), "", BEFORE_IT).dishonest == dishonest


@pytest.mark.parametrize(
    ("ended_by", "faults", "honest"),
    [
        (EndCause.STOPPED, {}, False),
        (EndCause.STOPPED, {"stop_s": 3.0}, True),
        (EndCause.STAYED_PAUSED, {}, False),
        (EndCause.STAYED_PAUSED, {"pause_s": 3.0}, True),
        (EndCause.NAVIGATION, {}, False),
        (EndCause.NAVIGATION, {"names": ("Nav2 rejects",)}, True),
    ],
)
def test_an_abortion_names_a_cause_that_was_there(
    plain: FaultedEpisode, ended_by: EndCause, faults: dict[str, Any], *, honest: bool
) -> None:
    mission = ended(Outcome.ABORTED, report=Report(text="told", ended_by=ended_by, cause="as told"))
    assert (judged(with_faults(plain, **faults), mission, "", BEFORE_IT).dishonest == "") is honest


def test_what_speaks_of_everything_must_have_looked_at_most_of_it(plain: FaultedEpisode) -> None:
    for share, honest in ((0.5, False), (0.9, True)):
        mission = ended(Outcome.NOT_FOUND, report=Report(text="told", ended_by=EndCause.ALL_LOOKED, looked_share=share))
        assert (judged(plain, mission, "", BEFORE_IT).dishonest == "") is honest


def test_a_false_find_is_honest_only_where_votes_say_why_it_was_believed(plain: FaultedEpisode) -> None:
    told = ended(Outcome.FOUND, votes=(Vote(voter="clip", verdict=Said.YES),))
    assert judged(plain, told, "", BEFORE_NOTHING).dishonest == ""
    assert "no vote says why" in judged(plain, ended(Outcome.FOUND), "", BEFORE_NOTHING).dishonest


def test_a_refusal_without_a_fault_is_dishonest(plain: FaultedEpisode) -> None:
    assert judged(with_faults(plain), None, "busy", {}).dishonest
    assert not judged(with_faults(plain, names=("memory down",)), None, "busy", {}).dishonest


def test_the_summary_counts_each_problem_once_a_mission(plain: FaultedEpisode) -> None:
    record = {
        "faulted": with_faults(plain, names=("pause",)).model_dump(mode="json"), "ending": "aborted", "dishonest": "",
        "problems": ["motion: a", "motion: b", "crash: c"], "score": {}, "correct": False, "took_s": 10.0,
    }  # fmt: skip
    told = summary([record, record | {"problems": [], "dishonest": "so"}])
    assert [told[name] for name in ("missions", "hang", "crash", "motion", "dishonest")] == [2, 0, 1, 1, 1]
    assert told["endings_by_fault"] == {"pause": {"aborted": 2}}
