"""robot_bridge's depth and map over HTTP; while it is away nobody waits for it."""

from collections.abc import Sequence

import httpx
import structlog
from pydantic import SecretStr

from contracts.measuring import LocalizeReply, LocalizeRequest, Measurement
from contracts.robot import KnownMap, Map
from geometry.grids import MapError, OccupancyGrid, decode
from geometry.places import content_id, sketch_of
from mesh.clock import Clock
from mesh.errors import MeshError, UpstreamError
from mesh.http import ServiceClient

log = structlog.get_logger()

AWAY_S = 2.0
"""After a failure nothing is asked for so long."""
MAP_AGE_S_MAX = 5.0


class RobotBridge(ServiceClient):
    """A `memory.ports.DepthAndMap`."""

    def __init__(
        self,
        base_url: str,
        clock: Clock,
        *,
        timeout_s: float,
        key: SecretStr | None = None,
        transport: httpx.AsyncBaseTransport | None = None,
    ) -> None:
        super().__init__("robot_bridge", base_url, key=key, timeout_s=timeout_s, transport=transport)
        self._clock = clock
        self._away_until_s = 0.0
        self._map: Map | None = None
        self._map_s: float | None = None
        self._ground: OccupancyGrid | None = None
        self._home: KnownMap | None = None

    async def localize(self, request: LocalizeRequest) -> Sequence[Measurement] | None:
        """None, and nothing is asked for a while, where the bridge is away; a refusal concerns this picture alone."""
        if self._left_alone():
            return None
        try:
            reply = await self.post("/localize", request, LocalizeReply)
        except UpstreamError:
            return None
        except MeshError:
            self._away_until_s = self._clock.now_s() + AWAY_S
            return None
        return reply.measurements if len(reply.measurements) == len(request.boxes_xyxy) else None

    async def ground(self) -> OccupancyGrid | None:
        await self._refresh()
        return self._ground

    async def home(self) -> KnownMap | None:
        await self._refresh()
        return self._home

    async def _refresh(self) -> None:
        now_s = self._clock.now_s()
        if self._left_alone() or (self._map_s is not None and now_s - self._map_s <= MAP_AGE_S_MAX):
            return
        self._map_s = now_s
        try:
            found = await self.get("/map", Map)
            if found != self._map:
                self._ground = decode(found)
                self._home = found.home if found.home is not None else _nameless(self._ground, now_s)
                self._map = found
        except (MeshError, MapError) as error:
            log.warning("no map", error=str(error))

    def _left_alone(self) -> bool:
        return self._clock.now_s() < self._away_until_s


def _nameless(grid: OccupancyGrid, now_s: float) -> KnownMap:
    """A bridge that does not say which home it is in: the map is known by its content alone."""
    return KnownMap(id=content_id(sketch_of(grid)), first_seen_s=now_s, last_seen_s=now_s)
