"""robot_bridge's senses for memory's tests: every box shows the same depth."""

from contracts.measuring import LocalizeRequest, Measurement
from contracts.robot import KnownMap
from geometry.grids import OccupancyGrid


class FakeSenses:
    """`far_m` is what depth says everywhere."""

    def __init__(self, *, far_m: float | None = 5.0, ground: OccupancyGrid | None = None) -> None:
        self.far_m = far_m
        self.map = ground
        self.home_of: KnownMap | None = None
        self.asked: list[LocalizeRequest] = []
        self.closed = False

    async def localize(self, request: LocalizeRequest) -> tuple[Measurement, ...]:
        self.asked.append(request)
        return tuple(Measurement(depth_m=self.far_m, sigma_m=0.01) for _ in request.boxes_xyxy)

    async def ground(self) -> OccupancyGrid | None:
        return self.map

    async def home(self) -> KnownMap | None:
        return self.home_of

    async def aclose(self) -> None:
        self.closed = True
