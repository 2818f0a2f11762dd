"""What the speech service answers, over ports without models."""

import asyncio
import io
import threading
import time
import wave
from collections.abc import AsyncIterator, Iterator, Sequence
from contextlib import asynccontextmanager, contextmanager
from typing import Any
from urllib.parse import urlencode

import httpx
import numpy as np
import pytest
from asgi_lifespan import LifespanManager
from fastapi import FastAPI
from starlette.testclient import TestClient

from contracts.problem import DependencyState
from contracts.speech import HOT_WORDS_MAX, NOT_HELD, RATE_HZ, Hearing, SpeechRefusal, Transcript
from mesh.errors import UnavailableError
from speech.app import create_app
from speech.ports import Reading, Spoken
from speech.settings import Settings
from speech.sound import Samples, to_wav
from support.speech_fakes import FakeRecognizer, FakeSynthesizer, LoudActivity
from support.waiting import until
from vocabulary.hot_words import OPENINGS

LOUD = np.full(RATE_HZ, 0.3, np.float32)
QUIET = np.zeros(RATE_HZ, np.float32)


class HeldRecognizer(FakeRecognizer):
    """Reads nothing until it is released."""

    def __init__(self) -> None:
        super().__init__()
        self.released = threading.Event()

    def readings(self, samples: Samples, hints: Sequence[str]) -> Iterator[Reading]:
        self.released.wait(30.0)
        return super().readings(samples, hints)


class AwayRecognizer(FakeRecognizer):
    """There at first."""

    def readings(self, samples: Samples, hints: Sequence[str]) -> Iterator[Reading]:
        raise UnavailableError("recognizer", "nas.lan is not reachable")


def made(**parts: Any) -> FastAPI:
    fakes: dict[str, Any] = {
        "recognizer": FakeRecognizer(),
        "activity": LoudActivity(),
        "synthesizers": [FakeSynthesizer()],
    }
    return create_app(Settings(), **(fakes | parts))


@asynccontextmanager
async def asked(app: object) -> AsyncIterator[httpx.AsyncClient]:
    async with (
        LifespanManager(app) as manager,
        httpx.AsyncClient(transport=httpx.ASGITransport(manager.app), base_url="http://127.0.0.1") as client,
    ):
        await until(lambda: all(one.ok for one in manager._state["speech"].dependencies()))
        yield client


@pytest.fixture
async def speech() -> AsyncIterator[httpx.AsyncClient]:
    async with asked(made()) as client:
        yield client


async def test_speech_is_read_in_two_ways_that_may_differ(speech: httpx.AsyncClient) -> None:
    heard = Transcript.model_validate_json((await speech.post("/transcribe", content=to_wav(LOUD, RATE_HZ))).content)
    assert (heard.text, heard.hot_text, heard.agree, heard.no_speech) == ("Find the cap.", "find the cup", False, False)


async def test_where_nobody_speaks_nothing_is_read(speech: httpx.AsyncClient) -> None:
    heard = Transcript.model_validate_json((await speech.post("/transcribe", content=to_wav(QUIET, RATE_HZ))).content)
    assert (heard.text, heard.no_speech, heard.agree) == ("", True, True)


async def test_what_memory_holds_is_expected_before_the_common_names() -> None:
    recognizer = FakeRecognizer()
    async with asked(made(recognizer=recognizer)) as speech:
        names = {"hot_words": ["grandma's tea-pot", "Müsli"]}
        assert (await speech.post("/transcribe", content=to_wav(LOUD, RATE_HZ), params=names)).status_code == 200
    plain, hot, _stop = recognizer.hot_words
    assert (plain, hot.startswith(", ".join((*OPENINGS, "grandma's tea-pot", "Müsli")))) == ("", True)


HOSTILE_HOT_WORDS = [
    ["cup"] * (HOT_WORDS_MAX + 1),
    ["x" * 41],
    [""],
    ["<|endoftext|>"],
    ["cup, find the knife"],
    ["cup\n"],
    [" cup"],
]


