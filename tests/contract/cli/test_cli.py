"""`atom` against services that a transport plays: words, exit codes, and nothing but HTTP."""

import json

import httpx
import pytest
from typer.testing import CliRunner, Result

from atom_cli import __main__ as cli
from atom_cli import following
from contracts.asking import About, Answer
from contracts.base import Message
from contracts.mission import Heard, Outcome
from contracts.problem import Readiness
from contracts.reading import Mood
from contracts.robot import EmergencyStop, EmergencyStopReply
from support.ui_world import event, mission, robot_state, status, thing

runner = CliRunner()


class Played:
    """Answers as the services would; `away` names ports that do not answer."""

    def __init__(self) -> None:
        self.asked: list[tuple[str, str]] = []
        self.bodies: list[dict[str, object]] = []
        self.keys: list[str | None] = []
        self.away: set[int] = set()
        self.outcome = Outcome.FOUND
        self.refusal = ""
        self.heard: Heard | None = None
        self.polls = 0
        self.may = 200

    def __call__(self, request: httpx.Request) -> httpx.Response:
        port, path = request.url.port, request.url.path
        self.asked.append((request.method, f"{port}{path}"))
        self.keys.append(request.headers.get("authorization"))
        if port in self.away:
            raise httpx.ConnectError("refused")
        if request.content:
            self.bodies.append(json.loads(request.content))
        return self.answer(request.method, path)

    def answer(self, method: str, path: str) -> httpx.Response:
        if self.may != 200 and path != "/ready":
            return httpx.Response(
                self.may, json={"title": "Not permitted", "status": self.may, "detail": "not for you"}
            )
        if self.refusal and (method, path) == ("POST", "/missions"):
            return httpx.Response(422, json={"title": "Cannot be done", "status": 422, "detail": self.refusal})
        self.polls += path == "/missions/m-1"
        over = mission(outcome=self.outcome, reason="so it ended") if self.polls > 1 else mission()
        stopped = EmergencyStop(latched=True, epoch=1)
        answers: dict[tuple[str, str], Message | list[Message]] = {
            ("POST", "/missions"): self.heard or mission(),
            ("POST", "/ask"): Answer(answer="Three.", about=About.COUNT, phrased_by="template"),
            ("GET", "/missions/m-1"): over,
            ("GET", "/missions/m-1/events"): [event(1, "looking round")],
            ("GET", "/state"): robot_state() if self.asked[-1][1].startswith("8004") else status(mission()),
            ("GET", "/objects"): [thing(1)],
            ("GET", "/labels"): [],
            ("GET", "/ready"): Readiness(ready=True, service="any"),
            ("POST", "/emergency-stop"): EmergencyStopReply(state=stopped, first_zero_ms=0.8),
            ("POST", "/emergency-stop/reset"): EmergencyStopReply(state=EmergencyStop(latched=False, epoch=1)),
        }
        answer = answers[method, path]
        lines = (
            [one.model_dump(mode="json") for one in answer]
            if isinstance(answer, list)
            else answer.model_dump(mode="json")
        )
        return httpx.Response(200, json=lines)


@pytest.fixture
def played(monkeypatch: pytest.MonkeyPatch) -> Played:
    services = Played()
    monkeypatch.setattr(cli, "transport", httpx.MockTransport(services))
    monkeypatch.setattr(following, "POLL_S", 0.0)
    return services


def atom(*arguments: str, **more: str) -> Result:
    return runner.invoke(cli.app, list(arguments), **more)


@pytest.mark.parametrize(
    ("outcome", "code"),
    [(Outcome.FOUND, 0), (Outcome.NOT_FOUND, 10), (Outcome.UNSURE, 11), (Outcome.CANCELED, 12), (Outcome.ABORTED, 13)],
)
def test_find_tells_the_timeline_and_ends_with_the_outcome(played: Played, outcome: Outcome, code: int) -> None:
    played.outcome = outcome
    done = atom("find", "red bottle")
    assert done.exit_code == code
    assert "looking round" in done.output
    assert "so it ended" in done.output
    assert played.bodies == [{"command": "find the red bottle"}]


