"""What the page says."""

import pytest

from contracts.mission import MissionState, Outcome
from contracts.problem import Dependency, DependencyState
from contracts.robot import EmergencyStop, EmergencyStopReply, NavigationState, SensorState, SensorStatus
from support.ui_world import mission, robot_state, status
from ui.latest_facts import LatestFacts
from ui.page_model import PHASES, PageModel, Tone, ago, duration, page_model

NOW_S = 100.0


def seen(facts: LatestFacts, now_s: float = NOW_S) -> PageModel:
    return page_model(facts, now_s=now_s, silence_s_max=2.0)


def test_every_mission_state_has_words() -> None:
    assert set(PHASES) == set(MissionState)


def test_nothing_known_is_said_and_nothing_can_be_pressed() -> None:
    shown = seen(LatestFacts())
    assert shown.phase == "Mission status unknown"
    assert shown.robot_facts[0].value == "no data yet"
    assert not any((shown.can_pause, shown.can_resume, shown.can_cancel, shown.can_dock, shown.can_undock))


def test_a_running_mission_shows_phase_command_reason_and_numbers() -> None:
    facts = LatestFacts()
    facts.take_mission(status(mission(measured_distance_m=1.32)), NOW_S)
    shown = seen(facts)
    assert (shown.phase, shown.phase_tone) == ("Looking around", Tone.BUSY)
    assert shown.headline == "“find the red bottle”"
    assert shown.reason == "turning to the next of 8 headings"
    assert [chip.value for chip in shown.mission_facts] == ["0:42", "6.4 m", "1.32 m"]
    assert shown.can_pause
    assert shown.can_cancel


def test_a_paused_mission_can_go_on_but_not_be_paused() -> None:
    facts = LatestFacts()
    facts.take_mission(status(mission(paused=True)), NOW_S)
    shown = seen(facts)
    assert (shown.phase, shown.can_pause, shown.can_resume) == ("Paused", False, True)


@pytest.mark.parametrize("outcome", list(Outcome))
def test_an_ended_mission_says_how_and_why(outcome: Outcome) -> None:
    facts = LatestFacts()
    facts.take_mission(status(mission(outcome=outcome, reason="because"), state=MissionState.IDLE), NOW_S)
    shown = seen(facts)
    assert shown.phase.lower().replace(" ", "_") in {outcome.value, "not_sure", "cancelled"}
    assert shown.reason == "because"
    assert not shown.can_cancel


def test_a_stop_comes_before_everything_else() -> None:
    facts = LatestFacts()
    facts.take_mission(status(mission()), NOW_S)
    facts.take_robot(robot_state(), NOW_S)
    stop = EmergencyStop(latched=True, epoch=1, reason="STOP pressed on the page", by="ui 10.0.0.7")
    facts.take_stop_reply(EmergencyStopReply(state=stop, first_zero_ms=2.44), NOW_S)
    shown = seen(facts)
    assert shown.stopped
    assert (shown.phase, shown.phase_tone) == ("Stopped", Tone.BAD)
    assert shown.stop_detail == "STOP pressed on the page · by ui 10.0.0.7 · first zero velocity after 2.4 ms"
    assert not shown.can_pause
    assert not shown.can_dock


def test_a_silent_robot_is_told_with_the_time_it_has_been_silent() -> None:
    facts = LatestFacts()
    facts.take_robot(robot_state(), NOW_S)
    shown = seen(facts, now_s=NOW_S + 75.0)
    assert shown.robot_facts[0].value == "no data for 1:15"
    assert not shown.robot_fresh
    assert not shown.can_dock


def test_a_stale_sensor_is_told_by_name() -> None:
    facts = LatestFacts()
    facts.take_robot(robot_state(), NOW_S)
    tones = {chip.label: chip.tone for chip in seen(facts).sensors}
    assert tones["depth"] is Tone.BAD
    assert tones["scan"] is Tone.GOOD