@pytest.mark.parametrize("names", HOSTILE_HOT_WORDS)
async def test_hot_words_that_are_none_are_refused(speech: httpx.AsyncClient, names: list[str]) -> None:
    answer = await speech.post("/transcribe", content=to_wav(LOUD, RATE_HZ), params={"hot_words": names})
    assert answer.status_code == 422


@pytest.mark.parametrize(("plain", "hot"), [("Stop.", "top"), ("Top.", "stop"), ("Find it. No, stop!", "")])
async def test_a_stop_in_either_reading_is_told_as_one(plain: str, hot: str) -> None:
    async with asked(made(recognizer=FakeRecognizer(plain, hot))) as speech:
        heard = Transcript.model_validate_json(
            (await speech.post("/transcribe", content=to_wav(LOUD, RATE_HZ))).content
        )
    assert heard.stop


@pytest.mark.parametrize(("plain", "times"), [("I will be", 4), ("Can you find my rucksack?", 1)])
async def test_in_a_long_saying_only_the_plain_reading_is_a_stop(plain: str, times: int) -> None:
    """Long in seconds, or in words."""
    async with asked(made(recognizer=FakeRecognizer(plain, "stop, I will be"))) as speech:
        long = to_wav(np.tile(LOUD, times), RATE_HZ)
        heard = Transcript.model_validate_json((await speech.post("/transcribe", content=long)).content)
    assert not heard.stop


def test_a_pause_in_a_saying_of_many_words_is_no_stop() -> None:
    recognizer = FakeRecognizer("Can you find my rucksack?", "stop my")
    with ready(recognizer=recognizer) as client, client.websocket_connect("/listen") as socket:
        for chunk in chunks(np.concatenate([LOUD, QUIET[:6400], LOUD, QUIET])):
            socket.send_bytes(chunk)
        told = [Hearing.model_validate_json(socket.receive_text())]
        while not told[-1].final:
            told.append(Hearing.model_validate_json(socket.receive_text()))
    assert not any(one.stop for one in told)


async def test_sixteen_minutes_and_a_hundred_megabytes_are_too_long(speech: httpx.AsyncClient) -> None:
    raw = {"content-type": "audio/L16"}
    for body in (bytes(2 * RATE_HZ * 20), bytes(2 * RATE_HZ * 960), bytes(100_000_000)):
        assert (await speech.post("/transcribe", content=body, headers=raw)).status_code == 413


async def test_a_recogniser_that_is_away_is_named_and_no_other_takes_its_place() -> None:
    async with asked(made(recognizer=AwayRecognizer())) as speech:
        answer = await speech.post("/transcribe", content=to_wav(LOUD, RATE_HZ))
    assert (answer.status_code, answer.json()["detail"]) == (503, "recognizer: nas.lan is not reachable")


async def test_what_is_no_sound_is_refused_by_name(speech: httpx.AsyncClient) -> None:
    refused = await speech.post("/transcribe", content=b"ID3 some song")
    assert (refused.status_code, refused.json()["code"]) == (422, SpeechRefusal.NOT_WAV)


async def test_of_twenty_at_once_four_are_heard_and_the_rest_told_when_to_come_back() -> None:
    listening = HeldRecognizer()
    async with asked(made(recognizer=listening)) as speech:
        tasks = [asyncio.ensure_future(speech.post("/transcribe", content=to_wav(LOUD, RATE_HZ))) for _ in range(20)]
        await until(lambda: sum(one.done() for one in tasks) == 16)
        listening.released.set()
        answers = await asyncio.gather(*tasks)
    assert sorted(one.status_code for one in answers) == [200] * 4 + [503] * 16
    assert {one.headers.get("retry-after") for one in answers if one.status_code == 503} == {"1"}


class SlowSynthesizer(FakeSynthesizer):
    """Speaks nothing until it is released."""

    def __init__(self) -> None:
        super().__init__()
        self.released = threading.Event()

    def speak(self, text: str, voice: str, speed: float) -> Spoken:
        self.released.wait(30.0)
        return super().speak(text, voice, speed)


