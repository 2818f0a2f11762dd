"""robot_bridge over HTTP; the emergency stop has a connection pool of its own, no key, and is tried more than once."""

import contextlib
import math
from collections.abc import AsyncGenerator
from typing import Final

import httpx
from pydantic import ValidationError
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import WebSocketException

from contracts.geometry import Pose2D
from contracts.laser import LaserScan
from contracts.motion import BaseReply, EndedMotion, RotateReply, RotateRequest
from contracts.problem import Health
from contracts.robot import (
    GOAL_ANSWER_S,
    EmergencyStop,
    EmergencyStopReply,
    EmergencyStopRequest,
    Goal,
    GoalRequest,
    Map,
    PathReply,
    PathRequest,
    RobotState,
    VelocityReply,
    VelocityRequest,
)
from mesh.errors import UnavailableError, UpstreamError
from mesh.http import ServiceClient, bearer, path_of
from ui.overlay import CameraFrame
from ui.settings import Settings

MARGIN_S: Final = 2.0
NO_CONTENT: Final = 204
WHEELS_OPEN_S: Final = 2.0
STOP_ANSWERS_S: Final = 1.0
"""A page counts STOP as dead a little later (assets/stop.js)."""


class VelocitySocket:
    """The port `Wheels`, for real: WS /velocity."""

    def __init__(self, socket: ClientConnection) -> None:
        self._socket = socket

    async def send(self, request: VelocityRequest) -> VelocityReply:
        try:
            await self._socket.send(request.model_dump_json())
            return VelocityReply.model_validate_json(await self._socket.recv())
        except WebSocketException as error:
            raise UnavailableError("robot_bridge", f"the line to the wheels broke ({type(error).__name__})") from error
        except ValidationError as error:
            raise UpstreamError("robot_bridge", 200, "the answer is not the contract") from error


class RobotBridgeClient(ServiceClient):
    """The port `Robot`, for real."""

    def __init__(self, settings: Settings, *, transport: httpx.AsyncBaseTransport | None = None) -> None:
        base_url = settings.robot_bridge_url
        key = settings.own_key
        super().__init__("robot_bridge", base_url, key=key, timeout_s=settings.call_timeout_s, transport=transport)
        self._stopper = ServiceClient("robot_bridge", base_url, timeout_s=settings.stop_timeout_s, transport=transport)
        self._says_who = bearer(key)
        self._wheels_url = f"ws{base_url.removeprefix('http')}/velocity"
        self._dock_timeout_s = settings.dock_timeout_s
        self._stop_tries = settings.stop_tries

    async def aclose(self) -> None:
        await super().aclose()
        await self._stopper.aclose()

    async def emergency_stop(self, request: EmergencyStopRequest) -> EmergencyStopReply:
        """Stopping twice does no harm, so a try that got no answer is followed by another."""
        for _ in range(self._stop_tries - 1):
            try:
                return await self._stopper.post("/emergency-stop", request, EmergencyStopReply)
            except UnavailableError:
                continue
        return await self._stopper.post("/emergency-stop", request, EmergencyStopReply)

    async def stop_state(self) -> EmergencyStop:
        return await self.get("/emergency-stop", EmergencyStop, timeout_s=1.0)

    async def stop_answers(self) -> None:
        response = await self._stopper.call("GET", "/health", timeout_s=STOP_ANSWERS_S)
        try:
            health = Health.model_validate_json(response.content)
        except ValidationError as error:
            raise UpstreamError("robot_bridge", 200, "the answer is not the contract") from error
        if health.service != "robot_bridge":
            raise UpstreamError("robot_bridge", 200, f"{health.service} answers at its address")

    async def reset(self, request: EmergencyStopRequest) -> EmergencyStopReply:
        return await self.post("/emergency-stop/reset", request, EmergencyStopReply)

    async def state(self) -> RobotState:
        return await self.get("/state", RobotState, timeout_s=1.0)

    async def map(self) -> Map:
        return await self.get("/map", Map)

    async def frame(self, *, after_s: float | None, wait_s: float) -> CameraFrame | None:
        query = {"wait_s": wait_s} | ({"after": after_s} if after_s is not None else {})
        response = await self.call("GET", "/camera/frame", params=query, timeout_s=wait_s + MARGIN_S)
        if response.status_code == NO_CONTENT:
            return None
        headers = response.headers
        try:
            stamp_s = float(headers["X-Stamp-S"])
            pose = _pose(headers["X-Pose"]) if "X-Pose" in headers else None
            frame = CameraFrame(stamp_s, response.content, int(headers["X-Width"]), int(headers["X-Height"]), pose)
        except (KeyError, ValueError) as error:
            raise UpstreamError("robot_bridge", response.status_code, "the picture's headers are not whole") from error
        if not math.isfinite(stamp_s):
            raise UpstreamError("robot_bridge", response.status_code, "the picture's stamp is not a number")
        return frame

    async def scan(self) -> LaserScan:
        response = await self.call("GET", "/scan", timeout_s=1.0)  # asked for again soon: no retries
        try:
            return LaserScan.model_validate_json(response.content)
        except ValidationError as error:
            raise UpstreamError("robot_bridge", 200, "the answer is not the contract") from error

    async def go(self, request: GoalRequest) -> Goal:
        return await self.post("/navigation/goals", request, Goal, timeout_s=GOAL_ANSWER_S)

    async def cancel_goal(self, goal_id: str) -> Goal:
        return await self.delete(path_of("navigation", "goals", goal_id), Goal)

    async def path(self, request: PathRequest) -> PathReply:
        return await self.post("/navigation/path", request, PathReply)

    async def rotate(self, request: RotateRequest) -> RotateReply:
        return await self.post("/rotate", request, RotateReply, timeout_s=request.timeout_s + MARGIN_S)

    async def end_motion(self) -> EndedMotion:
        return await self.delete("/motion", EndedMotion)

    async def dock(self) -> BaseReply:
        return await self.post("/dock", None, BaseReply, timeout_s=self._dock_timeout_s)

    async def undock(self) -> BaseReply:
        return await self.post("/undock", None, BaseReply, timeout_s=self._dock_timeout_s)

    async def celebrate(self) -> BaseReply:
        return await self.post("/celebrate", None, BaseReply)

    @contextlib.asynccontextmanager
    async def wheels(self) -> AsyncGenerator[VelocitySocket]:
        try:
            socket = await connect(
                self._wheels_url,
                additional_headers=self._says_who,
                open_timeout=WHEELS_OPEN_S,
                close_timeout=1.0,
                proxy=None,
            )
        except (OSError, TimeoutError, WebSocketException) as error:
            raise UnavailableError("robot_bridge", f"no line to the wheels ({type(error).__name__})") from error
        try:
            yield VelocitySocket(socket)
        finally:
            await socket.close()


def _pose(text: str) -> Pose2D:
    x, y, yaw = (float(part) for part in text.split(","))
    return Pose2D(x=x, y=y, yaw=yaw)
