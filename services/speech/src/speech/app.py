"""Composition root: the only module that knows which parts are real."""

from collections.abc import AsyncGenerator, Callable, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from typing import TypedDict

from fastapi import FastAPI, Request

from contracts.problem import Dependency
from mesh.app import make_app
from mesh.clock import Clock, SystemClock
from mesh.tasks import Tasks, end_this_process
from speech.adapters.espeak import EspeakSynthesizer
from speech.adapters.hibari import HibariSynthesizer
from speech.adapters.openai_compatible import OpenAiRecognizer
from speech.adapters.piper import PiperSynthesizer
from speech.adapters.silero import SileroActivity
from speech.adapters.whisper import WhisperRecognizer
from speech.adapters.wyoming import WyomingRecognizer, WyomingSynthesizer
from speech.ports import Recognizer, Synthesizer, VoiceActivity
from speech.routes import get_speech, router
from speech.settings import RecognizerEngine, Settings, VoiceEngine
from speech.sound import BYTES_MAX
from speech.speech_service import SpeechService

VOICES: dict[VoiceEngine, Callable[[Settings], Synthesizer]] = {
    VoiceEngine.HIBARI: lambda _: HibariSynthesizer(),
    VoiceEngine.ESPEAK: lambda _: EspeakSynthesizer(),
    VoiceEngine.WYOMING: lambda of: WyomingSynthesizer(of.wyoming_voice, timeout_s=of.server_timeout_s),
    VoiceEngine.PIPER: lambda of: PiperSynthesizer(of.piper_voice),
}
RECOGNIZERS: dict[RecognizerEngine, Callable[[Settings], Recognizer]] = {
    RecognizerEngine.WHISPER: lambda of: WhisperRecognizer(
        of.whisper_model, language=of.language, threads=of.threads, download=of.whisper_download
    ),
    RecognizerEngine.OPENAI: lambda of: OpenAiRecognizer(
        of.openai_url,
        of.openai_model,
        language=of.language,
        timeout_s=of.server_timeout_s,
        api_key=of.openai_api_key.get_secret_value(),
    ),
    RecognizerEngine.WYOMING: lambda of: WyomingRecognizer(
        of.wyoming_recognizer, language=of.language, timeout_s=of.server_timeout_s
    ),
}


class State(TypedDict):
    speech: SpeechService


def create_app(
    settings: Settings,
    *,
    recognizer: Recognizer | None = None,
    activity: VoiceActivity | None = None,
    synthesizers: Sequence[Synthesizer] | None = None,
    clock: Clock | None = None,
    on_death: Callable[[], None] = end_this_process,
) -> FastAPI:
    """The service; whatever is not given is the real thing that `settings` name. It is not on the bus."""

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncGenerator[State]:
        async with AsyncExitStack() as stack:
            speech = SpeechService(
                settings=settings,
                clock=clock or SystemClock(),
                recognizer=recognizer or RECOGNIZERS[settings.recognizer](settings),
                activity=activity or SileroActivity(),
                synthesizers=(
                    [VOICES[one](settings) for one in settings.voice_engines] if synthesizers is None else synthesizers
                ),
            )
            stack.callback(speech.close)
            tasks = await stack.enter_async_context(Tasks(on_death=on_death))
            tasks.start("load", speech.load(), forever=False)
            yield {"speech": speech}

    async def dependencies(request: Request) -> Sequence[Dependency]:
        return (await get_speech(request)).dependencies()

    async def measure(request: Request) -> None:
        (await get_speech(request)).measure()

    app = make_app(
        "speech",
        lifespan=lifespan,
        dependencies=dependencies,
        settings=settings,
        measure=measure,
        body_bytes_max=BYTES_MAX,
        description="Hears and speaks: speech to text in two readings, text to speech. It moves nothing.",
    )
    app.include_router(router)
    return app
