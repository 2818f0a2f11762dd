"""The page's way to the speech service: what was said comes back, a stop acts first, and who is away is named."""

import time
from collections.abc import Generator
from contextlib import contextmanager

import numpy as np
import pytest
from starlette.testclient import TestClient, WebSocketTestSession

from clients.speech import SpeechClient
from contracts.intent import Intent, Understood, WantedAction
from contracts.problem import DependencyState
from contracts.reading import Mood
from contracts.speech import NOT_HELD, SPOKEN_CHARACTERS_MAX, SpeakRequest
from mesh.clock import Clock, SystemClock
from mesh.errors import UnavailableError, UnprocessableError
from speech.app import create_app as create_speech
from speech.settings import Settings as SpeechSettings
from support.served import served
from support.speech_fakes import FakeRecognizer, FakeSynthesizer, LoudActivity
from support.ui_world import UiWorld, fresh_nicegui, hearing
from support.waiting import until
from ui.app import create_app
from ui.desk import Desk
from ui.hearing import UNDERSTOOD_S, Saying
from ui.routes.speech import AGAIN_S, CHUNK_BYTES_MAX, INSIST_S
from ui.settings import Settings

SOUND = b"\1\0" * 1600


class HastyClock(SystemClock):
    """Whoever sleeps on it is awake at once, and so much later."""

    def __init__(self) -> None:
        super().__init__()
        self.slept_s = 0.0

    def now_s(self) -> float:
        return super().now_s() + self.slept_s

    async def sleep(self, seconds: float) -> None:
        self.slept_s += seconds if seconds == AGAIN_S else 0.0
        await super().sleep(0.0 if seconds == AGAIN_S else seconds)


@contextmanager
def page(world: UiWorld, *, with_speech: bool = True, clock: Clock | None = None) -> Generator[TestClient]:
    fresh_nicegui()
    app = create_app(
        Settings(),
        bus=world.bus,
        robot=world.robot,
        inference=world.inference.client(),
        missions=world.missions,
        memory=world.memory,
        speech=world.speech if with_speech else None,
        on_death=lambda: None,
        clock=clock,
    )
    with TestClient(app, base_url="http://127.0.0.1:8080") as client:
        yield client


def told(socket: WebSocketTestSession) -> Saying:
    return Saying.model_validate_json(socket.receive_text())


def outcome(socket: WebSocketTestSession) -> Saying:
    """The final one, which follows the one that says that it is heard out."""
    while not (saying := told(socket)).final:
        pass
    assert saying.heard_out
    return saying


def test_what_was_said_is_shown_as_it_comes_and_then_what_it_means(world: UiWorld) -> None:
    world.speech.readings = (hearing("find", final=False), hearing("Find the red bottle."))
    with page(world) as client, client.websocket_connect("/speech/listen") as socket:
        socket.send_bytes(SOUND)
        first = told(socket)
        socket.send_text("")
        last = outcome(socket)
        closed = socket.receive()
    assert (first.final, first.text, first.command) == (False, "find", "")
    assert (last.final, last.command, last.offers, last.stopped) == (True, "Find the red bottle.", (), None)
    assert closed["code"] == 1000
    assert bytes(world.speech.ears[0].heard) == SOUND
    assert world.missions.commands == [], "what was heard begins nothing by itself"


def test_a_held_button_is_told_on_and_so_is_a_tap(world: UiWorld) -> None:
    world.speech.readings = (hearing("find", final=False), hearing("Find the red bottle."))
    with page(world) as client, client.websocket_connect("/speech/listen?held=true") as socket:
        socket.send_bytes(SOUND)
        told(socket)
        held = world.speech.ears[0].held
        socket.send_text(NOT_HELD)
        socket.send_text("")
        outcome(socket)
    assert (held, world.speech.ears[0].held) == (True, False)


def test_two_readings_that_mean_different_things_are_a_question(world: UiWorld) -> None:
    world.speech.readings = (hearing("find the blue cap", "find the blue cup"),)
    with page(world) as client, client.websocket_connect("/speech/listen") as socket:
        socket.send_text("")
        last = outcome(socket)
    assert world.missions.understands == [("find the blue cup", "find the blue cap")], "with our names expected first"
    assert (last.command, [one.command for one in last.offers]) == ("", ["find the blue cup", "find the blue cap"])
    assert "or find the blue cap?" in last.question


def test_while_the_coordinator_is_away_the_readings_themselves_are_offered(world: UiWorld) -> None:
    world.missions.away = True
    world.speech.readings = (hearing("find the blue cap", "find the blue cup"),)
    with page(world) as client, client.websocket_connect("/speech/listen") as socket:
        socket.send_text("")
        last = outcome(socket)
    assert [one.command for one in last.offers] == ["find the blue cup", "find the blue cap"]


