"""A camera for memory's story: it knows the truth of a simulated home, and sees of it what a good detector would.

What is visible is asked of the simulator by rays, and so is depth, with the noise of requirement A9.
"""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from contracts.base import BboxXyxy
from contracts.colours import Colour
from contracts.geometry import Point3D, Pose2D
from contracts.measuring import LocalizeRequest, Measurement, NotMeasured, not_measured
from contracts.robot import KnownMap
from contracts.vision import Detection, Detections
from geometry.grids import OccupancyGrid
from robot_bridge.settings import Settings
from sim.home import Home
from sim.home.model import Thing
from sim.world import World
from sim.world.occupancy import reachable
from sim.world.robot import RGB_CAMERA

NOISE = Settings().depth_noise

SEEN_M_MAX = 2.6
DEPTH_M_MAX = 3.0
MARGIN = 0.15
ROBOT_M = 0.24


class Eyes:
    """Where the robot stands is set by hand; `memory.ports.DepthAndMap` besides."""

    def __init__(self, home: Home, seed: int) -> None:
        self.truth = home
        self.world = World(home, seed=seed)
        self.pose = Pose2D(x=0.0, y=0.0, yaw=0.0)
        self._rng = np.random.default_rng(seed)

    def change(self, things: tuple[Thing, ...]) -> None:
        """Somebody carries things about while the robot is not there."""
        self.truth = replace(self.truth, things=things)
        self.world.close()
        self.world = World(self.truth, seed=0)

    def frame(self, stamp_s: float) -> Detections:
        size_px = RGB_CAMERA.width_px, RGB_CAMERA.height_px
        found = [box for thing in self.truth.things if (box := self._detection(thing)) is not None]
        return Detections(
            stamp_s=stamp_s,
            image_width_px=size_px[0],
            image_height_px=size_px[1],
            pose=self.pose,
            detections=tuple(found),
        )

    def sees(self, thing: Thing, pose: Pose2D) -> bool:
        """Well inside the picture, near enough, and nothing hides its middle."""
        at = self._pixel(self.middle(thing), pose)
        if at is None:
            return False
        u, v, away_m = at
        width, height = RGB_CAMERA.width_px, RGB_CAMERA.height_px
        inside = MARGIN * width < u < (1 - MARGIN) * width and MARGIN * height < v < (1 - MARGIN) * height
        return inside and away_m < SEEN_M_MAX and self._first(pose, self.middle(thing))[0] == thing.id

    def middle(self, thing: Thing) -> NDArray[np.float64]:
        corners = np.concatenate([volume.corners() for volume in self.world.volumes(thing.id)])
        return (corners.min(0) + corners.max(0)) / 2.0

    def places_to_see(self, thing: Thing, *, away_m: float, apart_m: float, count: int) -> list[Pose2D]:
        """Poses about `away_m` from a thing from which it is seen, at least `apart_m` from each other."""
        cells = np.argwhere(reachable(self.world.grid, self.world.scene.dock, ROBOT_M))
        points = self.world.grid.centres(cells[:, 0], cells[:, 1])
        x, y, _ = self.middle(thing)
        order = np.argsort(np.abs(np.hypot(points[:, 0] - x, points[:, 1] - y) - away_m))
        chosen: list[Pose2D] = []
        for px, py in points[order[:4000]]:
            pose = Pose2D(x=float(px), y=float(py), yaw=math.atan2(y - py, x - px))
            if all(math.hypot(px - one.x, py - one.y) >= apart_m for one in chosen) and self.sees(thing, pose):
                chosen.append(pose)
            if len(chosen) == count:
                break
        return chosen

    async def localize(self, request: LocalizeRequest) -> tuple[Measurement, ...]:
        near = [self._depth_m(box) for box in request.boxes_xyxy]
        return tuple(Measurement(depth_m=one, sigma_m=NOISE.sigma_m(one) if one is not None else None) for one in near)

    def _measured(self, box: BboxXyxy) -> Measurement:
        ahead_m = self._ahead(_centre(box))
        if ahead_m > DEPTH_M_MAX:
            return not_measured(NotMeasured.NO_DEPTH, "too far")
        sigma_m = NOISE.sigma_m(ahead_m)
        point = self._eye(self.pose) + self._ray(_centre(box)) * (ahead_m + self._rng.normal(0.0, sigma_m))
        place = Point3D(x=float(point[0]), y=float(point[1]), z=float(point[2]))
        return Measurement(distance_m=ahead_m, depth_m=ahead_m, sigma_m=sigma_m, map_point=place)

    def _depth_m(self, box: BboxXyxy) -> float | None:
        """The nearest distance that a good part of the box's middle shares."""
        x_min, y_min, x_max, y_max = box
        us = np.linspace(0.75 * x_min + 0.25 * x_max, 0.25 * x_min + 0.75 * x_max, 5)
        vs = np.linspace(0.8 * y_min + 0.2 * y_max, 0.2 * y_min + 0.8 * y_max, 5)
        near_m = float(np.percentile([self._ahead((u, v)) for u in us for v in vs], 20))
        return near_m if near_m <= DEPTH_M_MAX else None

    async def ground(self) -> OccupancyGrid | None:
        grid = self.world.grid
        return OccupancyGrid(grid.data, grid.resolution_m, Pose2D(x=grid.origin_x_m, y=grid.origin_y_m, yaw=0.0))

    async def home(self) -> KnownMap | None:
        return None

    async def aclose(self) -> None:
        self.world.close()

    def _detection(self, thing: Thing) -> Detection | None:
        if not self.sees(thing, self.pose):
            return None
        corners = np.concatenate([volume.corners() for volume in self.world.volumes(thing.id)])
        pixels = [at for corner in corners if (at := self._pixel(corner, self.pose)) is not None]
        us, vs = [at[0] for at in pixels], [at[1] for at in pixels]
        middle = self._pixel(self.middle(thing), self.pose)
        assert middle is not None, "it is seen"
        box = (min(us), min(vs), max(us), max(vs))
        return Detection(
            label=thing.kind,
            confidence=max(0.35, 0.95 - 0.2 * middle[2]),
            bbox_xyxy=box,
            colour=Colour(thing.colour) if thing.colour else None,
            measurement=self._measured(box),
        )

    def _eye(self, pose: Pose2D) -> NDArray[np.float64]:
        x, z = RGB_CAMERA.x_m, RGB_CAMERA.z_m
        return np.array([pose.x + x * math.cos(pose.yaw), pose.y + x * math.sin(pose.yaw), z])

    def _pixel(self, point: NDArray[np.float64], pose: Pose2D) -> tuple[float, float, float] | None:
        """(u, v, m ahead) of a point of the map."""
        dx, dy, dz = point - self._eye(pose)
        cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
        ahead, left = dx * cos + dy * sin, dy * cos - dx * sin
        if ahead < 0.1:
            return None
        camera = RGB_CAMERA
        return camera.cx - camera.fx * left / ahead, camera.cy - camera.fy * dz / ahead, ahead

    def _ray(self, pixel: tuple[float, float]) -> NDArray[np.float64]:
        """In the map, one metre ahead."""
        left, up = (RGB_CAMERA.cx - pixel[0]) / RGB_CAMERA.fx, (RGB_CAMERA.cy - pixel[1]) / RGB_CAMERA.fy
        cos, sin = math.cos(self.pose.yaw), math.sin(self.pose.yaw)
        return np.array([cos - left * sin, sin + left * cos, up])

    def _ahead(self, pixel: tuple[float, float]) -> float:
        ray = self._ray(pixel)
        _, away_m = self._first(self.pose, self._eye(self.pose) + 10.0 * ray)
        return away_m / float(np.linalg.norm(ray))

    def _first(self, pose: Pose2D, target: NDArray[np.float64]) -> tuple[str, float]:
        return self.world.first_hit(self._eye(pose), target)


def _centre(box: BboxXyxy) -> tuple[float, float]:
    x_min, y_min, x_max, y_max = box
    return (x_min + x_max) / 2.0, (y_min + y_max) / 2.0
