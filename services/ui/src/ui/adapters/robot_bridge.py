"""robot_bridge over HTTP; the emergency stop has a connection pool of its own and is tried more than once."""

from contracts.problem import Dependency
from contracts.robot import EmergencyStopReply, EmergencyStopRequest, Map, MotionReply, RobotState
from mesh.errors import UnavailableError
from mesh.http import ServiceClient


class BridgeRobot:
    """The port `Robot`, for real."""

    def __init__(
        self, base_url: str, *, timeout_s: float, dock_timeout_s: float, stop_timeout_s: float, stop_tries: int
    ) -> None:
        self._client = ServiceClient("robot_bridge", base_url, timeout_s=timeout_s)
        self._stopper = ServiceClient("robot_bridge", base_url, timeout_s=stop_timeout_s)
        self._dock_timeout_s = dock_timeout_s
        self._stop_tries = stop_tries

    async def aclose(self) -> None:
        await self._client.aclose()
        await self._stopper.aclose()

    async def emergency_stop(self, request: EmergencyStopRequest) -> EmergencyStopReply:
        """Stopping twice does no harm, so a try that got no answer is followed by another."""
        for _ in range(self._stop_tries - 1):
            try:
                return await self._stopper.post("/emergency-stop", request, EmergencyStopReply)
            except UnavailableError:
                continue
        return await self._stopper.post("/emergency-stop", request, EmergencyStopReply)

    async def reset(self, request: EmergencyStopRequest) -> EmergencyStopReply:
        return await self._client.post("/emergency-stop/reset", request, EmergencyStopReply)

    async def state(self) -> RobotState:
        return await self._client.get("/state", RobotState, timeout_s=1.0)

    async def map(self) -> Map:
        return await self._client.get("/map", Map)

    async def dock(self) -> MotionReply:
        return await self._client.post("/dock", None, MotionReply, timeout_s=self._dock_timeout_s)

    async def undock(self) -> MotionReply:
        return await self._client.post("/undock", None, MotionReply, timeout_s=self._dock_timeout_s)

    async def dependency(self) -> Dependency:
        return await self._client.dependency()
