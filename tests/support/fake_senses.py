"""robot_bridge's senses for memory's tests: every box shows what it is told to show."""

from contracts.geometry import Point3D
from contracts.robot import BoxQuery, KnownMap
from geometry.grids import OccupancyGrid


class FakeSenses:
    """`places` by the box's x_min; `far_m` is what depth says everywhere."""

    def __init__(self, *, far_m: float | None = 5.0, ground: OccupancyGrid | None = None) -> None:
        self.places: dict[float, Point3D] = {}
        self.far_m = far_m
        self.map = ground
        self.home_of: KnownMap | None = None
        self.asked: list[BoxQuery] = []
        self.closed = False

    async def locate(self, box: BoxQuery) -> Point3D | None:
        self.asked.append(box)
        return self.places.get(box.bbox_xyxy[0])

    async def depth_m(self, box: BoxQuery) -> float | None:
        self.asked.append(box)
        return self.far_m

    async def ground(self) -> OccupancyGrid | None:
        return self.map

    async def home(self) -> KnownMap | None:
        return self.home_of

    async def aclose(self) -> None:
        self.closed = True
