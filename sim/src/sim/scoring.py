"""Whether the robot really stands before the right thing: a judgement from ground truth, never shown to a mission."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from contracts.geometry import Pose2D
from sim.world.occupancy import reachable
from sim.world.robot import CAMERA_X_M, CAMERA_Z_M, ROBOT_RADIUS_M
from sim.world.solids import Volume
from sim.world.types import OccupancyGrid, ThingTruth
from sim.world.world import World

ARRIVED_WITHIN_M = 0.6
AS_NEAR_AS_POSSIBLE_SLACK_M = 0.15
FACING_WITHIN_RAD = math.radians(30.0)
_LOOKED_AT_WITHIN_M = 3.0
_PASSES_MAX = 6


class NothingToScoreError(LookupError):
    """The home holds no such thing: there is no distance to it."""


@dataclass(frozen=True, slots=True)
class InFront:
    """A thing the camera faces with no wall or furniture between, and how far its surface is."""

    id: str
    kind: str
    colour: str
    distance_m: float


@dataclass(frozen=True, slots=True)
class Score:
    """How the robot stands towards the matching thing that suits it best.

    Distances run from the camera to the nearest surface of the boxes around the thing's parts: `true_distance_m` in
    space, `horizontal_distance_m` along the floor, which is what a level depth camera measures.
    """

    thing_id: str
    true_distance_m: float
    horizontal_distance_m: float
    bearing_rad: float
    """Of the thing's middle from the camera's axis, counter-clockwise positive."""
    facing: bool
    unobstructed: bool
    """No wall and no furniture stands between, at the thing's own height."""
    nearest_possible_m: float
    """The smallest `true_distance_m` a robot could have on the map, coming from the dock; inf if none."""
    correct: bool
    in_front: tuple[InFront, ...]
    """Everything that may be looked for within 3 m before the camera, nearest first, matching or not."""


def score(world: World, kind: str, colour: str | None) -> Score:
    """Judge the robot's pose for "find the `colour` `kind`"; colour None or "" means any.

    Correct: faced within 30 degrees, unobstructed, and the true distance at most 0.6 m, or at most 0.15 m more than
    the nearest that the map allows. Of several matching things a correct one counts, else the nearest.
    Raises NothingToScoreError if the home holds no such thing.
    """
    truth = world.truth
    matching = [thing for thing in truth.things if thing.kind == kind and (not colour or thing.colour == colour)]
    if not matching:
        raise NothingToScoreError(f"this home holds no {colour or ''} {kind}".replace("  ", " "))
    in_front = _in_front(world, truth.pose, truth.things)
    scores = [_score_thing(world, truth.pose, thing, in_front) for thing in matching]
    return min(scores, key=lambda s: (not s.correct, s.true_distance_m))


def _score_thing(world: World, pose: Pose2D, thing: ThingTruth, in_front: tuple[InFront, ...]) -> Score:
    camera, volumes = camera_position(pose), world.volumes(thing.id)
    distance_m = nearest_surface_m(volumes, camera)
    bearing = _bearing(pose, thing)
    facing = abs(bearing) <= FACING_WITHIN_RAD
    clear = unobstructed(world, camera, thing)
    possible_m = nearest_possible_m(world, thing)
    enough_m = max(ARRIVED_WITHIN_M, possible_m + AS_NEAR_AS_POSSIBLE_SLACK_M) if math.isfinite(possible_m) else 0.6
    return Score(
        thing_id=thing.id,
        true_distance_m=distance_m,
        horizontal_distance_m=min(float(v.horizontal_distance_m(camera)) for v in volumes),
        bearing_rad=bearing,
        facing=facing,
        unobstructed=clear,
        nearest_possible_m=possible_m,
        correct=facing and clear and distance_m <= enough_m,
        in_front=in_front,
    )


def camera_position(pose: Pose2D) -> NDArray[np.float64]:
    """(3,) m, in the map."""
    x, y = pose.x + CAMERA_X_M * math.cos(pose.yaw), pose.y + CAMERA_X_M * math.sin(pose.yaw)
    return np.array([x, y, CAMERA_Z_M])


def nearest_surface_m(volumes: tuple[Volume, ...], point: NDArray[np.float64]) -> float:
    """From a point (3,) to the nearest of the boxes, m; 0 inside one."""
    return min(float(volume.distance_m(point)) for volume in volumes)


