"""robot_bridge's depth and map over HTTP; while it is away nobody waits for it."""

from typing import TypeVar

import httpx
import structlog

from contracts.base import Message
from contracts.geometry import Point3D
from contracts.robot import BoxQuery, DepthReply, LocalizeReply, Map
from geometry.grids import MapError, OccupancyGrid, decode
from mesh.clock import Clock
from mesh.errors import MeshError, UpstreamError
from mesh.http import ServiceClient

log = structlog.get_logger()

M = TypeVar("M", bound=Message)

AWAY_S = 2.0
"""After a failure nothing is asked for so long."""
MAP_AGE_S_MAX = 60.0


class RobotBridge:
    """A `memory.ports.Senses`."""

    def __init__(
        self, base_url: str, clock: Clock, *, timeout_s: float, transport: httpx.AsyncBaseTransport | None = None
    ) -> None:
        self._client = ServiceClient("robot_bridge", base_url, timeout_s=timeout_s, transport=transport)
        self._clock = clock
        self._away_until_s = 0.0
        self._ground: OccupancyGrid | None = None
        self._ground_s: float | None = None

    async def aclose(self) -> None:
        await self._client.aclose()

    async def locate(self, box: BoxQuery) -> Point3D | None:
        reply = await self._ask("/localize", box, LocalizeReply)
        return reply.map_point if reply is not None else None

    async def depth_m(self, box: BoxQuery) -> float | None:
        reply = await self._ask("/depth", box, DepthReply)
        return reply.distance_m if reply is not None else None

    async def ground(self) -> OccupancyGrid | None:
        now_s = self._clock.now_s()
        if self._ground_s is None or now_s - self._ground_s > MAP_AGE_S_MAX:
            self._ground = await self._map()
            self._ground_s = now_s
        return self._ground

    async def _map(self) -> OccupancyGrid | None:
        if self._away():
            return self._ground
        try:
            return decode(await self._client.get("/map", Map))
        except (MeshError, MapError) as error:
            log.warning("no map to tell what hides things", error=str(error))
            return self._ground

    async def _ask(self, path: str, box: BoxQuery, reply: type[M]) -> M | None:
        """None, and nothing is asked for a while, where the bridge is away; a refusal concerns this box alone."""
        if self._away():
            return None
        try:
            return await self._client.post(path, box, reply)
        except UpstreamError:
            return None
        except MeshError:
            self._away_until_s = self._clock.now_s() + AWAY_S
            return None

    def _away(self) -> bool:
        return self._clock.now_s() < self._away_until_s
