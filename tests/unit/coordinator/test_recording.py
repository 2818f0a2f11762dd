"""A mission as data: written down, read back, decided again in the same way."""

from pathlib import Path

import pytest

from contracts.mission import MissionState
from contracts.vision import Verdict
from coordinator.core import actions as do
from coordinator.core import events as ev
from coordinator.core import recording
from coordinator.core.mission import Mission
from coordinator.core.recording import MalformedRecordingError, Recording, Step
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
        ['{"form": 5}'],
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


@pytest.mark.parametrize("form", [1, 2, 3, 4, 6])
def test_a_recording_of_another_form_is_refused_in_a_clear_sentence(form: int) -> None:
    """Whatever else its header holds: fields come and go with the form."""
    with pytest.raises(MalformedRecordingError, match=rf"^a recording of form {form}, and only form 5 can be decided"):
        recording.read([f'{{"form": {form}, "rules": {{"gone": 1}}}}'])


def test_a_mission_written_down_before_is_decided_the_same_way() -> None:
    """A place without a path, a step straight ahead, a place closer by, an approach."""
    lines = (RECORDINGS / "form-5.jsonl").read_text(encoding="utf-8").splitlines()
    again = list(recording.replay(recording.read(lines)))
    assert all(one.same for one in again)
    assert {MissionState.DRIVING_1M, MissionState.APPROACHING} <= {one.after.state for one in again}
