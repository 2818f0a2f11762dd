"""`atom listen` against services that a transport plays: what it says, asks, sends, and what it does not ask about."""

import io
import sys
import types
import wave
from collections.abc import Callable
from pathlib import Path

import httpx
import pytest
from typer.testing import CliRunner, Result

from atom_cli import __main__ as cli
from atom_cli import microphone
from contracts.base import Message
from contracts.intent import Choice, Intent, Understood, WantedAction
from contracts.memory import LabelCount
from contracts.mission import Heard
from contracts.reading import Mood
from contracts.robot import EmergencyStop, EmergencyStopReply
from contracts.speech import Transcript

runner = CliRunner()


def transcript(text: str, hot_text: str, *, stop: bool = False) -> Transcript:
    return Transcript(
        text=text,
        hot_text=hot_text,
        agree=text == hot_text,
        stop=stop,
        no_speech=not text,
        language="en",
        duration_s=1.0,
        took_ms=1.0,
        engine="played",
    )


def intent(command: str, *, able: str = "") -> Intent:
    return Intent(action=WantedAction.FIND, command=command, mood=Mood.FIND, able=able)


class Spoken:
    """Speech, memory and the coordinator; an order sent on is heard and nothing more."""

    def __init__(self, heard: Transcript, understood: Understood | None = None) -> None:
        self.heard, self.understood = heard, understood
        self.asked: list[httpx.Request] = []
        self.away: set[int] = set()

    def __call__(self, request: httpx.Request) -> httpx.Response:
        self.asked.append(request)
        if request.url.port in self.away:
            raise httpx.ConnectError("refused")
        if request.url.path == "/labels":
            return httpx.Response(
                200,
                json=[
                    LabelCount(label="tea pot", views=1, best_confidence=0.9, last_seen_s=1.0).model_dump(mode="json")
                ],
            )
        answers: dict[str, Message | None] = {
            "/transcribe": self.heard,
            "/understand": self.understood,
            "/missions": Heard(mood=Mood.FIND, text="sent", still=False),
            "/emergency-stop": EmergencyStopReply(state=EmergencyStop(latched=True, epoch=1), first_zero_ms=0.8),
        }
        answer = answers[request.url.path]
        assert answer is not None
        return httpx.Response(200, text=answer.model_dump_json())

    @property
    def paths(self) -> list[str]:
        return [one.url.path for one in self.asked]


@pytest.fixture
def listened(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Callable[..., Result]:
    file = tmp_path / "said.wav"
    file.write_bytes(b"RIFF")

    def run(played: Spoken, *arguments: str, said: str = "") -> Result:
        monkeypatch.setattr(cli, "transport", httpx.MockTransport(played))
        return runner.invoke(cli.app, ["listen", "--file", str(file), *arguments], input=said)

    return run


def test_what_was_heard_is_said_and_sent_when_a_person_agrees(listened: Callable[..., Result]) -> None:
    played = Spoken(transcript("Find the cap.", "find the cup"), Understood(intent=intent("find the cup")))
    result = listened(played, said="y\n")
    assert (result.exit_code, "Find the cap." in result.output, "find the cup" in result.output) == (0, True, True)
    assert played.paths == ["/labels", "/transcribe", "/understand", "/missions"]
    assert played.asked[1].url.params.get_list("hot_words") == ["tea pot"]


def test_nothing_is_sent_that_a_person_does_not_want(listened: Callable[..., Result]) -> None:
    played = Spoken(transcript("Find it.", "Find it."), Understood(intent=intent("find it")))
    assert listened(played, said="n\n").exit_code == 1
    assert "/missions" not in played.paths


def test_an_order_to_stop_is_not_asked_about_and_needs_no_coordinator(listened: Callable[..., Result]) -> None:
    played = Spoken(transcript("Top.", "stop", stop=True))
    played.away = {8001, 8003}
    result = listened(played)
    assert (result.exit_code, played.paths[-1]) == (0, "/emergency-stop")
    assert "stopped" in result.output


def test_what_may_mean_two_things_is_asked_back(listened: Callable[..., Result]) -> None:
    choices = tuple(Choice(text=one, intent=intent(one)) for one in ("find the cup", "find the cap"))
    asked = Understood(question="Did you mean: the cup, or the cap?", choices=choices)
    played = Spoken(transcript("the cap", "the cup"), asked)
    assert listened(played, said="2\n").exit_code == 0
    assert b"find the cap" in played.asked[-1].content
    assert listened(played, said="0\n").exit_code == 1
    assert listened(played, "--send").exit_code == 11


def test_what_the_robot_cannot_do_is_said_before_it_is_sent(listened: Callable[..., Result]) -> None:
    able = "I have no arm: I find it and drive up to it."
    result = listened(Spoken(transcript("a", "a"), Understood(intent=intent("bring it", able=able))), "--send")
    assert (result.exit_code, able in result.output) == (0, True)


def test_silence_and_a_service_that_is_away_have_codes_of_their_own(listened: Callable[..., Result]) -> None:
    assert listened(Spoken(transcript("", ""))).exit_code == 1
    played = Spoken(transcript("a", "a"))
    played.away = {8005}
    assert listened(played).exit_code == 4


def test_a_file_that_is_not_there_is_wrong_usage() -> None:
    assert runner.invoke(cli.app, ["listen", "--file", "/nowhere.wav"]).exit_code == 2


def test_without_its_library_the_microphone_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "sounddevice", None)
    result = runner.invoke(cli.app, ["listen"], input="\n")
    assert (result.exit_code, "atom-cli[listen]" in result.output) == (2, True)


class PlayedStream:
    """sounddevice's stream, as far as it is used; there is no microphone where the tests run."""

    def __init__(self, *, samplerate: int, channels: int, dtype: str, callback: Callable[..., None]) -> None:
        assert (samplerate, channels, dtype) == (16_000, 1, "int16")
        self._callback = callback

    def __enter__(self) -> None:
        for _ in range(20):
            self._callback(b"\1\0" * 16_000, 16_000, None, None)

    def __exit__(self, *_: object) -> None: ...


def test_fifteen_seconds_of_what_is_said_are_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    module = types.SimpleNamespace(RawInputStream=PlayedStream, PortAudioError=RuntimeError)
    monkeypatch.setitem(sys.modules, "sounddevice", module)
    with wave.open(io.BytesIO(microphone.recorded(lambda: None))) as file:
        assert (file.getframerate(), file.getnframes()) == (16_000, 15 * 16_000)
