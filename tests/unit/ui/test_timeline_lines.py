"""The timeline's words, filter and endings."""

import pytest

from contracts.mission import EventFacts, MissionState, Outcome
from support.ui_world import event, mission, votes
from ui.timeline_lines import Show, ending_chips, line, shown, vote_chips


def test_a_line_of_the_timeline_has_its_time_and_votes() -> None:
    data = EventFacts(votes=votes(), picture=3)
    shown = line(event(65, "2 of 3 say yes", kind="votes", data=data), started_s=event(0, "").stamp_s)
    assert shown.time == "1:05"
    assert [chip.label for chip in shown.votes] == ["Detector", "CLIP", "VLM"]
    assert shown.crop == 3


def test_votes_are_words_with_numbers() -> None:
    assert [chip.value for chip in vote_chips(votes())] == ["yes 0.81 / 0.30", "yes 0.62 / 0.45", "–"]


@pytest.mark.parametrize(
    ("kind", "where"),
    [("votes", Show.SEEING), ("sighting", Show.SEEING), ("navigation", Show.DRIVING), ("failure", Show.TROUBLE)],
)
def test_the_filter_knows_what_a_line_is_about(kind: str, where: Show) -> None:
    one = event(1, "so", kind=kind)
    assert [show for show in Show if shown(one, show)] == [Show.ALL, where]


@pytest.mark.parametrize(
    ("state", "where"),
    [
        (MissionState.MOVING_TO_SCAN, [Show.ALL, Show.DRIVING]),
        (MissionState.CENTERING, [Show.ALL, Show.SEEING]),
        (MissionState.IDLE, [Show.ALL]),
    ],
)
def test_a_change_of_state_is_about_what_is_done_in_it(state: MissionState, where: list[Show]) -> None:
    one = event(1, "on to the next place", kind="state", state=state)
    assert [show for show in Show if shown(one, show)] == where


def test_a_stop_is_trouble_whatever_its_kind() -> None:
    assert shown(event(1, "stopped", state=MissionState.EMERGENCY_STOP), Show.TROUBLE)


@pytest.mark.parametrize("outcome", list(Outcome))
def test_every_ending_has_a_word_and_its_numbers(outcome: Outcome) -> None:
    one = mission(outcome=outcome, ended_s=1_800_000_065.0, measured_distance_m=0.42)
    chips = ending_chips(one)
    assert chips[0].value
    assert [chip.value for chip in chips[1:]] == ["1:05", "6.4 m", "0.42 m"]
