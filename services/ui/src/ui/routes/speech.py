"""Speaking to the page: the microphone's samples go on to the speech service, its readings come back; answers aloud."""

import asyncio
import contextlib
from typing import Any, Final

import structlog
from fastapi import APIRouter, WebSocket, WebSocketDisconnect
from fastapi.responses import Response

from contracts.intent import WantedAction
from contracts.speech import NOT_HELD, Hearing, SpeakRequest
from mesh.access import Role, current_principal, requires_role
from mesh.errors import MeshError, NotFoundError
from mesh.tracing import TracedRoute
from ui.desk import Desk
from ui.hearing import Saying, hot_words_of, meant, understood_of
from ui.i18n import _
from ui.operator_actions import OperatorActions, in_words
from ui.ports import Ears
from ui.routes.deps import DeskDep, desk_of, operator

router = APIRouter(prefix="/speech", route_class=TracedRoute)
log = structlog.get_logger()

CHUNK_BYTES_MAX: Final = 64_000
"""What the speech service takes at a time: two seconds."""
STOPPING: Final = frozenset((WantedAction.STOP, WantedAction.EMERGENCY))
INSIST_S: Final = 5.0
"""So long a stop that did not reach the robot is asked for after the last reading,"""
AGAIN_S: Final = 0.3
"""each time so long after the last answer."""
WAV_RESPONSE: Final[dict[int | str, dict[str, Any]]] = {
    200: {"description": "16-bit mono", "content": {"audio/wav": {}}}
}


@router.websocket("/listen")
@requires_role(Role.OPERATOR)
async def listen(socket: WebSocket) -> None:
    """Raw 16 kHz 16-bit mono samples in, an empty text when the speaker is done; with `?held=true` silence is no end
    until a text says `not held`. Out, `Saying` as JSON: each reading as
    it comes, then that it is heard out, at which the page shuts its microphone, last the final one, with what it means.

    An order to stop in any reading, or what the coordinator understands as one, is the emergency stop: asked for here,
    before the page is told of it, again and again while it does not arrive; also when the page is gone by then. Closed
    with 1003 for what is no sound, with 1011 and the reason while speech is away.
    """
    desk = desk_of(socket)
    await socket.accept()
    try:
        if desk.speech is None:
            raise NotFoundError(_("This page has no speech service."))
        held = socket.query_params.get("held") == "true"
        async with desk.speech.listen(hot_words_of(desk.facts.remembered), held=held) as ears:
            forwarding = asyncio.ensure_future(_forward(socket, ears))
            try:
                await _Relay(socket, desk).run(ears)
            finally:
                forwarding.cancel()
                with contextlib.suppress(asyncio.CancelledError):
                    await forwarding
        await _close(socket, 1000, "")
    except MeshError as error:
        await _close(socket, 1011, in_words(error))


@router.post("/speak", response_class=Response, responses=WAV_RESPONSE)
@requires_role(Role.OPERATOR)
async def speak(body: SpeakRequest, desk: DeskDep) -> Response:
    """The text as a WAV. 404 where the page has no speech service, 503 while it is away."""
    if desk.speech is None:
        raise NotFoundError(_("This page has no speech service."))
    return Response(await desk.speech.speak(body), media_type="audio/wav")


async def _forward(socket: WebSocket, ears: Ears) -> None:
    """Until the page says that it is done, says what is no sound, or is gone: then what was said so far is read."""
    while True:
        message = await socket.receive()
        if message["type"] == "websocket.disconnect":
            break
        samples: bytes = message.get("bytes") or b""
        if message.get("text") == NOT_HELD:
            await ears.not_held()
            continue
        if message.get("text") or len(samples) > CHUNK_BYTES_MAX or len(samples) % 2:
            await _close(socket, 1003, _("That is no sound."))
            break
        if not samples:
            break
        await ears.send(samples)
    await ears.end()


class _Relay:
    """From what is heard to what the page is told, and to the one thing that does not wait for a person: a stop."""

    def __init__(self, socket: WebSocket, desk: Desk) -> None:
        self._socket = socket
        self._desk = desk
        self._actions = OperatorActions(desk, lambda: current_principal(socket))
        self._stopped: bool | None = None
        self._words = ""
        """Of the stop."""

    async def run(self, ears: Ears) -> None:
        try:
            async for hearing in ears.hearings():
                if hearing.stop and self._stopped is not True:
                    await self._stop(hearing.transcript.text)
                await self._tell(Saying.of(hearing, stopped=self._stopped))  # before others are asked: nobody listens
                if hearing.final:
                    await self._tell(await self._outcome(hearing))
        except MeshError:
            if self._stopped is False:
                await self._insist()
                await self._tell(Saying(final=False, text=self._words, stopped=self._stopped))
            raise

    async def _outcome(self, hearing: Hearing) -> Saying:
        heard = Saying.of(hearing, stopped=self._stopped)
        if self._stopped is None and not hearing.transcript.no_speech:
            understood = await understood_of(hearing.transcript, self._desk.missions)
            intent = None if understood is None else understood.intent
            if intent is None or intent.action not in STOPPING:
                return meant(heard, hearing.transcript, understood).model_copy(update={"final": True})
            await self._stop(intent.command)
            heard = heard.model_copy(update={"text": intent.command, "stopped": self._stopped})
            await self._tell(heard)
        await self._insist()
        return heard.model_copy(update={"final": True, "stopped": self._stopped})

    async def _insist(self) -> None:
        """No reading follows that would ask again for a stop that did not reach the robot."""
        clock = self._desk.clock
        until_s = clock.now_s() + INSIST_S
        while self._stopped is False and clock.now_s() < until_s:
            await clock.sleep(AGAIN_S)
            await self._stop(self._words)

    async def _tell(self, saying: Saying) -> None:
        with contextlib.suppress(WebSocketDisconnect, RuntimeError):  # the page may be gone: a stop is heard still
            await self._socket.send_text(saying.model_dump_json())

    async def _stop(self, words: str) -> None:
        """Where it does not arrive, the next reading that is a stop asks again, and `_insist` after the last."""
        self._words = words
        try:
            await self._actions.emergency_stop(reason=f"said: {words[:100]}", by=operator(self._socket))
        except MeshError as error:
            log.warning("a spoken stop did not reach the robot", why=error.detail)
            self._stopped = False
        else:
            self._stopped = True


async def _close(socket: WebSocket, code: int, reason: str) -> None:
    """A reason holds 123 bytes; who is gone is told nothing."""
    with contextlib.suppress(WebSocketDisconnect, RuntimeError):
        await socket.close(code, reason.encode()[:120].decode(errors="ignore"))