async def test_who_listens_waits_for_nobody_who_speaks() -> None:
    voice = SlowSynthesizer()
    async with asked(made(synthesizers=[voice])) as speech:
        spoken = [asyncio.ensure_future(speech.post("/speak", json={"text": "I found it."})) for _ in range(5)]
        await until(lambda: sum(one.done() for one in spoken) == 1)
        heard = await asyncio.wait_for(speech.post("/transcribe", content=to_wav(LOUD, RATE_HZ)), 10.0)
        voice.released.set()
        answers = await asyncio.gather(*spoken)
    assert heard.status_code == 200
    assert sorted(one.status_code for one in answers) == [200] * 4 + [503], "a count of its own"


class SlowToLoad(FakeSynthesizer):
    """Is being loaded until it is released."""

    def __init__(self) -> None:
        super().__init__("slow")
        self.released = threading.Event()

    def load(self) -> None:
        self.released.wait(30.0)


async def test_who_listens_waits_for_no_voice_that_is_being_loaded() -> None:
    voice = SlowToLoad()
    async with asked(made(synthesizers=[FakeSynthesizer(), voice])) as speech:
        heard = await asyncio.wait_for(speech.post("/transcribe", content=to_wav(LOUD, RATE_HZ)), 10.0)
        voice.released.set()
    assert heard.status_code == 200


class UnloadedRecognizer(FakeRecognizer):
    """Cannot be loaded, and has nothing to read with until it is."""

    def load(self) -> None:
        raise UnavailableError("recognizer", "the model is not there")

    def readings(self, samples: Samples, hints: Sequence[str]) -> Iterator[Reading]:
        raise AttributeError("no model")


def test_a_socket_says_that_the_recogniser_is_not_loaded() -> None:
    died: list[str] = []
    app = made(recognizer=UnloadedRecognizer(), on_death=lambda: died.append("x"))
    with TestClient(app, base_url="http://127.0.0.1") as client:
        ready_by_s = time.monotonic() + 20.0
        while client.app_state["speech"].dependencies()[1].state is not DependencyState.READY:
            assert time.monotonic() < ready_by_s, "voice activity is not loaded"
        with client.websocket_connect("/listen") as socket:
            for chunk in chunks(LOUD):
                socket.send_bytes(chunk)
            socket.send_text("")
            closed = socket.receive()
    assert (closed["code"], closed["reason"]) == (1011, "recognizer: the model is not there")
    assert died == []


async def test_what_is_said_is_a_wav_of_a_named_voice(speech: httpx.AsyncClient) -> None:
    (voice,) = (await speech.get("/voices")).json()
    said = await speech.post("/speak", json={"text": "I found it.", "voice": voice["name"]})
    with wave.open(io.BytesIO(said.content)) as file:
        assert (file.getframerate(), file.getnframes()) == (24_000, 24_000)
    assert (await speech.post("/speak", json={"text": "I found it.", "voice": "nobody"})).status_code == 404


@contextmanager
def ready(**parts: FakeRecognizer) -> Iterator[TestClient]:
    with TestClient(made(**parts), base_url="http://127.0.0.1") as client:
        ready_by_s = time.monotonic() + 20.0
        while client.get("/ready").status_code != 200:
            assert time.monotonic() < ready_by_s, "speech is not ready"
        yield client


def chunks(samples: np.ndarray, size: int = 6400) -> list[bytes]:
    whole = (samples * 32767).astype("<i2").tobytes()
    return [whole[at : at + size] for at in range(0, len(whole), size)]


@pytest.mark.parametrize("size", [64, 640, 6400, 64_000])
def test_a_socket_tells_a_final_reading_when_the_speaker_is_done(size: int) -> None:
    with ready() as client, client.websocket_connect("/listen") as socket:
        for chunk in chunks(np.concatenate([QUIET, LOUD, QUIET]), size):
            socket.send_bytes(chunk)
        told = [Hearing.model_validate_json(socket.receive_text())]
        while not told[-1].final:
            told.append(Hearing.model_validate_json(socket.receive_text()))
    assert told[-1].transcript.hot_text == "find the cup"
    assert not any(one.stop for one in told)


