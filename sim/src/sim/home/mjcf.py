"""A home as a MuJoCo model: MJCF text and the mesh and texture bytes it names."""

import math
import zlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from sim.home import meshes, textures
from sim.home.catalog import rgb_of
from sim.home.furniture import furniture_geoms
from sim.home.home import Home
from sim.home.layout import DOCK_GAP_M, HEIGHT_M
from sim.home.model import Furniture, Thing
from sim.home.shapes import WHITE, Geom, Vec, box, front_panel, shade
from sim.home.things import thing_geoms

CEILING_GROUP: Final = 2
"""Geom group of the ceiling alone: an overview picture leaves it out."""

_SKY: Final = (((0.45, 0.35, -0.82), 0.20), ((-0.5, -0.3, -0.81), 0.16), ((-0.3, 0.6, -0.74), 0.09))
"""Direction and strength of three lights that cast no shadow and shine through the ceiling."""


@dataclass
class _Assets:
    """Meshes, textures and materials in use, each written once."""

    files: dict[str, bytes] = field(default_factory=dict[str, bytes])
    lines: dict[str, str] = field(default_factory=dict[str, str])

    def mesh(self, name: str, size_m: Vec) -> str:
        scaled = f"{name}_{size_m[0] * 1000:.0f}_{size_m[1] * 1000:.0f}_{size_m[2] * 1000:.0f}"
        if scaled not in self.lines:
            self.files[f"{name}.obj"] = meshes.build(name)
            scale = _numbers(size_m)
            self.lines[scaled] = f'<mesh name="{scaled}" file="{name}.obj" scale="{scale}" inertia="shell"/>'
        return scaled

    def material(
        self,
        name: str,
        picture: bytes | None,
        specular: float,
        shininess: float,
        *,
        repeat_m: float = 0.0,
        emission: float = 0.0,
    ) -> None:
        """A material, textured if there is a picture; `repeat_m` is the side of one repeat on a floor."""
        line = ""
        extra = ""
        if picture is not None:
            self.files[f"{name}.png"] = picture
            line = f'<texture name="{name}" type="2d" file="{name}.png"/>'
            extra = f' texture="{name}"'
            if repeat_m:
                extra += f' texuniform="true" texrepeat="{1 / repeat_m:.3f} {1 / repeat_m:.3f}"'
        line += f'<material name="{name}" specular="{specular}" shininess="{shininess}" emission="{emission}"{extra}/>'
        self.lines[f"material {name}"] = line


def home_mjcf(
    home: Home,
    *,
    robot_xml: str = "",
    robot_assets: Mapping[str, bytes] | None = None,
    robot_asset_xml: str = "",
    actuators: str = "",
    sensors: str = "",
    extra_xml: str = "",
    timestep_s: float = 0.005,
    offscreen_px: tuple[int, int] = (1280, 960),
    samples: int = 0,
) -> tuple[str, dict[str, bytes]]:
    """MJCF text and asset bytes for `MjModel.from_xml_string(text, assets)`; angles are in radians.

    Bodies are named after `Thing.id` and `Furniture.id`; the floor geom is "floor" (its visible covering in each room
    "floor_<room>"), the dock "dock". `robot_xml` holds <body> elements for the worldbody, `robot_asset_xml` elements
    for <asset> with their bytes in `robot_assets`, `actuators` and `sensors` the insides of those sections, and
    `extra_xml` whole top-level sections such as <contact>. `samples` = 4 smooths edges at 2.5 times the render time.
    """
    assets = _Assets(dict(robot_assets or {}))
    _materials(assets, home)
    world = [*_lights(), *_building(home, assets)]
    world += [_furniture(home, piece, assets) for piece in home.furniture]
    world += [_thing(home, thing, assets) for thing in home.things]
    width, depth = home.width_m, home.depth_m
    text = f"""<mujoco model="home_{home.seed}">
<compiler angle="radian" autolimits="true"/>
<option timestep="{timestep_s}" integrator="implicitfast"/>
<statistic center="{width / 2:.2f} {depth / 2:.2f} 0.8" extent="8"/>
<visual>
<global offwidth="{offscreen_px[0]}" offheight="{offscreen_px[1]}"/>
<quality shadowsize="0" offsamples="{samples}"/>
<map znear="0.003" zfar="3"/>
<headlight ambient="0.56 0.56 0.56" diffuse="0.26 0.26 0.26" specular="0 0 0"/>
</visual>
<asset>
<texture type="skybox" builtin="flat" rgb1="0.86 0.92 0.98" rgb2="0.86 0.92 0.98" width="16" height="96"/>
{chr(10).join(assets.lines.values())}
{robot_asset_xml}
</asset>
<worldbody>
{chr(10).join(world)}
{robot_xml}
</worldbody>
<actuator>{actuators}</actuator>
<sensor>{sensors}</sensor>
{extra_xml}
</mujoco>
"""
    return text, assets.files