def test_a_spoken_stop_reaches_the_robot_before_the_page_is_told_and_once(world: UiWorld) -> None:
    world.speech.readings = (hearing("stop", final=False, stop=True), hearing("Stop it.", stop=True))
    with page(world) as client, client.websocket_connect("/speech/listen") as socket:
        socket.send_bytes(SOUND)
        first = told(socket)
        stopped = [one.reason for one in world.robot.stops]
        socket.send_text("")
        last = outcome(socket)
    assert (first.final, first.stopped, stopped) == (False, True, ["said: stop"])
    assert (last.stopped, last.command, len(world.robot.stops)) == (True, "", 1)
    assert world.missions.understands == [], "a stop is nothing to be read"


def test_a_spoken_stop_that_does_not_arrive_says_so_and_is_asked_for_again(world: UiWorld) -> None:
    world.robot.away = True
    world.speech.readings = (hearing("stop", final=False, stop=True), hearing("stop", stop=True))
    with page(world) as client, client.websocket_connect("/speech/listen") as socket:
        socket.send_bytes(SOUND)
        assert told(socket).stopped is False
        world.robot.away = False
        socket.send_text("")
        assert outcome(socket).stopped is True


def test_the_page_is_told_that_it_is_heard_out_before_anybody_is_asked_what_it_means(world: UiWorld) -> None:
    world.missions.hangs = True
    world.speech.readings = (hearing("find the blue cap", "find the blue cup"),)
    with page(world) as client, client.websocket_connect("/speech/listen") as socket:
        socket.send_text("")
        heard = told(socket)
        began_s = time.monotonic()
        last = outcome(socket)
        took_s = time.monotonic() - began_s
    assert (heard.heard_out, heard.final, heard.text) == (True, False, "find the blue cap")
    assert [one.command for one in last.offers] == ["find the blue cup", "find the blue cap"]
    assert took_s < UNDERSTOOD_S + 5.0, "a coordinator that hangs is not waited for"


def test_a_stop_in_the_last_reading_is_asked_for_until_it_arrives(world: UiWorld) -> None:
    world.robot.away = True
    world.speech.readings = (hearing("stop", stop=True),)
    with page(world) as client, client.websocket_connect("/speech/listen") as socket:
        socket.send_text("")
        first = told(socket)
        world.robot.away = False
        last = outcome(socket)
    assert (first.heard_out, first.stopped, last.stopped) == (True, False, True)
    assert [one.reason for one in world.robot.stops] == ["said: stop"]


def test_a_stop_in_the_last_reading_that_never_arrives_is_given_up_after_a_while(world: UiWorld) -> None:
    world.robot.away = True
    world.speech.readings = (hearing("stop", stop=True),)
    clock = HastyClock()
    with page(world, clock=clock) as client, client.websocket_connect("/speech/listen") as socket:
        socket.send_text("")
        last = outcome(socket)
    assert (last.stopped, clock.slept_s) == (False, pytest.approx(INSIST_S, abs=AGAIN_S))


def test_a_stop_is_asked_for_until_it_arrives_where_speech_dies_behind_it(world: UiWorld) -> None:
    world.robot.away = True
    world.speech.readings = (hearing("stop", final=False, stop=True), hearing("stop", stop=True))
    with page(world) as client, client.websocket_connect("/speech/listen") as socket:
        socket.send_bytes(SOUND)
        assert told(socket).stopped is False
        world.speech.away = True
        world.robot.away = False
        socket.send_text("")
        assert (told(socket).stopped, socket.receive()["code"]) == (True, 1011)


@pytest.mark.parametrize("action", [WantedAction.STOP, WantedAction.EMERGENCY])
def test_what_the_coordinator_understands_as_a_stop_is_one(world: UiWorld, action: WantedAction) -> None:
    world.missions.understood = Understood(intent=Intent(action=action, command="robot stop", mood=Mood.STOP))
    world.speech.readings = (hearing("row boat's top", "robot stop"),)
    with page(world) as client, client.websocket_connect("/speech/listen") as socket:
        socket.send_text("")
        last = outcome(socket)
    assert (last.stopped, last.text, last.command) == (True, "robot stop", "")
    assert [one.reason for one in world.robot.stops] == ["said: robot stop"]


def test_a_stop_is_heard_out_when_the_page_is_gone(world: UiWorld) -> None:
    world.speech.readings = (hearing("stop", stop=True),)
    with page(world) as client:
        with client.websocket_connect("/speech/listen") as socket:
            socket.send_bytes(SOUND)
        client.portal.call(until, lambda: world.robot.stops != [])  # pyright: ignore[reportOptionalMemberAccess]
    assert [one.reason for one in world.robot.stops] == ["said: stop"]


@pytest.mark.parametrize("bad", [b"odd", b"\0" * (CHUNK_BYTES_MAX + 2), "words"])
def test_what_is_no_sound_is_refused(world: UiWorld, bad: bytes | str) -> None:
    world.speech.readings = (hearing(""),)
    with page(world) as client, client.websocket_connect("/speech/listen") as socket:
        socket.send_bytes(bad) if isinstance(bad, bytes) else socket.send_text(bad)
        closed = socket.receive()
    assert (closed["code"], closed["reason"]) == (1003, "That is no sound.")
    assert bytes(world.speech.ears[0].heard) == b""


