"""A mission as data: written down, read back, decided again in the same way."""

import json
from pathlib import Path

import pytest

from contracts.mission import MissionState, Outcome
from contracts.motion import MotionEnd
from contracts.vision import Verdict
from coordinator.core import actions as do
from coordinator.core import events as ev
from coordinator.core import recording
from coordinator.core.mission import Mission
from coordinator.core.recording import MalformedRecordingError, Recording, Step
from coordinator.core.rules import ApproachRule
from coordinator.core.step import step
from support.mission_script import Script, rules_of

RECORDINGS = Path(__file__).parents[2] / "data" / "recordings"


class Recorded(Script):
    """A script that writes its mission down as the runner does."""

    def begun(self) -> "Recorded":
        self.lines = [recording.header_line(recording.header_of(self.mission, "m1", self.now_s))]
        self.begin()
        return self

    def feed(self, event: ev.Event) -> "Recorded":
        before = len(self.actions)
        super().feed(event)
        if hasattr(self, "lines"):
            line = recording.step_line(Step(self.now_s, event, tuple(self.actions[before:]), self.mission.state))
            self.lines.append(line)
        return self

    def recording(self) -> Recording:
        return recording.read(self.lines)


def found() -> Recorded:
    script = Recorded().begun()
    script.centred().measured(1.2, 3).voted(Verdict.YES).arrived()
    script.see().wait(6.0).drove(moved=0.7).wait(6.0)
    return script


def test_a_mission_written_down_and_read_back_is_decided_the_same_way() -> None:
    script = found()
    again = list(recording.replay(script.recording()))
    assert all(one.same for one in again)
    assert again[-1].after == script.mission
    assert MissionState.APPROACHING in {one.after.state for one in again}


def test_other_rules_decide_otherwise_and_it_is_noticed() -> None:
    written = found().recording()
    other = Recording(
        recording.Header(
            form=written.header.form,
            mission_id="m1",
            begun_s=written.header.begun_s,
            rules=rules_of(approach_rule="straight"),  # type: ignore[arg-type]
            robot=written.header.robot,
            calls=written.header.calls,
        ),
        written.steps,
    )
    assert not all(one.same for one in recording.replay(other))


def test_a_recording_of_before_in_which_the_target_has_no_colour_is_decided_the_same_way() -> None:
    script = found()
    before = [line.replace('"colour":"red","not_colours"', '"not_colours"') for line in script.lines]
    assert before != script.lines
    again = list(recording.replay(recording.read(before)))
    assert all(one.same for one in again)
    assert again[-1].after == script.mission


def test_what_changed_nothing_may_be_left_out() -> None:
    script = found()
    mission = Mission(rules=script.mission.rules, robot=script.recording().header.robot)
    kept: list[Step] = []
    for one in script.recording().steps:
        before = mission
        mission, actions = step(before, one.event, one.now_s)
        if mission != before or actions:
            kept.append(one)
    assert len(kept) < len(script.recording().steps)
    *_, last = recording.replay(Recording(script.recording().header, tuple(kept)))
    assert last.after == script.mission


@pytest.mark.parametrize(
    "lines",
    [
        [],
        ["{"],
        ['{"form": 99}'],
        [found().lines[0].replace('"form":4', '"form":5')],
        [found().lines[0], '{"now_s": 1}'],
        [found().lines[0], '{"now_s": 1, "event": {"is": "Explode"}, "actions": [], "state": "IDLE"}'],
        [found().lines[0], '{"now_s": 1, "event": {"is": "Tick"}, "actions": [], "state": "ASLEEP"}'],
    ],
)
def test_what_is_no_recording_is_refused_by_name(lines: list[str]) -> None:
    with pytest.raises(MalformedRecordingError):
        recording.read(lines)


def test_every_action_and_event_can_be_written_down() -> None:
    assert {do.StopMotion, do.Say, ev.Tick, ev.MissionStarted} <= set(recording.KINDS)


@pytest.mark.parametrize(
    ("completed", "reason", "end"),
    [
        (True, "", MotionEnd.COMPLETED),
        (False, "obstacle ahead", MotionEnd.BLOCKED),
        (False, "slowed: 0.10 m free ahead; acceleration limit; obstacle ahead", MotionEnd.BLOCKED),
        (False, "hazard: CLIFF", MotionEnd.HAZARD),
        (False, "a wheel hangs in the air", MotionEnd.LIFTED),
        (False, "timeout", MotionEnd.TIMED_OUT),
        (False, "teleop has the wheels", MotionEnd.HELD_BACK),
        (False, "", MotionEnd.HELD_BACK),
    ],
)
def test_a_recording_of_the_first_form_still_opens_with_its_ends_as_types(
    completed: bool, reason: str, end: MotionEnd
) -> None:
    event = {"is": "MotionEnded", "call": 7, "completed": completed, "moved": 0.4, "reason": reason}
    line = json.dumps({"now_s": 101.0, "event": event, "actions": [], "state": "APPROACHING"})
    header = found().lines[0].replace('"form":4', '"form":1').replace(',"lifted_s":null', "")
    read = recording.read([header, line])
    assert read.steps[0].event == ev.MotionEnded(7, end, turned_rad=0.4, driven_m=0.4, text=reason)
    assert len(list(recording.replay(read))) == 1


def test_a_mission_recorded_by_the_version_before_is_decided_the_same_way() -> None:
    """Paused, resumed and cancelled on the plain approach: by the names those had in form 2."""
    lines = (RECORDINGS / "form-2.jsonl").read_text(encoding="utf-8").splitlines()
    again = list(recording.replay(recording.read(lines)))
    assert all(one.same for one in again)
    assert again[-1].after.rules.approach_rule is ApproachRule.STRAIGHT
    assert again[-1].after.outcome is Outcome.CANCELED


def test_a_mission_of_form_3_in_which_the_core_chose_the_paths_is_decided_the_same_way() -> None:
    """A place without a path, goals tried again after an abort, a step straight ahead, an approach."""
    lines = (RECORDINGS / "form-3.jsonl").read_text(encoding="utf-8").splitlines()
    again = list(recording.replay(recording.read(lines)))
    assert all(one.after.state is one.recorded.state for one in again)
    sent = [one for one in again if not one.same]  # one circle fewer: what is too near for a goal is no candidate now
    assert [type(one.recorded.event) for one in sent] == [ev.Validated]
