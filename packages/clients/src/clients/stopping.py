"""robot_bridge's emergency stop, with a connection pool of its own and no key: nothing else holds it up."""

from typing import Final

import httpx

from contracts.robot import EmergencyStopReply, EmergencyStopRequest
from mesh.errors import UnavailableError
from mesh.http import ServiceClient

STOP_TRIES: Final = 3


class EmergencyStopClient(ServiceClient):
    def __init__(self, url: str, *, timeout_s: float, transport: httpx.AsyncBaseTransport | None = None) -> None:
        super().__init__("robot_bridge", url, timeout_s=timeout_s, transport=transport)

    async def emergency_stop(self, request: EmergencyStopRequest) -> EmergencyStopReply:
        """Stopping twice does no harm, so a try that got no answer is followed by another."""
        for _ in range(STOP_TRIES - 1):
            try:
                return await self.post("/emergency-stop", request, EmergencyStopReply)
            except UnavailableError:
                continue
        return await self.post("/emergency-stop", request, EmergencyStopReply)
