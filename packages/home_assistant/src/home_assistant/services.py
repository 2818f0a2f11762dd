"""coordinator and robot_bridge over HTTP; the emergency stop has a connection pool of its own and no key."""

import uuid
from collections.abc import Sequence
from typing import Final

import httpx
from pydantic import TypeAdapter, ValidationError

from contracts.mission import Heard, Mission, MissionStatus, StartMission
from contracts.robot import EmergencyStopReply, EmergencyStopRequest, RobotState
from home_assistant.settings import Settings
from mesh.errors import UnavailableError, UpstreamError
from mesh.http import ServiceClient

STARTED: Final[TypeAdapter[Mission | Heard]] = TypeAdapter(Mission | Heard)
STOP_TRIES: Final = 3


class Coordinator(ServiceClient):
    def __init__(self, settings: Settings, *, transport: httpx.AsyncBaseTransport | None = None) -> None:
        super().__init__(
            "coordinator",
            settings.coordinator_url,
            key=settings.own_key,
            timeout_s=settings.call_timeout_s,
            transport=transport,
        )
        self._command_timeout_s = settings.command_timeout_s

    async def status(self) -> MissionStatus:
        return await self.get("/state", MissionStatus)

    async def newest(self, limit: int) -> Sequence[Mission]:
        return await self.get_list("/missions", Mission, limit=limit)

    async def start(self, command: str) -> Mission | Heard:
        """Raises `UpstreamError` where it asks for nothing known."""
        answer = await self.call(
            "POST",
            "/missions",
            body=StartMission(command=command),
            timeout_s=self._command_timeout_s,
            headers={"Idempotency-Key": uuid.uuid4().hex},
        )
        try:
            return STARTED.validate_json(answer.content)
        except ValidationError as error:
            raise UpstreamError("coordinator", answer.status_code, "its answer is not the contract's") from error


class Robot(ServiceClient):
    def __init__(self, settings: Settings, *, transport: httpx.AsyncBaseTransport | None = None) -> None:
        super().__init__(
            "robot_bridge",
            settings.robot_bridge_url,
            key=settings.own_key,
            timeout_s=settings.call_timeout_s,
            transport=transport,
        )
        self._stopper = ServiceClient(
            "robot_bridge", settings.robot_bridge_url, timeout_s=settings.stop_timeout_s, transport=transport
        )

    async def state(self) -> RobotState:
        return await self.get("/state", RobotState)

    async def picture(self) -> bytes:
        """The newest one of the camera, a JPEG."""
        return (await self.call("GET", "/camera/frame")).content

    async def emergency_stop(self, request: EmergencyStopRequest) -> EmergencyStopReply:
        """Stopping twice does no harm, so a try that got no answer is followed by another."""
        for _ in range(STOP_TRIES - 1):
            try:
                return await self._stopper.post("/emergency-stop", request, EmergencyStopReply)
            except UnavailableError:
                continue
        return await self._stopper.post("/emergency-stop", request, EmergencyStopReply)

    async def aclose(self) -> None:
        await self._stopper.aclose()
        await super().aclose()