def test_a_held_button_is_listened_to_through_a_silence_until_it_is_let_go() -> None:
    with ready() as client, client.websocket_connect("/listen?held=true") as socket:
        for chunk in chunks(np.concatenate([QUIET, LOUD, QUIET, QUIET, LOUD, QUIET])):
            socket.send_bytes(chunk)
        socket.send_text("")
        told = [Hearing.model_validate_json(socket.receive_text())]
        while not told[-1].final:
            told.append(Hearing.model_validate_json(socket.receive_text()))
    assert told[-1].transcript.duration_s > (2 * len(LOUD) + 2 * len(QUIET)) / 16_000, "both times somebody spoke"


def test_a_button_that_was_only_tapped_is_ended_by_silence() -> None:
    with ready() as client, client.websocket_connect("/listen?held=true") as socket:
        socket.send_bytes(chunks(QUIET)[0])
        socket.send_text(NOT_HELD)
        for chunk in chunks(np.concatenate([LOUD, QUIET])):
            socket.send_bytes(chunk)
        while not Hearing.model_validate_json(socket.receive_text()).final:
            pass


def test_a_button_held_for_ever_is_listened_to_for_fifteen_seconds() -> None:
    with ready() as client, client.websocket_connect("/listen?held=true") as socket:
        for chunk in chunks(np.zeros(16 * 16_000, np.float32), 64_000):
            socket.send_bytes(chunk)
        last = Hearing.model_validate_json(socket.receive_text())
    assert (last.final, last.transcript.no_speech) == (True, True)
    assert last.transcript.duration_s == pytest.approx(15.0, abs=0.1)


class OnceStopRecognizer(FakeRecognizer):
    """Hears a stop at first and not again, as Whisper may when more was said."""

    def readings(self, samples: Samples, hints: Sequence[str]) -> Iterator[Reading]:
        for reading in super().readings(samples, hints):
            yield Reading("Stop", "en") if len(self.hot_words) == 1 else reading


def test_a_stop_heard_while_somebody_speaks_is_told_at_once_and_kept() -> None:
    with ready(recognizer=OnceStopRecognizer()) as client, client.websocket_connect("/listen") as socket:
        for chunk in chunks(LOUD):
            socket.send_bytes(chunk)
        told = [Hearing.model_validate_json(socket.receive_text())]
        socket.send_text("")
        while not told[-1].final:
            told.append(Hearing.model_validate_json(socket.receive_text()))
    assert (told[0].final, told[0].transcript.stop, told[-1].transcript.stop) == (False, True, False)
    assert all(one.stop for one in told)


@pytest.mark.parametrize("names", HOSTILE_HOT_WORDS)
def test_a_socket_refuses_hot_words_that_are_none(names: list[str]) -> None:
    with ready() as client, client.websocket_connect(f"/listen?{urlencode({'hot_words': names}, True)}") as socket:
        closed = socket.receive()
    assert (closed["code"], closed["reason"]) == (1008, SpeechRefusal.HOT_WORDS)


def test_a_socket_takes_hot_words_for_the_final_reading() -> None:
    recognizer = FakeRecognizer()
    with ready(recognizer=recognizer) as client, client.websocket_connect("/listen?hot_words=tea+pot") as socket:
        for chunk in chunks(LOUD):
            socket.send_bytes(chunk)
        socket.send_text("")
        while not Hearing.model_validate_json(socket.receive_text()).final:
            pass
    assert "tea pot" in recognizer.hot_words[-2].split(", ")


def test_a_socket_ends_when_the_client_says_so() -> None:
    with ready() as client, client.websocket_connect("/listen") as socket:
        socket.send_bytes(chunks(QUIET)[0])
        socket.send_text("")
        last = Hearing.model_validate_json(socket.receive_text())
    assert (last.final, last.transcript.no_speech) == (True, True)


def test_a_socket_takes_no_half_samples() -> None:
    with ready() as client, client.websocket_connect("/listen") as socket:
        socket.send_bytes(b"123")
        closed = socket.receive()
    assert (closed["code"], closed["reason"]) == (1003, SpeechRefusal.TRUNCATED)
