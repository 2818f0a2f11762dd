"""coordinator and robot_bridge over HTTP; the emergency stop has a connection pool of its own and no key."""

from collections.abc import Sequence

import httpx

from clients.missions import start_mission
from clients.stopping import EmergencyStopClient
from contracts.mission import Heard, Mission, MissionStatus
from contracts.robot import EmergencyStopReply, EmergencyStopRequest, RobotState
from home_assistant.settings import Settings
from mesh.http import ServiceClient


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
        return await start_mission(self, command, timeout_s=self._command_timeout_s)


class Robot(ServiceClient):
    def __init__(self, settings: Settings, *, transport: httpx.AsyncBaseTransport | None = None) -> None:
        super().__init__(
            "robot_bridge",
            settings.robot_bridge_url,
            key=settings.own_key,
            timeout_s=settings.call_timeout_s,
            transport=transport,
        )
        self._stopper = EmergencyStopClient(
            settings.robot_bridge_url, timeout_s=settings.stop_timeout_s, transport=transport
        )

    async def state(self) -> RobotState:
        return await self.get("/state", RobotState)

    async def picture(self) -> bytes:
        """The newest one of the camera, a JPEG."""
        return (await self.call("GET", "/camera/frame")).content

    async def emergency_stop(self, request: EmergencyStopRequest) -> EmergencyStopReply:
        return await self._stopper.emergency_stop(request)

    async def aclose(self) -> None:
        await self._stopper.aclose()
        await super().aclose()
