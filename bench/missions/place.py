"""A simulated home as the missions need it: map, ways, lines of sight, what may be looked for, and the judgement."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from skimage.graph import MCP_Geometric

from contracts.geometry import Pose2D
from contracts.robot import Map
from geometry.grids import OccupancyGrid, encode
from geometry.poses import compose
from sim.home import Home, Wanted
from sim.home.catalog import THINGS
from sim.nav.codes import Code, NavigationError
from sim.nav.costmap import Costmap
from sim.nav.planner import TOLERANCE_M, nearest_cell
from sim.scoring import NothingToScoreError, Score, camera_position, nearest_surface_m, score
from sim.world import World
from sim.world.robot import RGB_CAMERA
from sim.world.types import ThingTruth

ELSEWHERE_M = 0.15
"""robot_bridge's: a plan that ends farther from its goal is none."""


@dataclass(frozen=True)
class InPicture:
    """A thing the camera sees: its box in the picture (px), and how much of it is not hidden, 0 to 1."""

    thing: ThingTruth
    bbox_xyxy: tuple[float, float, float, float]
    visible: float
    distance_m: float
    """From the camera to the nearest surface, along the floor."""


class SimulatedPlace:
    """One home; missions in it share it one after another. Nothing in it moves."""

    def __init__(self, seed: int, kind: str, colour: str | None) -> None:
        self.world = World(Home.generate(seed, wanted=Wanted(kind, colour)), seed=seed)
        self.kind, self.colour = kind, colour
        self.grid = self.world.grid
        self.costmap = Costmap.from_map(self.grid)
        self.things = tuple(t for t in self.world.truth.things if t.kind in THINGS)
        self.dock = self.world.scene.dock
        self.off_dock = compose(self.dock, Pose2D(x=-0.45, y=0.0, yaw=math.pi))
        self._volumes = {t.id: self.world.volumes(t.id) for t in self.things}
        self._corners = {
            name: np.concatenate([volume.corners() for volume in volumes]) for name, volumes in self._volumes.items()
        }
        self._ways: tuple[tuple[int, int], MCP_Geometric, NDArray[np.float64]] | None = None

    def close(self) -> None:
        self.world.close()

    @cached_property
    def map_message(self) -> Map:
        origin = Pose2D(x=self.grid.origin_x_m, y=self.grid.origin_y_m, yaw=0.0)
        return encode(OccupancyGrid(self.grid.data, self.grid.resolution_m, origin))

    # --- ways

    def clearance_m(self, x: float, y: float) -> float:
        """To the nearest obstacle of the map; 0 outside."""
        cell = self.costmap.grid.cell(x, y)
        return float(self.costmap.clearance_m[cell]) if cell is not None else 0.0

    def reachable_cells(self, start: Pose2D) -> NDArray[np.bool_]:
        return np.isfinite(self._costs(self._start_cell(start))[1])

    def way(self, start: Pose2D, goal: Pose2D) -> NDArray[np.float64]:
        """(n, 2) points from start to goal, in m, ending up to `ELSEWHERE_M` beside it where it is occupied.

        Raises `NavigationError` with the planner's code, or where the plan would end farther off.
        """
        cell, start_cell = self.costmap.grid.cell(goal.x, goal.y), self._start_cell(start)
        if cell is None:
            raise NavigationError(Code.GOAL_OUTSIDE_MAP, "the goal is outside the map")
        search, costs = self._costs(start_cell)
        reachable = np.isfinite(costs)
        end = nearest_cell(reachable, cell, round(TOLERANCE_M / self.costmap.grid.resolution_m))
        if end is None:
            raise NavigationError(Code.NO_VALID_PATH, "no way leads there")
        last = np.array([goal.x, goal.y]) if end == cell else self.costmap.grid.centres(*np.array(end))
        if math.hypot(last[0] - goal.x, last[1] - goal.y) > ELSEWHERE_M:
            raise NavigationError(Code.NO_VALID_PATH, "the plan ends elsewhere")
        cells = np.array(search.traceback(end), dtype=np.intp).reshape(-1, 2)[2:-1:2]
        middle = self.costmap.grid.centres(cells[:, 0], cells[:, 1])
        return np.concatenate([[[start.x, start.y]], middle, [last]])

    def _start_cell(self, start: Pose2D) -> tuple[int, int]:
        cell = self.costmap.grid.cell(start.x, start.y)
        if cell is None:
            raise NavigationError(Code.START_OUTSIDE_MAP, "the start is outside the map")
        return cell

    def _costs(self, start: tuple[int, int]) -> tuple[MCP_Geometric, NDArray[np.float64]]:
        """As NavFn, the one cell under the robot counts as free whatever it holds."""
        if self._ways is None or self._ways[0] != start:
            price = self.costmap.price.copy()
            price[start] = max(price[start], 1.0)
            search = MCP_Geometric(price, fully_connected=True)
            costs, _ = search.find_costs([start])
            self._ways = (start, search, costs)
        return self._ways[1], self._ways[2]

    # --- sight

    def in_picture(self, pose: Pose2D, *, range_m: float = 3.2) -> tuple[InPicture, ...]:
        """What the colour camera of a robot standing at `pose` (true) shows, hidden parts left out."""
        camera = camera_position(pose)
        found = (self._seen(thing, pose, camera) for thing in self._near(pose, range_m))
        return tuple(one for one in found if one is not None)

    def _near(self, pose: Pose2D, range_m: float) -> list[ThingTruth]:
        """Within range, and not clearly beside or behind."""
        near = (t for t in self.things if math.hypot(t.x_m - pose.x, t.y_m - pose.y) <= range_m)
        return [
            t for t in near if abs(self._bearing(t, pose)) < 0.9 or math.hypot(t.x_m - pose.x, t.y_m - pose.y) < 0.6
        ]

    @staticmethod
    def _bearing(thing: ThingTruth, pose: Pose2D) -> float:
        return math.remainder(math.atan2(thing.y_m - pose.y, thing.x_m - pose.x) - pose.yaw, math.tau)

    def _seen(self, thing: ThingTruth, pose: Pose2D, camera: NDArray[np.float64]) -> InPicture | None:
        corners = self._corners[thing.id] - camera
        cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
        ahead = cos * corners[:, 0] + sin * corners[:, 1]
        if ahead.min() < 0.05:
            return None
        left = -sin * corners[:, 0] + cos * corners[:, 1]
        cam = RGB_CAMERA
        u, v = cam.cx - cam.fx * left / ahead, cam.cy - cam.fy * corners[:, 2] / ahead
        whole = (u.max() - u.min()) * (v.max() - v.min())
        box = (max(0.0, float(u.min())), max(0.0, float(v.min())),
               min(float(cam.width_px), float(u.max())), min(float(cam.height_px), float(v.max())))  # fmt: skip
        width, height = box[2] - box[0], box[3] - box[1]
        if width < 2.0 or height < 2.0 or width * height < 0.3 * whole:
            return None
        visible = self._visible(thing, camera) * min(1.0, width * height / whole)
        away_m = min(float(volume.horizontal_distance_m(camera)) for volume in self._volumes[thing.id])
        return InPicture(thing, box, visible, away_m)

    def _visible(self, thing: ThingTruth, camera: NDArray[np.float64]) -> float:
        """The share of nine points of the thing that nothing else hides."""
        corners = self._corners[thing.id]
        low, high = corners.min(0), corners.max(0)
        middle = (low + high) / 2
        across = np.array([camera[1] - middle[1], middle[0] - camera[0], 0.0])
        across *= 0.3 * min(high[0] - low[0], high[1] - low[1]) / max(float(np.linalg.norm(across)), 1e-6)
        clear = 0
        for share in (0.25, 0.5, 0.8):
            for side in (-1.0, 0.0, 1.0):
                point = middle + side * across
                point[2] = low[2] + share * (high[2] - low[2])
                name, hit_m = self.world.first_hit(camera, point)
                clear += name == thing.id or hit_m >= float(np.linalg.norm(point - camera)) - 0.02
        return clear / 9.0

    def depth_at(self, pose: Pose2D, u_px: float, v_px: float) -> float:
        """True distance along the floor to whatever that pixel shows, m; inf for nothing."""
        cam = RGB_CAMERA
        left, up = (cam.cx - u_px) / cam.fx, (cam.cy - v_px) / cam.fy
        cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
        along = np.array([cos - sin * left, sin + cos * left, up])
        camera = camera_position(pose)
        _, hit_m = self.world.first_hit(camera, camera + along)
        return hit_m * math.hypot(1.0, left) / math.sqrt(1.0 + left * left + up * up)

    def surface_m(self, thing: ThingTruth, pose: Pose2D) -> float:
        """True distance from the camera of a robot at `pose` to the nearest surface of the thing."""
        return nearest_surface_m(self._volumes[thing.id], camera_position(pose))

    # --- places and judgement

    def views_of(self, x: float, y: float, rng: np.random.Generator, count: int) -> tuple[Pose2D, ...]:
        """Reachable poses 0.9 to 1.8 m from a point, facing it: what somebody mapping the home would have noted."""
        rows, columns = np.nonzero(self.reachable_cells(self.off_dock))
        places = self.costmap.grid.centres(rows, columns)
        away = np.hypot(places[:, 0] - x, places[:, 1] - y)
        fit = np.flatnonzero((away > 0.9) & (away < 1.8))
        if not len(fit):
            return ()
        chosen = places[rng.choice(fit, size=min(count * 12, len(fit)), replace=False)]
        poses = (Pose2D(x=px, y=py, yaw=math.atan2(y - py, x - px)) for px, py in chosen.tolist())
        return tuple(pose for pose in poses if self._sees(pose, x, y))[:count]

    def _sees(self, pose: Pose2D, x: float, y: float) -> bool:
        camera = camera_position(pose)
        point = np.array([x, y, float(camera[2])])
        left_m = float(np.linalg.norm(point - camera))
        return self.world.first_hit(camera, point)[1] > left_m - 0.35

    def random_pose(self, rng: np.random.Generator) -> Pose2D:
        rows, columns = np.nonzero(self.reachable_cells(self.off_dock))
        k = int(rng.integers(len(rows)))
        x, y = self.costmap.grid.centres(rows[k : k + 1], columns[k : k + 1])[0].tolist()
        return Pose2D(x=x, y=y, yaw=float(rng.uniform(-math.pi, math.pi)))

    def judge(self, pose: Pose2D, kind: str, colour: str | None) -> Score | None:
        """How a robot at `pose` stands towards such a thing; none where the home holds none."""
        self.world.teleport(pose)
        try:
            return score(self.world, kind, colour)
        except NothingToScoreError:
            return None
