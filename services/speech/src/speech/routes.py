"""The HTTP face: thin; every decision is made behind it."""

from typing import Annotated, Any, Final

from fastapi import APIRouter, Depends, Query, Request, WebSocket
from fastapi.responses import Response

from contracts.speech import HOT_WORDS_MAX, HotWord, SpeakRequest, SpeechRefusal, Transcript, Voice
from mesh.access import Role, requires_role
from mesh.errors import TooLargeError, UnprocessableError
from mesh.tracing import TracedRoute
from speech.listening import listen
from speech.metrics import REFUSED
from speech.sound import Samples, SoundError, from_pcm, from_wav
from speech.speech_service import SpeechService

router = APIRouter(route_class=TracedRoute)

PCM: Final = "audio/l16"
SOUND_BODY: dict[str, Any] = {
    "requestBody": {
        "required": True,
        "description": "a WAV of 16-bit PCM, 8 to 48 kHz, one or two channels; or raw little-endian 16-bit samples of "
        "16 kHz as audio/L16; at most 15 s",
        "content": {kind: {"schema": {"type": "string", "format": "binary"}} for kind in ("audio/wav", "audio/L16")},
    }
}
WAV_RESPONSE: dict[int | str, dict[str, Any]] = {200: {"description": "16-bit mono", "content": {"audio/wav": {}}}}


async def get_speech(request: Request) -> SpeechService:
    """Async, because FastAPI sends a plain function to another thread and back, on every call."""
    return request.state.speech


HotWords = Annotated[
    list[HotWord],
    Query(
        max_length=HOT_WORDS_MAX,
        description="names that the second reading leans towards before the common ones: what memory holds, the best "
        "first (`vocabulary.hot_words.sayable` chooses); what Whisper's limit does not hold is left out",
    ),
]
SpeechDep = Annotated[SpeechService, Depends(get_speech)]


@router.post("/transcribe", tags=["hearing"], openapi_extra=SOUND_BODY)
@requires_role(Role.OPERATOR)
async def transcribe(request: Request, speech: SpeechDep, hot_words: HotWords = []) -> Transcript:  # noqa: B006
    """What was said, read twice: as it sounds, and leaning towards names of things. 503 while too many wait."""
    body = await request.body()
    return await speech.transcribe(_samples(body, request.headers.get("content-type", "")), hot_words)


@router.websocket("/listen")
@requires_role(Role.OPERATOR)
async def listening(socket: WebSocket) -> None:
    """Raw 16 kHz samples in, `Hearing` out: partial readings, and a final one when the speaker is done. An empty text
    message ends it at once. With `?held=true` silence is no end, until a text message says `not held`. `?hot_words=` as
    for `POST /transcribe`. Closed with 1013 while too many are listened to, with 1003 for what is no sound, with 1008
    for what are no hot words."""
    query = socket.query_params
    await listen(socket, socket.state.speech, query.getlist("hot_words"), held=query.get("held") == "true")


@router.post("/speak", tags=["speaking"], response_class=Response, responses=WAV_RESPONSE)
@requires_role(Role.OPERATOR)
async def speak(body: SpeakRequest, speech: SpeechDep) -> Response:
    """The text as a WAV; 404 where no voice has that name."""
    return Response(await speech.speak(body), media_type="audio/wav")


@router.get("/voices", tags=["speaking"])
@requires_role(Role.VIEWER)
async def voices(speech: SpeechDep) -> list[Voice]:
    """Those that can speak here, the preferred first."""
    return speech.voices()


def _samples(body: bytes, content_type: str) -> Samples:
    raw = content_type.partition(";")[0].strip().lower() == PCM
    try:
        return from_pcm(body) if raw else from_wav(body)
    except SoundError as error:
        REFUSED.labels(error.refusal).inc()
        kind = TooLargeError if error.refusal is SpeechRefusal.TOO_LONG else UnprocessableError
        raise kind(error.detail, code=error.refusal) from error
