"""`atom do`: the declared actions from a terminal, against the services' contract."""

import json
from importlib.metadata import version
from typing import Any

import httpx
import pytest
from typer.testing import CliRunner, Result

from atom_cli import __main__ as cli
from atom_cli import following
from contracts.actions import SPECS, ActionName, ActionReply
from contracts.asking import About, Answer
from contracts.mission import Heard, Outcome
from contracts.reading import Mood
from contracts.robot import EmergencyStop, EmergencyStopReply
from support.ui_world import event, mission, status

runner = CliRunner()


class Played:
    """A coordinator that does what it is asked for, and a bridge that stops."""

    def __init__(self) -> None:
        self.asked: list[tuple[str, str]] = []
        self.bodies: list[dict[str, Any]] = []
        self.keys: list[str | None] = []
        self.outcome = Outcome.DONE
        self.still = True
        self.problem: tuple[int, str] | None = None

    def __call__(self, request: httpx.Request) -> httpx.Response:
        path = request.url.path
        self.asked.append((request.method, path))
        self.keys.append(request.headers.get("authorization"))
        if request.content:
            self.bodies.append(json.loads(request.content))
        if self.problem is not None:
            code, detail = self.problem
            return httpx.Response(code, json={"title": "Not now", "status": code, "detail": detail})
        return httpx.Response(200, json=self.answer(path))

    def answer(self, path: str) -> Any:
        if path == "/actions":
            return self.did(ActionName(self.bodies[-1]["action"])).model_dump(mode="json")
        if path == "/actions/stop":
            return self.did(ActionName.STOP).model_dump(mode="json")
        if path == "/emergency-stop":
            return EmergencyStopReply(state=EmergencyStop(latched=True, epoch=1)).model_dump(mode="json")
        ended = mission(outcome=self.outcome, reason="so it ended")
        return {
            "/missions": [ended.model_dump(mode="json")],
            "/missions/m-1": ended.model_dump(mode="json"),
            "/missions/m-1/events": [event(1, "driving").model_dump(mode="json")],
            "/state": status(mission()).model_dump(mode="json"),
        }[path]

    def did(self, name: ActionName) -> ActionReply:
        if name is ActionName.STOP:
            return ActionReply(
                action=name, text="Stopped.", heard=Heard(mood=Mood.STOP, text="Stopped.", still=self.still)
            )
        if SPECS[name].moves or name in {ActionName.PAUSE, ActionName.CANCEL, ActionName.RESUME}:
            return ActionReply(action=name, text="Paused: find it", mission=mission())
        answer = Answer(answer="Three.", about=About.COUNT, phrased_by="template", notes="memory is away")
        return ActionReply(action=name, text="Three.", answer=answer)


@pytest.fixture
def played(monkeypatch: pytest.MonkeyPatch) -> Played:
    services = Played()
    monkeypatch.setattr(cli, "transport", httpx.MockTransport(services))
    monkeypatch.setattr(following, "POLL_S", 0.0)
    monkeypatch.setenv("ATOM_KEY", "a-key")
    return services


def atom(*arguments: str) -> Result:
    return runner.invoke(cli.app, list(arguments))


@pytest.mark.parametrize(
    ("said", "sent"),
    [
        (("drive", "--distance-m", "0.5"), {"action": "drive", "distance_m": 0.5}),
        (("rotate", "--angle-rad", "-1.5"), {"action": "rotate", "angle_rad": -1.5}),
        (("go-to", "--room", "kitchen"), {"action": "go_to", "room": "kitchen"}),
        (("go-to", "--x-m", "1", "--y-m", "-2"), {"action": "go_to", "x_m": 1.0, "y_m": -2.0}),
        (("patrol", "--rooms", "hall", "--rooms", "den"), {"action": "patrol", "rooms": ["hall", "den"]}),
        (("find", "--thing", "red bottle"), {"action": "find", "thing": "red bottle"}),
        (("look-around",), {"action": "look_around"}),
    ],
)
def test_an_action_that_moves_is_sent_as_declared_and_followed_to_its_end(
    played: Played, said: tuple[str, ...], sent: dict[str, Any]
) -> None:
    result = atom("do", *said)
    assert (result.exit_code, played.bodies) == (0, [sent]), result.output
    assert "driving" in result.output
    assert "done" in result.output
    assert played.keys[0] == "Bearer a-key"


@pytest.mark.parametrize(("outcome", "code"), [(Outcome.DONE, 0), (Outcome.NOT_FOUND, 10), (Outcome.ABORTED, 13)])
def test_the_exit_code_is_the_ending(played: Played, outcome: Outcome, code: int) -> None:
    played.outcome = outcome
    assert atom("do", "explore").exit_code == code


def test_a_question_is_answered_and_not_followed(played: Played) -> None:
    result = atom("do", "count", "--thing", "cups")
    assert (result.exit_code, played.asked) == (0, [("POST", "/actions")])
    assert "Three." in result.output
    assert "memory is away" in result.output


@pytest.mark.parametrize(
    "said",
    [
        ("drive", "--distance-m", "9"), ("drive", "--distance-m", "nan"), ("drive",), ("rotate", "--angle-rad", "inf"),
        ("go-to",), ("go-to", "--room", "hall", "--thing", "cup"), ("set-velocity",), ("drive", "--speed", "1"),
        ("find", "--thing", "cup; stop"), ("patrol",),
    ],
)  # fmt: skip
def test_what_is_out_of_bounds_is_wrong_usage_and_nothing_is_sent(played: Played, said: tuple[str, ...]) -> None:
    assert (atom("do", *said).exit_code, played.asked) == (2, [])


@pytest.mark.parametrize("name", ActionName)
def test_every_action_has_its_help(played: Played, name: ActionName) -> None:
    result = atom("do", name.value.replace("_", "-"), "--help")
    assert result.exit_code == 0
    assert SPECS[name].sentence.split()[0] in result.output
    assert played.asked == []


def test_a_stop_needs_no_key_and_one_that_is_not_confirmed_becomes_the_emergency_stop(played: Played) -> None:
    assert atom("do", "stop").exit_code == 0
    assert (played.asked, played.keys) == ([("POST", "/actions/stop")], [None])
    played.still = False
    result = atom("do", "stop")
    assert "emergency stop is set" in result.output
    assert (played.asked[-1], played.keys[-1]) == (("POST", "/emergency-stop"), None)


def test_a_refusal_is_told_with_its_exit_code(played: Played) -> None:
    played.problem = (409, "the emergency stop is latched: reset it first")
    result = atom("do", "explore")
    assert (result.exit_code, "the emergency stop is latched" in result.output) == (3, True)


def test_pause_and_cancel_are_short_for_their_actions(played: Played) -> None:
    assert atom("pause").exit_code == 0
    assert atom("cancel", "m-1").exit_code == 0
    assert played.bodies == [{"action": "pause"}, {"action": "cancel", "mission_id": "m-1"}]
    assert atom("cancel", "../state").exit_code == 2


def test_the_history_tells_how_each_ended(played: Played) -> None:
    result = atom("history", "--limit", "5")
    assert (result.exit_code, "so it ended" in result.output) == (0, True)
    assert atom("history", "--limit", "0").exit_code == 2
    assert played.asked == [("GET", "/missions")]


def test_it_tells_its_version() -> None:
    result = atom("--version")
    assert (result.exit_code, result.output.strip()) == (0, f"atom {version('atom-cli')}")
