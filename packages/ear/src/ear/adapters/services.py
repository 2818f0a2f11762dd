"""coordinator, robot_bridge and memory over HTTP; the emergency stop has a connection pool of its own and no key."""

from collections.abc import AsyncIterator, Sequence
from typing import Final

import httpx
from pydantic import ValidationError
from websockets.asyncio.client import connect
from websockets.exceptions import WebSocketException

from clients.missions import start_mission
from clients.stopping import EmergencyStopClient
from contracts.asking import Answer, Question
from contracts.intent import Understand, Understood
from contracts.memory import LabelCount
from contracts.mission import Heard, Mission, MissionEvent, MissionStatus
from contracts.robot import EmergencyStopReply, EmergencyStopRequest
from ear.ports import Line
from ear.settings import Settings
from mesh.clock import Clock
from mesh.errors import UpstreamError
from mesh.http import ServiceClient, bearer, path_of
from vocabulary.hot_words import sayable

OPEN_S: Final = 2.0
AGAIN_S: Final = 2.0


class CoordinatorClient(ServiceClient):
    """The port `Coordinator`, for real."""

    def __init__(self, settings: Settings, clock: Clock, *, transport: httpx.AsyncBaseTransport | None = None) -> None:
        base_url, key = settings.coordinator_url, settings.own_key
        super().__init__("coordinator", base_url, key=key, timeout_s=settings.call_timeout_s, transport=transport)
        self._clock = clock
        self._command_timeout_s = settings.command_timeout_s
        self._says_who = bearer(key)
        self._events_url = f"ws{base_url.removeprefix('http')}/events"

    async def understand(self, readings: Sequence[str]) -> Understood:
        body = Understand(readings=tuple(readings))
        return await self.post("/understand", body, Understood, timeout_s=self._command_timeout_s)

    async def start(self, command: str) -> Mission | Heard:
        return await start_mission(self, command, timeout_s=self._command_timeout_s)

    async def ask(self, question: str) -> Answer:
        return await self.post("/ask", Question(question=question), Answer, timeout_s=self._command_timeout_s)

    async def status(self) -> MissionStatus:
        return await self.get("/state", MissionStatus, timeout_s=1.0)

    async def mission(self, mission_id: str) -> Mission:
        return await self.get(path_of("missions", mission_id), Mission)

    async def hold(self, mission_id: str, *, for_s: float) -> Mission:
        answer = await self.call("POST", path_of("missions", mission_id, "pause"), params={"for_s": for_s})
        try:
            return Mission.model_validate_json(answer.content)
        except ValidationError as error:
            raise UpstreamError("coordinator", answer.status_code, "its answer is not the contract's") from error

    async def events(self) -> AsyncIterator[MissionEvent | Line]:
        last: int | None = None
        while True:
            query = "" if last is None else f"?after={last}"
            try:
                async with connect(
                    f"{self._events_url}{query}",
                    additional_headers=self._says_who,
                    open_timeout=OPEN_S,
                    close_timeout=1.0,
                    proxy=None,
                ) as socket:
                    yield Line.OPEN
                    async for message in socket:
                        event = MissionEvent.model_validate_json(message)
                        last = event.id
                        yield event
            except (OSError, TimeoutError, WebSocketException, ValidationError):
                pass  # away, or of another version: it may be back, and what was missed is asked for
            yield Line.BROKEN
            await self._clock.sleep(AGAIN_S)


class RobotClient:
    """The port `Robot`, for real."""

    def __init__(self, settings: Settings, *, transport: httpx.AsyncBaseTransport | None = None) -> None:
        self._stopper = EmergencyStopClient(
            settings.robot_bridge_url, timeout_s=settings.stop_timeout_s, transport=transport
        )

    async def emergency_stop(self, request: EmergencyStopRequest) -> EmergencyStopReply:
        return await self._stopper.emergency_stop(request)

    async def aclose(self) -> None:
        await self._stopper.aclose()


class MemoryClient(ServiceClient):
    """The port `Memory`, for real."""

    def __init__(self, settings: Settings, *, transport: httpx.AsyncBaseTransport | None = None) -> None:
        super().__init__(
            "memory", settings.memory_url, key=settings.own_key, timeout_s=settings.call_timeout_s, transport=transport
        )

    async def names(self) -> Sequence[str]:
        return sayable(one.label for one in await self.get_list("/labels", LabelCount))