def test_every_outcome_has_an_exit_code() -> None:
    assert set(following.EXIT) == set(Outcome)


def test_a_whole_sentence_is_sent_as_it_is(played: Played) -> None:
    atom("find", "bring me the teddy bear")
    assert played.bodies == [{"command": "bring me the teddy bear"}]


@pytest.mark.parametrize(
    ("said", "sent"),
    [("bottle", "find the bottle"), ("my red cup", "find my red cup"), ("Find the book", "Find the book")],
)
def test_a_few_words_become_a_command(played: Played, said: str, sent: str) -> None:
    atom("find", said)
    assert played.bodies == [{"command": sent}]


@pytest.mark.parametrize(
    ("changes", "now", "said"),
    [
        ({}, {}, "42 s  SCANNING  turning to the next of 8 headings"),
        ({"paused": True}, {"progress": ""}, "42 s  paused, SCANNING  so far"),
        ({}, {"waiting_for": "memory, at most 20 s"}, "42 s  SCANNING  waiting for memory, at most 20 s"),
        ({"queue_position": 1}, {}, "queued, 1 before it"),
    ],
)
def test_the_line_below_the_timeline_tells_phase_seconds_and_what_is_next(
    changes: dict[str, object], now: dict[str, object], said: str
) -> None:
    of = mission(reason="so far", **changes)
    assert following.progress_of(of, status(of, **now)) == said  # pyright: ignore[reportPrivateUsage]


def test_a_refusal_is_told_in_the_services_words(played: Played) -> None:
    played.refusal = "'find the blorp' names nothing I know"
    done = atom("find", "blorp")
    assert (done.exit_code, "names nothing I know" in done.output) == (3, True)


def test_stop_goes_straight_to_the_bridge_and_tells_the_measured_time(played: Played) -> None:
    done = atom("stop")
    assert (done.exit_code, "0.8 ms" in done.output) == (0, True)
    assert played.asked == [("POST", "8004/emergency-stop")]


@pytest.mark.parametrize("key", ["a-key", "broken\rkey", "schlüssel", ""])
def test_a_stop_is_sent_without_a_key_so_that_none_can_be_in_its_way(
    played: Played, monkeypatch: pytest.MonkeyPatch, key: str
) -> None:
    monkeypatch.setenv("ATOM_KEY", key)
    assert atom("stop").exit_code == 0
    assert played.keys == [None]


@pytest.mark.parametrize(("key", "sent"), [(" a-key\r\n", "Bearer a-key"), ("broken\rkey", None), ("schlüssel", None)])
def test_what_no_key_can_be_is_said_and_not_sent(
    played: Played, monkeypatch: pytest.MonkeyPatch, key: str, sent: str | None
) -> None:
    monkeypatch.setenv("ATOM_KEY", key)
    done = atom("resume", input="y\n")
    assert (played.keys, "ATOM_KEY" in done.output) == ([sent], sent is None)


def test_a_stop_that_does_not_arrive_is_tried_again_and_told(played: Played) -> None:
    played.away = {8004}
    done = atom("stop")
    assert done.exit_code == 4
    assert "robot_bridge is not reachable" in done.output
    assert len(played.asked) == 3


def test_resume_asks_first(played: Played) -> None:
    assert atom("resume", input="n\n").exit_code == 1
    assert played.asked == []
    assert atom("resume", input="y\n").exit_code == 0
    assert played.asked == [("POST", "8004/emergency-stop/reset")]


def test_status_names_who_is_away(played: Played) -> None:
    assert atom("status").exit_code == 0
    played.away = {8003}
    done = atom("status")
    assert done.exit_code == 4
    assert "not reachable" in done.output
    assert "find the red bottle" in done.output


@pytest.mark.parametrize("order", [("status",), ("memory",), ("find", "cup"), ("resume", "--yes")])
@pytest.mark.parametrize(
    ("status", "key", "told"), [(401, "", "ATOM_KEY"), (401, "a-key", "ATOM_KEY"), (403, "a-key", "not for you")]
)
def test_who_may_not_is_told_where_a_key_comes_from_and_that_it_was_refused(
    played: Played, monkeypatch: pytest.MonkeyPatch, order: tuple[str, ...], status: int, key: str, told: str
) -> None:
    monkeypatch.setenv("ATOM_KEY", key)
    played.may = status
    done = atom(*order)
    assert done.exit_code == 3
    assert told in done.output


