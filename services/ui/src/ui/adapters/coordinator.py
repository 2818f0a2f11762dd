"""coordinator over HTTP: missions, their state, timeline and history, and questions."""

from collections.abc import Sequence

import httpx

from clients.missions import start_mission
from contracts.actions import Action, ActionReply
from contracts.asking import Answer, Question
from contracts.belief import NoBelief, SearchBelief
from contracts.intent import Understand, Understood
from contracts.mission import Heard, Mission, MissionEvent, MissionStatus
from mesh.errors import NotFoundError, UpstreamError
from mesh.http import ServiceClient, path_of
from ui.settings import Settings


class CoordinatorClient(ServiceClient):
    """The port `Missions`, for real."""

    def __init__(self, settings: Settings, *, transport: httpx.AsyncBaseTransport | None = None) -> None:
        super().__init__(
            "coordinator",
            settings.coordinator_url,
            key=settings.own_key,
            timeout_s=settings.call_timeout_s,
            transport=transport,
        )
        self._command_timeout_s = settings.command_timeout_s

    async def start(self, command: str, *, key: str) -> Mission | Heard:
        return await start_mission(self, command, timeout_s=self._command_timeout_s, key=key)

    async def ask(self, question: str) -> Answer:
        return await self.post("/ask", Question(question=question), Answer, timeout_s=self._command_timeout_s)

    async def understand(self, readings: Sequence[str]) -> Understood:
        body = Understand(readings=tuple(readings))
        return await self.post("/understand", body, Understood, timeout_s=self._command_timeout_s)

    async def do(self, action: Action) -> ActionReply:
        return await self.post("/actions", action, ActionReply, timeout_s=self._command_timeout_s)

    async def pause(self, mission_id: str) -> Mission:
        return await self.post(path_of("missions", mission_id, "pause"), None, Mission)

    async def resume(self, mission_id: str) -> Mission:
        return await self.post(path_of("missions", mission_id, "resume"), None, Mission)

    async def cancel(self, mission_id: str) -> Mission:
        return await self.post(path_of("missions", mission_id, "cancel"), None, Mission)

    async def status(self) -> MissionStatus:
        return await self.get("/state", MissionStatus, timeout_s=1.0)

    async def newest(self, limit: int) -> Sequence[Mission]:
        return await self.get_list("/missions", Mission, limit=limit)

    async def events(self, mission_id: str) -> Sequence[MissionEvent]:
        return await self.get_list(path_of("missions", mission_id, "events"), MissionEvent, limit=2000)

    async def belief(self, mission_id: str) -> SearchBelief | NoBelief:
        try:
            return await self.get(path_of("missions", mission_id, "belief"), SearchBelief)
        except UpstreamError as error:
            if error.code in set(NoBelief):
                return NoBelief(error.code)
            raise

    async def picture(self, mission_id: str, number: int) -> bytes:
        try:
            return (await self.call("GET", path_of("missions", mission_id, "pictures", str(number)))).content
        except UpstreamError as error:
            if error.upstream_status in {404, 422}:  # no such number: a failure of who asked, not of the coordinator
                raise NotFoundError(error.said) from error
            raise