def test_speech_that_is_away_or_dies_while_it_listens_is_named(world: UiWorld) -> None:
    world.speech.readings = (hearing("find the"),)
    with page(world) as client:
        with client.websocket_connect("/speech/listen") as socket:
            socket.send_bytes(SOUND)
            world.speech.away = True
            socket.send_text("")
            assert socket.receive()["reason"] == "speech: not reachable"
        with client.websocket_connect("/speech/listen") as socket:
            assert socket.receive()["code"] == 1011
        assert client.post("/speech/speak", json={"text": "hello"}).status_code == 503


def test_without_a_speech_service_the_page_says_so(world: UiWorld) -> None:
    with page(world, with_speech=False) as client:
        with client.websocket_connect("/speech/listen") as socket:
            assert socket.receive()["reason"] == "This page has no speech service."
        assert client.post("/speech/speak", json={"text": "hello"}).status_code == 404


def test_an_answer_is_spoken_and_one_that_is_too_long_is_not(world: UiWorld) -> None:
    with page(world) as client:
        answer = client.post("/speech/speak", json={"text": "I saw it in the kitchen."})
        long = client.post("/speech/speak", json={"text": "a" * (SPOKEN_CHARACTERS_MAX + 1)})
    assert (answer.headers["content-type"], answer.content[:4]) == ("audio/wav", b"RIFF")
    assert (world.speech.spoken, long.status_code) == (["I saw it in the kitchen."], 422)


async def test_the_page_is_ready_without_speech_and_warns_of_it(world: UiWorld) -> None:
    desk = Desk(
        settings=Settings(),
        bus=world.bus,
        robot=world.robot,
        inference=world.inference.client(),
        missions=world.missions,
        memory=world.memory,
        speech=world.speech,
        clock=SystemClock(),
    )
    assert "speech" not in {one.name for one in await desk.dependencies()}
    world.speech.away = True
    lack = {one.name: one for one in await desk.dependencies()}["speech"]
    assert (lack.state, lack.ok) == (DependencyState.WARNING, True)
    await desk.refresh()
    shown = {one.name: one.state for one in desk.facts.services}
    assert shown["speech"] is DependencyState.UNREACHABLE, "the page names it as away"


# the real client and the real service, on a recogniser without a model


async def test_the_client_hears_and_speaks_through_the_real_service() -> None:
    recognizer = FakeRecognizer()
    app = create_speech(
        SpeechSettings(), recognizer=recognizer, activity=LoudActivity(), synthesizers=[FakeSynthesizer()]
    )
    loud = (np.full(16_000, 0.3) * 32767).astype("<i2").tobytes()
    async with served(app) as url:
        client = SpeechClient(Settings(speech_url=url))
        async with client.listen(["tea pot"]) as ears:
            for at in range(0, len(loud), 3200):
                await ears.send(loud[at : at + 3200])
            await ears.end()
            heard = [one async for one in ears.hearings()]
            await ears.send(loud[:3200])  # too late, and no harm
        assert (heard[-1].final, heard[-1].transcript.hot_text) == (True, "find the cup")
        assert any("tea pot" in one for one in recognizer.hot_words)
        async with client.listen([], held=True) as ears:
            for at in range(0, len(loud), 3200):
                await ears.send(loud[at : at + 3200])
            await ears.send(bytes(64_000))
            await ears.not_held()
            await ears.send(bytes(3200))
            assert [one async for one in ears.hearings()][-1].final, "silence ends it where it is not held"
        assert (await client.speak(SpeakRequest(text="hello")))[:4] == b"RIFF"
        with pytest.raises(UnprocessableError):  # a failure of who asked, not of speech
            await client.speak(SpeakRequest(text="hello", voice="nobody"))
        assert (await client.dependency()).ok
        async with client.listen([]) as ears:
            await ears.send(b"odd")
            with pytest.raises(UnavailableError, match="speech: truncated"):
                [one async for one in ears.hearings()]
        await client.aclose()


async def test_the_client_names_a_service_that_is_not_there() -> None:
    client = SpeechClient(Settings(speech_url="http://127.0.0.1:9"))
    with pytest.raises(UnavailableError, match="speech: not reachable"):
        async with client.listen([]):
            pass
    with pytest.raises(UnavailableError, match="speech: not reachable"):
        await client.speak(SpeakRequest(text="hello"))
    assert (await client.dependency()).state is DependencyState.UNREACHABLE
    await client.aclose()


async def test_hot_words_of_a_script_that_is_long_when_encoded_are_cut_and_not_refused() -> None:
    app = create_speech(
        SpeechSettings(), recognizer=FakeRecognizer(), activity=LoudActivity(), synthesizers=[FakeSynthesizer()]
    )
    names = [f"{'蘭' * 38}{number}" for number in range(32)]
    async with served(app) as url:
        client = SpeechClient(Settings(speech_url=url))
        async with client.listen(names) as ears:
            await ears.end()
            assert [one.final async for one in ears.hearings()] == [True]
        await client.aclose()