def _materials(assets: _Assets, home: Home) -> None:
    looks = home.appearance
    assets.material("matte", None, 0.05, 0.1)
    assets.material("gloss", None, 0.35, 0.6)
    assets.material("ceiling", None, 0.0, 0.0, emission=0.35)
    assets.material("wood0", textures.wood(looks.wood_rgbs[0]), 0.08, 0.2)
    assets.material("wood1", textures.wood(looks.wood_rgbs[1]), 0.08, 0.2)
    assets.material("fabric", textures.fabric(), 0.0, 0.0)
    assets.material("fur", textures.fur(), 0.0, 0.0)
    assets.material("leaf", textures.leaf(), 0.05, 0.1)
    assets.material("label", textures.label(), 0.35, 0.6)
    assets.material("screen", textures.screen(), 0.2, 0.5)
    assets.material("keys", textures.keys(), 0.0, 0.0)
    assets.material("clock", textures.clock_face(), 0.0, 0.0)
    assets.material("football", textures.football(), 0.1, 0.3)
    assets.material("basketball", textures.basketball(), 0.1, 0.3)
    assets.material("cover", textures.cover(), 0.05, 0.1)
    for k, (style, rgb) in enumerate(looks.floors):
        picture, repeat_m = _FLOORS[style]
        assets.material(f"floor{k}", picture(rgb), 0.03, 0.1, repeat_m=repeat_m)
    for k in range(len(looks.pictures)):
        assets.material(f"painting{k}", textures.painting(home.seed % 5 + k), 0.0, 0.0)


_FLOORS: Final[dict[str, tuple[Callable[[Vec], bytes], float]]] = {
    "planks": (textures.planks, 0.9),
    "tiles": (textures.tiles, 0.7),
    "carpet": (textures.carpet, 1.2),
}
"""Picture of a floor in a colour, and the side of one repeat of it in m."""


def _lights() -> Iterable[str]:
    for k, (direction, strength) in enumerate(_SKY):
        yield (
            f'<light name="sky_{k}" directional="true" castshadow="false" pos="0 0 6" dir="{_numbers(direction)}"'
            f' diffuse="{strength} {strength} {strength}" specular="0.06 0.06 0.06" ambient="0 0 0"/>'
        )


def _building(home: Home, assets: _Assets) -> Iterable[str]:
    """Floor, walls, skirting, ceiling, rugs, pictures and the dock, as geoms of the world."""
    looks = home.appearance
    middle: Vec = (home.width_m / 2, home.depth_m / 2, 0.0)
    size = f"{middle[0] + 1:.3f} {middle[1] + 1:.3f} 0.1"
    plane = f'type="plane" pos="{_numbers(middle)}" size="{size}"'
    yield f'<geom name="floor" {plane} rgba="0.7 0.66 0.6 1" material="matte"/>'
    for k, room in enumerate(home.rooms):
        x, y = (room.x_min_m + room.x_max_m) / 2, (room.y_min_m + room.y_max_m) / 2
        wide, deep = room.x_max_m - room.x_min_m + 0.1, room.y_max_m - room.y_min_m + 0.1
        cover = box((x, y, 0.0005), (wide, deep, 0.001), WHITE, f"floor{k}", solid=False)
        yield _geom(cover, assets, name=f"floor_{room.name.replace(' ', '_')}")
    for k, wall in enumerate(home.walls):
        centre = ((wall.x_min_m + wall.x_max_m) / 2, (wall.y_min_m + wall.y_max_m) / 2)
        wide, deep = wall.x_max_m - wall.x_min_m, wall.y_max_m - wall.y_min_m
        tall = wall.z_max_m - wall.z_min_m
        block = box((centre[0], centre[1], wall.z_min_m + tall / 2), (wide, deep, tall), looks.wall_rgb)
        yield _geom(block, assets, name=f"wall_{k}")
        if wall.z_min_m == 0.0:
            skirting = box((centre[0], centre[1], 0.035), (wide + 0.016, deep + 0.016, 0.07), looks.skirting_rgb)
            yield _geom(replace(skirting, solid=False), assets)
    ceiling = (middle[0], middle[1], HEIGHT_M + 0.03)
    lid = box(ceiling, (home.width_m + 0.1, home.depth_m + 0.1, 0.05), WHITE, "ceiling")
    yield _geom(replace(lid, solid=False, group=CEILING_GROUP), assets, name="ceiling")
    for k, rug in enumerate(looks.rugs):
        mat = box((rug.x_m, rug.y_m, 0.002), (rug.width_m, rug.depth_m, 0.004), rug.rgb, "fabric", solid=False)
        yield _geom(mat, assets, name=f"rug_{k}")
    for k, (x, y, yaw) in enumerate(looks.pictures):
        frame = [
            box((0, 0.01, 0), (0.72, 0.024, 0.54), (0.25, 0.22, 0.2), solid=False),
            front_panel((0, 0.024, 0), 0.64, 0.46, WHITE, f"painting{k}"),
        ]
        yield _body(f"picture_{k}", (x, y, 1.35), yaw, frame, assets)
    yield _dock(home, assets)


