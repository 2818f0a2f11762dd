"""robot_bridge over HTTP, and the session that ends everything asked for when this process does."""

import asyncio
from collections.abc import Callable
from contextlib import AbstractAsyncContextManager
from functools import partial
from typing import Final, Protocol

import httpx
import structlog
from pydantic import SecretStr, ValidationError
from websockets.asyncio.client import connect
from websockets.exceptions import WebSocketException

from contracts.base import Message
from contracts.causes import GoalCause, Refusal
from contracts.geometry import Twist2D
from contracts.laser import LaserScan
from contracts.motion import BaseReply, DriveReply, DriveRequest, RotateReply, RotateRequest
from contracts.obstacles import Obstacles
from contracts.robot import (
    GOAL_ANSWER_S,
    EmergencyStop,
    EmergencyStopReply,
    EmergencyStopRequest,
    Goal,
    GoalRequest,
    GoalStatus,
    Map,
    Priority,
    RobotState,
    VelocityReply,
    VelocityRequest,
)
from coordinator.settings import Settings
from mesh.errors import UnavailableError, UpstreamError
from mesh.http import ServiceClient, bearer, path_of

log = structlog.get_logger()

SOURCE: Final = "coordinator"
MARGIN_S: Final = 2.0
STOP_S: Final = 1.0
"""Whoever waits longer for a stop does something else instead."""
CONFLICT: Final = 409


class SessionGreeting(Message):
    """The first thing the bridge sends on a session."""

    session_id: str


class Socket(Protocol):
    """An open WebSocket."""

    async def recv(self) -> str | bytes: ...
    async def send(self, message: str) -> None: ...


OpenSocket = Callable[[str], AbstractAsyncContextManager[Socket]]


def open_websocket(url: str, *, key: SecretStr | None) -> AbstractAsyncContextManager[Socket]:
    return connect(
        url, additional_headers=bearer(key), open_timeout=2.0, close_timeout=1.0, ping_interval=None, proxy=None
    )


class RobotBridgeClient(ServiceClient):
    """The port `Robot`, for real."""

    def __init__(
        self,
        settings: Settings,
        *,
        transport: httpx.AsyncBaseTransport | None = None,
        open_socket: OpenSocket | None = None,
    ) -> None:
        super().__init__(
            "robot_bridge",
            settings.robot_bridge_url,
            key=settings.own_key,
            timeout_s=settings.call_timeout_s,
            transport=transport,
        )
        self._open_socket = open_socket or partial(open_websocket, key=settings.own_key)
        self._session_url = f"{settings.robot_bridge_url.replace('http', 'ws', 1).rstrip('/')}/session?source={SOURCE}"
        self._heartbeat_s = settings.heartbeat_s
        self._reconnect_s = settings.reconnect_s
        self._session_id: str | None = None
        self._dropped = asyncio.Event()

    @property
    def session_held(self) -> bool:
        return self._session_id is not None

    async def hold_session(self) -> None:
        told = ""
        while True:
            try:
                await self._one_session()
            except (OSError, TimeoutError, WebSocketException, ValidationError) as error:
                why = f"{type(error).__name__}: {error}"
                if why != told:
                    log.warning("no session with robot_bridge; trying again", error=why)
                told = why
            await asyncio.sleep(self._reconnect_s)

    async def _one_session(self) -> None:
        async with self._open_socket(self._session_url) as ws:
            try:
                greeting = await asyncio.wait_for(ws.recv(), 2.0)
                self._session_id = SessionGreeting.model_validate_json(greeting).session_id
                log.info("a session with robot_bridge is held")
                self._dropped.clear()
                while not self._dropped.is_set():
                    await ws.send("beat")
                    await asyncio.sleep(self._heartbeat_s)
            finally:
                self._session_id = None

    async def drop_session(self) -> None:
        """The next beat is not sent; the bridge ends what belonged to it when the connection closes."""
        self._session_id = None
        self._dropped.set()

    def _session(self) -> str:
        if self._session_id is None:
            raise UnavailableError("robot_bridge", "no session is held")
        return self._session_id

    async def map(self) -> Map:
        return await self.get("/map", Map)

    async def state(self) -> RobotState:
        return await self.get("/state", RobotState)

    async def scan(self) -> LaserScan:
        return await self.get("/scan?points_max=720", LaserScan)

    async def obstacles(self) -> Obstacles:
        return await self.get("/obstacles", Obstacles)

    async def navigate(self, request: GoalRequest) -> Goal:
        request = request.model_copy(update={"session_id": self._session()})
        try:
            return await self.post("/navigation/goals", request, Goal, timeout_s=GOAL_ANSWER_S)
        except UpstreamError as error:
            if error.code != Refusal.OUTSIDE_MAP:
                raise
            pose, cause = request.candidates[0].pose, GoalCause.UNREACHABLE
            return Goal(id="", pose=pose, status=GoalStatus.ABORTED, cause=cause, error_msg=error.detail, stamp_s=0.0)

    async def goal(self, goal_id: str) -> Goal:
        return await self.get(path_of("navigation", "goals", goal_id), Goal)

    async def cancel_goal(self, goal_id: str) -> Goal:
        return await self.delete(path_of("navigation", "goals", goal_id), Goal)

    async def rotate(self, angle_rad: float, *, speed_rad_s: float, timeout_s: float, epoch: int) -> RotateReply:
        request = RotateRequest(
            angle_rad=angle_rad,
            speed_rad_s=speed_rad_s,
            timeout_s=timeout_s,
            epoch=epoch,
            session_id=self._session(),
        )
        return await self.post("/rotate", request, RotateReply, timeout_s=timeout_s + MARGIN_S)

    async def drive(self, distance_m: float, *, speed_m_s: float, timeout_s: float, epoch: int) -> DriveReply:
        request = DriveRequest(
            distance_m=distance_m,
            speed_m_s=speed_m_s,
            timeout_s=min(60.0, timeout_s),
            epoch=epoch,
            session_id=self._session(),
        )
        return await self.post("/drive", request, DriveReply, timeout_s=timeout_s + MARGIN_S)

    async def velocity(self, twist: Twist2D, *, duration_s: float, epoch: int) -> VelocityReply:
        request = VelocityRequest(
            twist=twist,
            source=SOURCE,
            priority=Priority.EXPLORATION,
            duration_s=duration_s,
            epoch=epoch,
            session_id=self._session(),
        )
        return await self.post("/velocity", request, VelocityReply, timeout_s=1.0)

    async def end_motion(self) -> None:
        await self.call("DELETE", "/motion")

    async def halt(self) -> EmergencyStop:
        return await self.post("/halt", None, EmergencyStop, timeout_s=STOP_S)

    async def emergency_stop(self, reason: str) -> EmergencyStop:
        request = EmergencyStopRequest(reason=reason, by=SOURCE)
        return (await self.post("/emergency-stop", request, EmergencyStopReply, timeout_s=STOP_S)).state

    async def undock(self, *, timeout_s: float) -> BaseReply:
        path = f"/undock?session_id={self._session()}"
        return await self.post(path, None, BaseReply, timeout_s=timeout_s)

    async def dock(self, *, timeout_s: float) -> BaseReply:
        path = f"/dock?session_id={self._session()}"
        return await self.post(path, None, BaseReply, timeout_s=timeout_s)

    async def celebrate(self) -> None:
        """Asking again too soon is refused there, and no failure here."""
        try:
            await self.call("POST", "/celebrate")
        except UpstreamError as error:
            if error.upstream_status != CONFLICT:
                raise
