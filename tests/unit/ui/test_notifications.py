"""What a person hears of at once."""

import pytest

from contracts.mission import MissionState, Outcome
from contracts.robot import EmergencyStop
from support.ui_world import mission, status
from ui.notifications import Notifications
from ui.page_model import Tone


def test_a_mission_seen_to_end_is_told_once() -> None:
    news = Notifications()
    news.take_mission(status(mission()))
    ended = status(mission(outcome=Outcome.FOUND, reason="found the red bottle, 0.42 m away"))
    news.take_mission(ended)
    news.take_mission(ended)
    (item,) = news.after(0)
    assert item.tone is Tone.GOOD
    assert item.text == "Found: “find the red bottle”. found the red bottle, 0.42 m away."
    assert news.after(item.number) == ()


def test_a_mission_that_was_over_before_is_no_news() -> None:
    news = Notifications()
    news.take_mission(status(mission(outcome=Outcome.FOUND)))
    assert news.items == ()


def test_an_ending_by_the_stop_is_told_by_the_stop_alone() -> None:
    news = Notifications()
    news.take_stop(EmergencyStop(latched=False, epoch=0))
    news.take_mission(status(mission()))
    news.take_mission(status(mission(outcome=Outcome.ABORTED, reason="so"), state=MissionState.EMERGENCY_STOP))
    news.take_stop(EmergencyStop(latched=True, epoch=1, reason="STOP pressed", by="ui 10.0.0.7"))
    assert [item.text for item in news.items] == ["The robot was stopped: STOP pressed (ui 10.0.0.7). It needs you."]


@pytest.mark.parametrize(("outcome", "needed"), [(Outcome.UNSURE, True), (Outcome.NOT_FOUND, False)])
def test_an_ending_says_whether_it_needs_a_person(outcome: Outcome, needed: bool) -> None:
    news = Notifications()
    news.take_mission(status(mission()))
    news.take_mission(status(mission(outcome=outcome, reason="so")))
    assert ("It needs you." in news.items[-1].text) is needed


def test_waiting_is_told_once_a_service_when_its_second_try_failed_too() -> None:
    news = Notifications()
    for left_s, tries in ((2, 1), (1, 1), (0, 1)):
        news.take_mission(status(mission(), waiting_for=f"memory: again in {left_s} s ({tries} of 6 tries)"))
    assert news.items == ()
    for left_s, tries in ((4, 2), (3, 2), (8, 3)):
        news.take_mission(status(mission(), waiting_for=f"memory: again in {left_s} s ({tries} of 6 tries)"))
    assert [item.text for item in news.items] == ["Waiting for memory"]


def test_a_stop_is_news_and_a_latch_found_at_the_start_is_not() -> None:
    news = Notifications()
    latched = EmergencyStop(latched=True, epoch=1, reason="STOP pressed", by="ui 10.0.0.7")
    news.take_stop(latched)
    assert news.items == ()
    news.take_stop(EmergencyStop(latched=False, epoch=1))
    news.take_stop(latched.model_copy(update={"epoch": 2}))
    assert [item.tone for item in news.items] == [Tone.BAD]


def test_a_stop_is_told_when_it_has_said_why_and_then_once() -> None:
    news = Notifications()
    news.take_stop(EmergencyStop(latched=False, epoch=0))
    news.take_stop(EmergencyStop(latched=True, epoch=1, by="127.0.0.1"))
    assert news.items == ()
    for _ in range(2):
        news.take_stop(EmergencyStop(latched=True, epoch=1, reason="Esc pressed", by="ui 10.0.0.7"))
    assert [item.text for item in news.items] == ["The robot was stopped: Esc pressed (ui 10.0.0.7). It needs you."]


def test_old_news_leaves() -> None:
    news = Notifications()
    for number in range(100):
        for tries in (1, 2):
            news.take_mission(status(mission(), waiting_for=f"service {number}: again in 2 s ({tries} of 6 tries)"))
    assert len(news.items) == 20
    assert news.newest == 100