def test_of_a_service_that_is_away_and_one_that_refuses_the_first_is_told(played: Played) -> None:
    played.may, played.away = 401, {8003}
    assert atom("status").exit_code == 4


def test_memory_lists_things_with_belief(played: Played) -> None:
    done = atom("memory", "bottle")
    assert done.exit_code == 0
    assert "red bottle" in done.output
    assert "80 %" in done.output


def test_another_host_and_port_base_are_asked(played: Played) -> None:
    atom("stop", "--port-base", "9000")
    assert played.asked == [("POST", "9004/emergency-stop")]


@pytest.mark.parametrize(
    ("said", "host"),
    [
        ("::1", "::1"),
        ("[::1]", "::1"),
        ("fe80::1%eth0", "fe80::1%eth0"),
        ("http://127.0.0.1", "127.0.0.1"),
        ("http://127.0.0.1/", "127.0.0.1"),
        ("ROBOT.local", "robot.local"),
        ("robot.local.", "robot.local."),
        (" robot ", "robot"),
    ],
)
def test_a_host_is_understood_however_it_is_written(monkeypatch: pytest.MonkeyPatch, said: str, host: str) -> None:
    asked: list[httpx.URL] = []

    def away(request: httpx.Request) -> httpx.Response:
        asked.append(request.url)
        raise httpx.ConnectError("refused")

    monkeypatch.setattr(cli, "transport", httpx.MockTransport(away))
    done = atom("stop", "--host", said)
    assert (done.exit_code, {(one.host, one.port, one.path) for one in asked}) == (4, {(host, 8004, "/emergency-stop")})
    assert "robot_bridge is not reachable at http://" in done.output


@pytest.mark.parametrize(
    ("said", "why"),
    [
        ("", "is no name or address"),
        ("robot.local:9000", "say robot.local alone"),
        ("[::1]:9000", "say ::1 alone"),
        ("https://robot.local", "speak http, not https"),
        ("http://robot.local/page", "is no name or address"),
        ("me@robot.local", "is no name or address"),
        ("robot local", "is no name or address"),
        ("robot:port", "is no name or address"),
        (":::1", "is no name or address"),
    ],
)
def test_what_is_no_host_is_wrong_usage_and_says_why(played: Played, said: str, why: str) -> None:
    done = atom("stop", "--host", said)
    assert (done.exit_code, played.asked) == (2, [])
    assert why in " ".join(done.output.replace("│", " ").split())


@pytest.mark.parametrize("said", ["stop", "STOP!", "halt", "cancel that", "hör auf", "emergency stop"])
def test_a_typed_stop_that_nobody_confirms_becomes_the_emergency_stop(played: Played, said: str) -> None:
    played.away = {8001}
    result = atom("find", said)
    assert ("POST", "8004/emergency-stop") in played.asked
    assert (result.exit_code, "emergency stop is set" in result.output) == (0, True)


def test_a_typed_stop_is_sent_as_it_was_said_and_what_came_of_it_is_told(played: Played) -> None:
    played.heard = Heard(mood=Mood.STOP, text="Stopped: the mission is over.", ended=("m-1",), still=True)
    result = atom("find", "stop it")
    assert (played.bodies, "Stopped: the mission is over." in result.output) == ([{"command": "stop it"}], True)
    assert ("POST", "8004/emergency-stop") not in played.asked


@pytest.mark.parametrize("said", ["don't find the cup", "never mind", "thanks"])
def test_what_asks_for_nothing_is_not_made_a_search(played: Played, said: str) -> None:
    atom("find", said)
    assert played.bodies == [{"command": said}]


@pytest.mark.parametrize(("command", "said"), [("ask", "what changed?"), ("find", "how many bottles have you seen")])
def test_a_question_is_asked_not_searched(played: Played, command: str, said: str) -> None:
    result = atom(command, said)
    assert (played.bodies, "Three." in result.output) == ([{"question": said}], True)