def test_a_sensor_that_is_not_understood_is_told_with_its_reason_and_one_with_a_note_is_a_warning() -> None:
    sensors = {
        "scan": SensorStatus(state=SensorState.NOT_UNDERSTOOD, detail="its range_max is 0 m"),
        "rgb": SensorStatus(state=SensorState.FRESH, age_s=0.1, detail="it carries no time"),
        "map": SensorStatus(state=SensorState.NEVER),
    }
    facts = LatestFacts()
    facts.take_robot(robot_state().model_copy(update={"sensors": sensors}), NOW_S)
    chips = {chip.label: chip for chip in seen(facts).sensors}
    assert (chips["scan"].value, chips["scan"].tone) == ("not understood", Tone.BAD)
    assert chips["scan"].title == "scan: not understood, its range_max is 0 m"
    assert (chips["rgb"].tone, chips["rgb"].title) == (Tone.WARN, "rgb: fresh, it carries no time")
    assert (chips["map"].value, chips["map"].tone) == ("never", Tone.BAD)


def test_the_dock_buttons_follow_the_robot() -> None:
    facts = LatestFacts()
    facts.take_robot(robot_state(docked=True), NOW_S)
    assert (seen(facts).can_dock, seen(facts).can_undock) == (False, True)
    facts.take_robot(robot_state(docked=False), NOW_S)
    assert (seen(facts).can_dock, seen(facts).can_undock) == (True, False)
    driving = robot_state(docked=False).model_copy(update={"navigation": NavigationState.NAVIGATING})
    facts.take_robot(driving, NOW_S)
    assert not seen(facts).can_dock


def test_who_is_missing_is_named() -> None:
    facts = LatestFacts()
    ok = Dependency.of("memory", ok=True)
    away = Dependency(name="redis", state=DependencyState.UNREACHABLE, detail="not reachable")
    facts.services = (away, ok)
    assert seen(facts).away == "Redis not reachable"
    ready = Dependency.of("inference", ok=False, detail="not ready")
    facts.services = (away, ready)
    assert seen(facts).away == "Redis not reachable"
    slow = Dependency.of("memory", ok=False, detail="not ready in time")
    facts.services = (ready, slow)
    assert seen(facts).away == "inference, memory not ready"


def test_a_service_that_warns_is_shown_as_one_that_works_and_says_of_what() -> None:
    facts = LatestFacts()
    wrong = "ollama:small: answers, but never as asked: its answer was empty"
    warns = Dependency(name="inference", state=DependencyState.WARNING, detail=wrong)
    facts.services = (warns, Dependency.of("memory", ok=True))
    chips = seen(facts).services
    assert [(one.value, one.tone) for one in chips] == [(wrong[:60], Tone.WARN), ("", Tone.GOOD)]
    assert wrong in chips[0].title
    assert seen(facts).away == ""


def test_durations_read_like_a_clock() -> None:
    assert [duration(seconds) for seconds in (7.9, 750.0, 3723.0)] == ["0:07", "12:30", "1:02:03"]


def test_ages_read_as_a_person_says_them() -> None:
    assert [ago(s) for s in (-3.0, 12.0, 300.0, 3 * 3600.0, 3 * 86400.0)] == [
        "0 s ago", "12 s ago", "5 min ago", "3 h ago", "3 days ago",
    ]  # fmt: skip


def test_a_service_that_is_waited_for_is_the_reason_shown() -> None:
    facts = LatestFacts()
    facts.take_mission(status(mission(), waiting_for="robot_bridge, at most 20 s"), NOW_S)
    assert seen(facts).reason == "Waiting for robot_bridge, at most 20 s"


def test_what_is_queued_is_listed() -> None:
    facts = LatestFacts()
    waiting = mission("find the book", id="m-2", queue_position=0)
    facts.take_mission(status(mission(), queue=(waiting,)), NOW_S)
    assert seen(facts).queue == (("m-2", "find the book"),)
