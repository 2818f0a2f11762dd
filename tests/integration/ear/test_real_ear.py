"""The real wake word, speech service, voice and HTTP clients: a sentence goes in as sound, a mission comes out."""

import asyncio
import io
import wave
from collections.abc import AsyncIterator
from dataclasses import dataclass
from pathlib import Path

import httpx
import numpy as np
import pytest
import pytest_asyncio

from contracts.mission import EventKind
from contracts.speech import RATE_HZ
from ear.__main__ import hear
from ear.adapters.wake_word import OpenWakeWordDetector
from ear.ports import CHUNK_BYTES
from ear.settings import Settings, WakeWord
from mesh.clock import SystemClock
from speech.app import create_app
from speech.settings import Settings as SpeechSettings
from speech.sound import from_wav, to_wav
from support.ear_fakes import RUNNING, FakeCoordinator, FakeLoudspeaker, FakeRobot, served_coordinator
from support.served import served
from support.waiting import until_true

pytestmark = [pytest.mark.asyncio(loop_scope="module"), pytest.mark.timeout(240)]
WAIT_S = 90.0


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def speech_url() -> AsyncIterator[str]:
    async with served(create_app(SpeechSettings())) as url, httpx.AsyncClient(base_url=url) as client:

        async def ready() -> bool:
            return (await client.get("/ready")).is_success

        await until_true(ready, timeout_s=WAIT_S)
        yield url


async def spoken(speech_url: str, text: str, voice: str = "heart") -> bytes:
    """Raw 16 kHz samples, a second of silence before and behind."""
    async with httpx.AsyncClient(base_url=speech_url, timeout=60.0) as client:
        wav = (await client.post("/speak", json={"text": text, "voice": voice})).raise_for_status().content
    silence = np.zeros(RATE_HZ, np.float32)
    with wave.open(io.BytesIO(to_wav(np.concatenate([silence, from_wav(wav), silence]), RATE_HZ))) as file:
        return file.readframes(file.getnframes())


def wakes(detector: OpenWakeWordDetector, samples: bytes) -> bool:
    chunks = [samples[at : at + CHUNK_BYTES] for at in range(0, len(samples) - CHUNK_BYTES + 1, CHUNK_BYTES)]
    found = any([detector.heard(chunk) for chunk in chunks])
    detector.forget()
    return found


@pytest.mark.parametrize("voice", ["heart", "espeak-en-us"])
async def test_the_wake_word_wakes_and_a_command_alone_does_not(speech_url: str, voice: str) -> None:
    detector = OpenWakeWordDetector(WakeWord.HEY_JARVIS, 0.5)
    said = ["hey jarvis", "hey jarvis, find the red bottle", "find the red bottle", "stop", "hey Charlie, come here"]
    woken = [wakes(detector, await spoken(speech_url, one, voice)) for one in said]
    assert woken == [True, True, False, False, False]


async def test_every_word_of_the_settings_has_its_model() -> None:
    assert [OpenWakeWordDetector(word, 0.5).heard(bytes(CHUNK_BYTES)) for word in WakeWord] == [False] * len(WakeWord)


@dataclass
class Room:
    """Somebody speaks (`samples`), an ear hears, and what the services were told is kept."""

    speech_url: str
    folder: Path
    coordinator: FakeCoordinator
    robot: FakeRobot
    loudspeaker: FakeLoudspeaker

    async def hears(self, samples: bytes) -> None:
        """To the end of what was said, and of what is done about it."""
        file = self.folder / "said.wav"
        file.write_bytes(_wav(samples))
        async with served(served_coordinator(self.coordinator, self.robot)) as url:
            settings = Settings(
                coordinator_url=url, robot_bridge_url=url, speech_url=self.speech_url, memory_url="", sound=str(file)
            )
            async with asyncio.timeout(WAIT_S):
                await hear(settings, loudspeaker=self.loudspeaker)


def _wav(samples: bytes) -> bytes:
    file = io.BytesIO()
    with wave.open(file, "wb") as out:
        out.setnchannels(1)
        out.setsampwidth(2)
        out.setframerate(RATE_HZ)
        out.writeframes(samples)
    return file.getvalue()


@pytest.fixture
def room(speech_url: str, tmp_path: Path) -> Room:
    return Room(speech_url, tmp_path, FakeCoordinator(running=RUNNING), FakeRobot(), FakeLoudspeaker())


async def test_a_command_in_one_breath_with_the_wake_word_is_understood_and_the_mission_stood_meanwhile(
    room: Room,
) -> None:
    await room.hears(await spoken(room.speech_url, "hey jarvis, find the red bottle"))
    (readings,) = room.coordinator.asked
    assert readings[0].lower().rstrip(".") == "find the red bottle"
    assert room.coordinator.commands == ["find the red bottle"]
    assert room.coordinator.holds == [30.0, 0.0]


async def test_stop_behind_the_wake_word_is_the_emergency_stop_and_is_said(room: Room) -> None:
    await room.hears(await spoken(room.speech_url, "hey jarvis, stop!"))
    assert len(room.robot.stops) == 1
    assert room.coordinator.commands == []
    assert room.loudspeaker.played[-1].startswith(b"RIFF")


async def test_stop_without_the_wake_word_stops_while_a_mission_runs(room: Room) -> None:
    await room.hears(await spoken(room.speech_url, "stop!"))
    assert len(room.robot.stops) == 1


async def test_talk_without_the_wake_word_reaches_nobody(room: Room) -> None:
    await room.hears(await spoken(room.speech_url, "could you please find the red bottle for me in the kitchen"))
    assert (room.coordinator.asked, room.coordinator.commands, room.robot.stops) == ([], [], [])


async def test_a_find_is_said_in_one_sentence(room: Room) -> None:
    room.coordinator.happens(EventKind.FOUND, SystemClock().now_s())
    await room.hears(bytes(4 * RATE_HZ * 2))
    (sentence,) = room.loudspeaker.played
    heard = await _transcribed(room.speech_url, sentence)
    assert "found the red bottle" in heard.lower()


async def _transcribed(speech_url: str, wav: bytes) -> str:
    async with httpx.AsyncClient(base_url=speech_url, timeout=60.0) as client:
        return (await client.post("/transcribe", content=wav)).json()["text"]
