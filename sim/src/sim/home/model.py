"""The immutable parts of a home: rooms, walls, doors, furniture, things and how it all looks."""

from dataclasses import dataclass

from pydantic import ConfigDict

from sim.home.shapes import Vec

_STRICT = ConfigDict(extra="forbid")


@dataclass(frozen=True)
class Room:
    """The free inside of one room, wall face to wall face, in m of the home's frame."""

    __pydantic_config__ = _STRICT
    name: str
    x_min_m: float
    y_min_m: float
    x_max_m: float
    y_max_m: float

    @property
    def area_m2(self) -> float:
        """Floor area."""
        return (self.x_max_m - self.x_min_m) * (self.y_max_m - self.y_min_m)

    def contains(self, x_m: float, y_m: float) -> bool:
        """Whether a point lies in the room."""
        return self.x_min_m <= x_m <= self.x_max_m and self.y_min_m <= y_m <= self.y_max_m


@dataclass(frozen=True)
class Wall:
    """A solid upright block of wall; the piece above a door starts at `z_min_m` > 0."""

    __pydantic_config__ = _STRICT
    x_min_m: float
    y_min_m: float
    x_max_m: float
    y_max_m: float
    z_min_m: float
    z_max_m: float


@dataclass(frozen=True)
class Door:
    """An open doorway: its centre, the unit normal of its wall and its clear width."""

    __pydantic_config__ = _STRICT
    x_m: float
    y_m: float
    normal_x: float
    normal_y: float
    width_m: float


@dataclass(frozen=True)
class Furniture:
    """A piece of furniture; its front is along its own +y, `size_m` is width (x), depth (y), height (z)."""

    __pydantic_config__ = _STRICT
    id: str
    kind: str
    colour: str | None
    x_m: float
    y_m: float
    yaw: float
    size_m: tuple[float, float, float]
    variant: int = 0


@dataclass(frozen=True)
class Thing:
    """A thing; (x, y, z) is the centre of its base, `support` is "floor", "wall" or the id of a piece of furniture."""

    __pydantic_config__ = _STRICT
    id: str
    kind: str
    colour: str | None
    x_m: float
    y_m: float
    z_m: float
    yaw: float
    size_m: tuple[float, float, float]
    support: str
    variant: int = 0


@dataclass(frozen=True)
class Wanted:
    """What a home must hold; `colour` None means any."""

    __pydantic_config__ = _STRICT
    kind: str
    colour: str | None = None


@dataclass(frozen=True)
class Dock:
    """The pose of the docked robot: its nose is at the dock, so `yaw` points at the wall behind the dock."""

    __pydantic_config__ = _STRICT
    x_m: float
    y_m: float
    yaw: float


@dataclass(frozen=True)
class Rug:
    """A flat rug that neither robot nor lidar notices."""

    __pydantic_config__ = _STRICT
    x_m: float
    y_m: float
    width_m: float
    depth_m: float
    rgb: Vec


@dataclass(frozen=True)
class Appearance:
    """Floor style ("planks", "tiles" or "carpet") and colour per room, and the colours of walls and woods."""

    __pydantic_config__ = _STRICT
    floors: tuple[tuple[str, Vec], ...]
    wall_rgb: Vec
    skirting_rgb: Vec
    wood_rgbs: tuple[Vec, Vec]
    quilt_rgb: Vec
    rugs: tuple[Rug, ...]
    pictures: tuple[tuple[float, float, float], ...]
    """Pictures on walls as (x_m, y_m, yaw), yaw being the direction their front (+y) is turned by."""