def unobstructed(world: World, camera: NDArray[np.float64], thing: ThingTruth) -> bool:
    """Whether a line upright from the camera to the thing's own height, then level to the thing, is clear.

    Not a straight line, because a table's edge hides what stands on it from a camera this low, and yet it is arrived
    at; upright first, so that a robot under the table has not arrived. Other things to be looked for do not obstruct.
    """
    corners = np.concatenate([volume.corners() for volume in world.volumes(thing.id)])
    low, high = corners[:, 2].min(), corners[:, 2].max()
    middle = np.array([thing.x_m, thing.y_m])
    side = np.array([camera[1] - middle[1], middle[0] - camera[0]])
    side *= 0.3 * min(np.ptp(corners[:, 0]), np.ptp(corners[:, 1])) / max(float(np.linalg.norm(side)), 1e-6)
    small = frozenset(other.id for other in world.truth.things if not other.furniture)
    for share in (0.5, 0.8, 0.25):
        height = low + share * (high - low)
        above = np.array([camera[0], camera[1], height])
        if world.first_hit(camera, above)[1] < abs(height - camera[2]):
            continue
        for shift in (0.0, 1.0, -1.0):
            target = np.array([*(middle + shift * side), height])
            if _reaches(world, above, target, thing.id, small):
                return True
    return False


def _reaches(
    world: World, start: NDArray[np.float64], target: NDArray[np.float64], thing_id: str, small: frozenset[str]
) -> bool:
    """Whether the line ends at the thing, passing through `small` things only."""
    along = (target - start) / max(float(np.linalg.norm(target - start)), 1e-9)
    left_m = float(np.linalg.norm(target - start))
    for _ in range(_PASSES_MAX):
        name, hit_m = world.first_hit(start, start + along)
        if name == thing_id or hit_m >= left_m:
            return True  # hollow things (a bowl, an umbrella) let the line through to their middle
        if name not in small:
            return False
        start, left_m = start + along * (hit_m + 0.002), left_m - hit_m - 0.002
    return False


def nearest_possible_m(world: World, thing: ThingTruth) -> float:
    """The smallest true distance from a camera that faces the thing, over all places a robot can reach from its dock.

    Places are the map's cells with the robot's radius of clearance, connected to the dock; those with a wall or
    furniture before the thing do not count.
    """
    volumes = world.volumes(thing.id)
    cameras = _possible_cameras(world.grid, world.scene.dock, thing)
    if len(cameras) == 0:
        return math.inf
    distances = np.min([volume.distance_m(cameras) for volume in volumes], axis=0)
    for index in np.argsort(distances, kind="stable")[:400]:
        if unobstructed(world, cameras[index], thing):
            return float(distances[index])
    return math.inf


def _possible_cameras(grid: OccupancyGrid, dock: Pose2D, thing: ThingTruth) -> NDArray[np.float64]:
    """(n, 3) camera positions of robots on every reachable cell within 3 m, each turned to the thing."""
    rows, columns = np.nonzero(reachable(grid, dock, ROBOT_RADIUS_M))
    x, y = grid.centres(rows, columns).T
    away = np.hypot(thing.x_m - x, thing.y_m - y)
    near = (away < _LOOKED_AT_WITHIN_M) & (away > 1e-3)
    x, y, away = x[near], y[near], away[near]
    ahead = CAMERA_X_M / away
    return np.stack([x + (thing.x_m - x) * ahead, y + (thing.y_m - y) * ahead, np.full(len(away), CAMERA_Z_M)], axis=1)


def _in_front(world: World, pose: Pose2D, things: tuple[ThingTruth, ...]) -> tuple[InFront, ...]:
    camera = camera_position(pose)
    found: list[InFront] = []
    for thing in things:
        if math.hypot(thing.x_m - pose.x, thing.y_m - pose.y) > _LOOKED_AT_WITHIN_M + 1.0:
            continue
        distance_m = nearest_surface_m(world.volumes(thing.id), camera)
        faced = abs(_bearing(pose, thing)) <= FACING_WITHIN_RAD
        if faced and distance_m <= _LOOKED_AT_WITHIN_M and unobstructed(world, camera, thing):
            found.append(InFront(thing.id, thing.kind, thing.colour, distance_m))
    return tuple(sorted(found, key=lambda item: item.distance_m))


def _bearing(pose: Pose2D, thing: ThingTruth) -> float:
    camera = camera_position(pose)
    return math.remainder(math.atan2(thing.y_m - camera[1], thing.x_m - camera[0]) - pose.yaw, 2 * math.pi)