def _dock(home: Home, assets: _Assets) -> str:
    """A low black box at the wall with a white face; the docked robot's nose is just before it."""
    dock = home.dock
    x, y = dock.x_m + math.cos(dock.yaw) * DOCK_GAP_M, dock.y_m + math.sin(dock.yaw) * DOCK_GAP_M
    shape = [
        box((0, 0.03, 0.05), (0.16, 0.06, 0.10), (0.12, 0.12, 0.13)),
        box((0, 0.061, 0.06), (0.05, 0.004, 0.03), (0.85, 0.86, 0.88), solid=False),
    ]
    return _body("dock", (x, y, 0.0), dock.yaw + math.pi / 2, shape, assets)


def _furniture(home: Home, piece: Furniture, assets: _Assets) -> str:
    rgb = home.appearance.quilt_rgb if piece.kind == "bed" else None
    if piece.colour == "brown" and piece.kind == "chair":
        rgb = None
    elif piece.colour is not None:
        rgb = _varied(home, piece.id, piece.colour)
    geoms = furniture_geoms(piece.kind, rgb, piece.size_m, piece.variant)
    return _body(piece.id, (piece.x_m, piece.y_m, 0.0), piece.yaw, geoms, assets)


def _thing(home: Home, thing: Thing, assets: _Assets) -> str:
    rgb = WHITE if thing.colour is None else _varied(home, thing.id, thing.colour)
    geoms = thing_geoms(thing.kind, rgb, thing.size_m, thing.variant)
    return _body(thing.id, (thing.x_m, thing.y_m, thing.z_m), thing.yaw, geoms, assets)


def _varied(home: Home, name: str, colour: str) -> Vec:
    """The named colour, a little lighter or darker for each thing of each home."""
    rng = np.random.default_rng([home.seed, zlib.crc32(name.encode())])
    return shade(rgb_of(colour), float(rng.uniform(0.93, 1.05)))


def _body(name: str, at_m: Vec, yaw: float, geoms: Iterable[Geom], assets: _Assets) -> str:
    inside = "".join(_geom(geom, assets) for geom in geoms)
    return f'<body name="{name}" pos="{_numbers(at_m)}" euler="0 0 {yaw:.5f}">{inside}</body>'


def _geom(geom: Geom, assets: _Assets, name: str = "") -> str:
    named = f'name="{name}" ' if name else ""
    if geom.shape == "mesh":
        # MuJoCo places a mesh by its own origin, which unit meshes have at the middle of their base.
        shape = f'mesh="{assets.mesh(geom.mesh, geom.size_m)}"'
    elif geom.shape == "cylinder":
        shape = f'size="{geom.size_m[0] / 2:.4f} {geom.size_m[2] / 2:.4f}"'
    else:
        w, d, h = geom.size_m
        shape = f'size="{_numbers((w / 2, d / 2, h / 2))}"'
    text = f'<geom {named}type="{geom.shape}" pos="{_numbers(geom.centre_m)}" {shape} material="{geom.material}"'
    text += f' rgba="{_numbers(geom.rgb)} {geom.alpha:g}"'
    if any(geom.euler_rad):
        text += f' euler="{_numbers(geom.euler_rad)}"'
    if not geom.solid:
        text += ' contype="0" conaffinity="0"'
    if geom.group:
        text += f' group="{geom.group}"'
    return text + "/>"


def _numbers(values: Vec) -> str:
    return " ".join(f"{value:.4f}" for value in values)
