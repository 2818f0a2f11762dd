"""The embedded parts as they are installed: a voice speaks, Whisper hears, and is not asked where nobody speaks."""

from collections.abc import AsyncIterator

import httpx
import numpy as np
import pytest
import pytest_asyncio
from asgi_lifespan import LifespanManager

from contracts.speech import RATE_HZ, Transcript
from speech.app import create_app
from speech.settings import Settings
from speech.sound import to_wav
from support.waiting import until

pytestmark = pytest.mark.asyncio(loop_scope="module")

TIME_S = np.arange(5 * RATE_HZ) / RATE_HZ
NOTES = [0.1 * np.sin(2 * np.pi * hz * TIME_S) * np.exp(-4 * (TIME_S % 0.5)) for hz in (262, 330, 392, 523)]
NOT_SPEECH = {
    "silence": np.zeros(5 * RATE_HZ),
    "noise": np.random.default_rng(0).normal(0.0, 0.1, 5 * RATE_HZ),
    "tone": 0.3 * np.sin(2 * np.pi * 440 * TIME_S),
    "music": np.sum(NOTES, axis=0),
    "clicks": np.where(np.arange(5 * RATE_HZ) % 8000 == 0, 1.0, 0.0),
}


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def speech() -> AsyncIterator[httpx.AsyncClient]:
    async with (
        LifespanManager(create_app(Settings())) as manager,
        httpx.AsyncClient(
            transport=httpx.ASGITransport(manager.app), base_url="http://127.0.0.1", timeout=60.0
        ) as client,
    ):
        await until(lambda: all(one.ok for one in manager._state["speech"].dependencies()), timeout_s=60.0)
        yield client


@pytest.mark.parametrize("voice", ["heart", "espeak-en-us"])
async def test_what_a_voice_speaks_is_heard(speech: httpx.AsyncClient, voice: str) -> None:
    said = await speech.post("/speak", json={"text": "Find the red bottle.", "voice": voice})
    heard = Transcript.model_validate_json((await speech.post("/transcribe", content=said.content)).content)
    assert (heard.text, heard.agree, heard.no_speech) == ("Find the red bottle.", True, False)


@pytest.mark.parametrize("kind", NOT_SPEECH)
async def test_what_is_no_speech_is_no_words(speech: httpx.AsyncClient, kind: str) -> None:
    sound = to_wav(NOT_SPEECH[kind].astype(np.float32), RATE_HZ)
    heard = Transcript.model_validate_json((await speech.post("/transcribe", content=sound)).content)
    assert (heard.no_speech, heard.text) == (True, "")
