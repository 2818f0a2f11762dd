"""Whatever is asked in whatever order: a stopped robot stands, and nothing is answered with 500."""

import tempfile
from pathlib import Path
from typing import Any, Final

import schemathesis
from hypothesis import HealthCheck, Phase, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule
from schemathesis import GenerationMode

from contracts.robot import EmergencyStop
from robot_bridge.app import create_app
from robot_bridge.settings import Settings
from support.bus import MemoryBus
from support.fake_robot import FakeRobot
from support.toy_robot import ToyRobot

folder = tempfile.TemporaryDirectory(prefix="atom-sequences-")  # removed with the process
toy = ToyRobot(navigation="succeeds")
app = create_app(
    Settings(state_dir=Path(folder.name), scan_age_s_max=60.0, image_age_s_max=60.0),
    bus=MemoryBus(),
    robot=FakeRobot(toy),
)
schema = schemathesis.openapi.from_asgi("/openapi.json", app).exclude(path_regex="^/(ready|camera/.*|motion/gains)$")
OPERATIONS: Final = {
    f"{one.method.upper()} {one.path}": one for one in (found.ok() for found in schema.get_all_operations())
}
STANDING: Final = (0.0, 0.0)
MOVING: Final[dict[str, dict[str, Any]]] = {
    "POST /velocity": {"duration_s": 0.3, "stamp_s": None},
    "POST /rotate": {"timeout_s": 0.3},
    "POST /drive": {"timeout_s": 0.3},
    "POST /navigation/goals": {"candidates": [{"pose": {"x": 1.35, "y": 2.0, "yaw": 0.0}}]},
}
"""What moves the robot, and with what in its body it is obeyed, for a short time."""


def asked(*names: str) -> st.SearchStrategy[schemathesis.Case]:
    """Well-formed requests of these operations."""
    return st.sampled_from(names).flatmap(
        lambda name: OPERATIONS[name].as_strategy(generation_mode=GenerationMode.POSITIVE)
    )


class Sequences(RuleBasedStateMachine):
    """Requests one after another; what was answered goes into later ones."""

    @initialize()
    def motion_is_permitted(self) -> None:
        self.stop = EmergencyStop(latched=True, epoch=0)
        self.ids = {"goal_id": "none", "recording_id": "none"}
        self.reset()

    @rule(case=asked(*(name for name in OPERATIONS if name not in MOVING)))
    def ask_anything(self, case: schemathesis.Case) -> None:
        self._ask(case)

    @rule(case=asked(*MOVING), epoch_off=st.sampled_from((0, 0, 0, 1)))
    def ask_to_move(self, case: schemathesis.Case, epoch_off: int) -> None:
        epoch = self.stop.epoch + epoch_off
        case.body = case.body | {"epoch": epoch, "session_id": None} | MOVING[f"{case.method} {case.operation.path}"]
        self._ask(case)

    @rule(case=asked(*MOVING))
    def stop_and_ask_to_move(self, case: schemathesis.Case) -> None:
        self._told(OPERATIONS["POST /emergency-stop"].Case().call())
        self.ask_to_move(case, 0)

    @rule()
    def reset(self) -> None:
        self._told(OPERATIONS["POST /emergency-stop/reset"].Case().call())

    @rule()
    def a_picture_comes(self) -> None:
        """Time passes: the wheels have ticked twice before the second one."""
        for _ in range(2):
            newest = frame({"after": 0.0, "wait_s": 5})
            frame({"after": newest.headers["x-stamp-s"][0], "wait_s": 2.0})

    def _ask(self, case: schemathesis.Case) -> None:
        case.path_parameters = {name: self.ids.get(name, value) for name, value in (case.path_parameters or {}).items()}
        answer = case.call()
        assert answer.status_code != 500, f"{case.method} {case.formatted_path}: {answer.text}"
        self._told(OPERATIONS["GET /emergency-stop"].Case().call())
        self._learn(case, answer)

    def _learn(self, case: schemathesis.Case, answer: Any) -> None:
        kind = {"/navigation/goals": "goal_id", "/recordings": "recording_id"}.get(case.operation.path)
        if kind and case.method == "POST" and answer.status_code == 200:
            self.ids[kind] = answer.json()["id"]

    def _told(self, answer: Any) -> None:
        """What the stop is now; the time of standing begins with the answer that says so."""
        state = EmergencyStop.model_validate(answer.json().get("state", answer.json()))
        if state.latched and not self.stop.latched:
            self.since = len(toy.velocities)
        self.stop = state

    @invariant()
    def a_stopped_robot_stands(self) -> None:
        if self.stop.latched:
            assert set(toy.velocities[self.since :]) <= {STANDING}


def frame(query: dict[str, Any]) -> Any:
    return schemathesis.openapi.from_asgi("/openapi.json", app)["/camera/frame"]["GET"].Case(query=query).call()


TestSequences = Sequences.TestCase
TestSequences.settings = settings(
    max_examples=6,
    stateful_step_count=25,
    derandomize=True,
    deadline=None,
    phases=[Phase.explicit, Phase.generate],
    suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow, HealthCheck.data_too_large],
)
