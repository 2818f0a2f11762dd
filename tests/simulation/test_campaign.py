"""A slice of the fault campaign, the failures the source documents name, and missions decided again."""

import asyncio
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from bench.campaign import in_one_home, played
from bench.missions.place import SimulatedPlace
from bench.missions.run import Run
from bench.missions.scenario import HOMES, Present, Remembered, Scenario, scenario, wanted_in
from bench.missions.verdict import Verdict
from bench.world.clock import NothingLeftError, run_simulated
from bench.world.faults import Errors, Faults
from contracts.mission import Outcome
from coordinator import replay
from coordinator.core.recording import MalformedRecordingError, read

SLICES = {7: 7, 13: 7, 31: 6}
"""Home and how many missions in it; `python -m bench.campaign` plays hundreds."""
PATIENCE_S = 240.0
HOME = 3


@pytest.mark.timeout(900)  # half a minute on an idle machine
@pytest.mark.parametrize("home", SLICES)
def test_missions_with_faults_end_safely_and_honestly(home: int) -> None:
    rows = in_one_home([home + HOMES * k for k in range(SLICES[home])], mission_timeout_s=PATIENCE_S)
    assert len(rows) == SLICES[home]
    assert {row["seed"]: row["problems"] for row in rows if row["problems"]} == {}
    assert {row["seed"]: (row["dishonest"], row["reason"]) for row in rows if row["dishonest"]} == {}


@pytest.fixture(scope="module")
def place() -> Iterator[SimulatedPlace]:
    home = SimulatedPlace(HOME, *wanted_in(HOME))
    yield home
    home.close()


def mission(faults: Faults, **changes: Any) -> Scenario:
    """In that home, for what is there, with memory right, and these faults."""
    plain = replace(
        scenario(HOME, faults=faults), present=Present.THERE, asked_colour=wanted_in(HOME)[1], docked=False,
        rules={"mission_timeout_s": PATIENCE_S},
        remembered=Remembered.RIGHT,
    )  # fmt: skip
    return replace(plain, **changes)


def ended(run: Run, verdict: Verdict, outcome: Outcome) -> str:
    """The reason of a mission that ended so, safely and honestly."""
    assert run.problems == []
    assert verdict.dishonest == ""
    assert run.mission is not None
    assert run.mission.outcome is outcome, run.mission.reason
    return run.mission.reason


def told(run: Run) -> str:
    return "\n".join(event.text for event in run.events)


def test_what_was_moved_since_mapping_is_found_where_it_is_now(place: SimulatedPlace) -> None:
    elsewhere = mission(Faults(), remembered=Remembered.MOVED, seed=HOME + HOMES, rules={})
    run, verdict = played(elsewhere, place)
    ended(run, verdict, Outcome.FOUND)
    assert verdict.correct
    assert "nothing found here" in told(run)


@pytest.mark.parametrize(
    "faults",
    [Faults(goal_aborted_104=0.35), Faults(goal_aborted_2xx=0.35), Faults(goal_rejected=0.3), Faults(path_lie=0.3)],
    ids=["aborted 104", "aborted 2xx", "rejected", "no path"],
)
def test_goals_that_fail_now_and_then_do_not_keep_it_from_finding(place: SimulatedPlace, faults: Faults) -> None:
    run, verdict = played(mission(faults), place)
    ended(run, verdict, Outcome.FOUND)


def test_navigation_that_never_works_ends_with_that_as_the_cause(place: SimulatedPlace) -> None:
    faults = Faults(names=("Nav2 aborts 2xx",), goal_aborted_2xx=1.0)
    run, verdict = played(mission(faults, present=Present.ABSENT, asked_colour="brown"), place)
    assert "navigation reached none of 12 places in a row" in ended(run, verdict, Outcome.ABORTED)
    assert run.way_m < 1.0


def test_in_poor_light_both_models_say_no_and_it_says_it_may_have_been_it(place: SimulatedPlace) -> None:
    dark = Faults(names=("poor light",), errors=Errors(dark=True, vlm=True, unknown_colour=0.0))
    run, verdict = played(mission(dark, seed=1), place)  # CLIP's no is a narrow one there, as in six seeds of twelve
    reason = ended(run, verdict, Outcome.UNSURE)
    assert "it may have been" in reason
    assert run.mission is not None
    assert run.mission.report is not None
    assert run.mission.report.candidates


def test_the_death_of_the_coordinator_ends_all_motion_and_nothing_resumes(place: SimulatedPlace) -> None:
    run, verdict = played(mission(Faults(names=("coordinator dies",), coordinator_dies_s=8.0)), place)
    ended(run, verdict, Outcome.INTERRUPTED)


def test_the_same_seed_is_the_same_mission(place: SimulatedPlace) -> None:
    one = mission(Faults(bus_drop=0.2, bus_delay_s_max=0.5, reply_delay_s_max=1.0))
    first, second = (played(one, place)[0] for _ in range(2))
    assert told(first) == told(second)
    assert first.pose == second.pose


def test_a_recorded_mission_is_decided_again_step_by_step(
    place: SimulatedPlace, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    run, _ = played(mission(Faults(bus_duplicate=0.2)), place)
    path = tmp_path / "mission.jsonl"
    path.write_text("\n".join(run.recording), encoding="utf-8")
    monkeypatch.setattr("sys.argv", ["replay", str(path)])
    assert replay.main() == 0
    shown = capsys.readouterr().out
    steps = len(read(run.recording).steps)
    assert f"{steps} of {steps} steps decided as recorded" in shown
    assert "CENTERING -> DEPTH_CHECK" in shown
    other = run.recording[0].replace('"reach_m":0.45', '"reach_m":0.2')
    assert other != run.recording[0]
    path.write_text("\n".join([other, *run.recording[1:]]), encoding="utf-8")
    assert replay.main() == 1
    assert "RECORDED" in capsys.readouterr().out


def test_a_file_that_is_no_recording_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "mission.jsonl"
    path.write_text("no recording", encoding="utf-8")
    monkeypatch.setattr("sys.argv", ["replay", str(path)])
    assert replay.main() == 2
    assert capsys.readouterr().err
    with pytest.raises(MalformedRecordingError):
        read([])


def test_a_hang_does_not_go_unnoticed() -> None:
    async def for_ever() -> None:
        await asyncio.Event().wait()

    with pytest.raises(NothingLeftError):
        run_simulated(for_ever)
