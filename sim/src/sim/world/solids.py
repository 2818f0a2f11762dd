"""What the compiled model is made of, as corner points in the map: outlines for the grid, boxes for scoring."""

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]
_ROUND = 16

_BOX = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
_BOX_EDGES = np.array([(a, b) for a in range(8) for b in range(a) if bin(a ^ b).count("1") == 1])


@dataclass(frozen=True)
class Solid:
    """A convex body: corners (n, 3) in the map, m, and edges (m, 2) between them."""

    corners: Points
    edges: NDArray[np.int64]


@dataclass(frozen=True)
class Volume:
    """An oriented box in the map: centre (3,), half sizes (3,) in m, axes as the columns of a rotation (3, 3)."""

    centre: Points
    half: Points
    axes: Points

    def distance_m(self, points: Points) -> Points:
        """From each point (n, 3) to the box's nearest surface; 0 inside."""
        local = (points - self.centre) @ self.axes
        return np.linalg.norm(np.maximum(np.abs(local) - self.half, 0.0), axis=-1)

    def horizontal_distance_m(self, points: Points) -> Points:
        """The same along the floor, heights left out."""
        corners = self.corners()
        tall = Volume(self.centre, self.half, self.axes)
        lifted = points.copy()
        lifted[..., 2] = np.clip(points[..., 2], corners[:, 2].min(), corners[:, 2].max())
        return tall.distance_m(lifted)

    def corners(self) -> Points:
        return self.centre + (_BOX * self.half) @ self.axes.T


def volumes_of_body(model: mujoco.MjModel, data: mujoco.MjData, body: int) -> tuple[Volume, ...]:
    """The bounding boxes of a body's visible geoms, each along the geom's own axes."""
    first, count = int(model.body_geomadr[body]), int(model.body_geomnum[body])
    geoms = range(first, first + count) if first >= 0 else range(0)
    return tuple(_volume(model, data, geom) for geom in geoms if _visible(model, geom))


def _volume(model: mujoco.MjModel, data: mujoco.MjData, geom: int) -> Volume:
    box = model.geom_aabb[geom]
    axes = data.geom_xmat[geom].reshape(3, 3).copy()
    return Volume(data.geom_xpos[geom] + axes @ box[:3], np.array(box[3:]), axes)


def solid_of_geom(model: mujoco.MjModel, data: mujoco.MjData, geom: int) -> Solid | None:
    """The geom's convex outline in the map; None for planes and for what nobody can see or touch."""
    if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_PLANE or not _visible(model, geom):
        return None
    local, edges = _outline(model, geom)
    return Solid(data.geom_xpos[geom] + local @ data.geom_xmat[geom].reshape(3, 3).T, edges)


def _visible(model: mujoco.MjModel, geom: int) -> bool:
    material = int(model.geom_matid[geom])
    alpha = model.mat_rgba[material, 3] if material >= 0 else 1.0
    return bool(alpha * model.geom_rgba[geom, 3] > 0)


def _outline(model: mujoco.MjModel, geom: int) -> tuple[Points, NDArray[np.int64]]:
    size = model.geom_size[geom]
    match mujoco.mjtGeom(int(model.geom_type[geom])):
        case mujoco.mjtGeom.mjGEOM_BOX:
            return _BOX * size, _BOX_EDGES
        case mujoco.mjtGeom.mjGEOM_CYLINDER:
            return _stack([(size[0], -size[1]), (size[0], size[1])])
        case mujoco.mjtGeom.mjGEOM_SPHERE:
            return _ellipsoid(np.full(3, size[0]))
        case mujoco.mjtGeom.mjGEOM_ELLIPSOID:
            return _ellipsoid(size)
        case mujoco.mjtGeom.mjGEOM_MESH:
            return _mesh(model, int(model.geom_dataid[geom]))
        case _:
            box = model.geom_aabb[geom]
            return box[:3] + _BOX * box[3:], _BOX_EDGES


def _stack(rings: list[tuple[float, float]]) -> tuple[Points, NDArray[np.int64]]:
    """Rings (radius, height) of a body of revolution, joined by upright edges."""
    angle = np.arange(_ROUND) * (2 * np.pi / _ROUND)
    circle = np.stack([np.cos(angle), np.sin(angle)], 1)
    points = np.concatenate([np.column_stack([circle * radius, np.full(_ROUND, z)]) for radius, z in rings])
    spokes = np.arange(_ROUND)
    edges = [np.stack([spokes + k * _ROUND, spokes + (k + 1) * _ROUND], 1) for k in range(len(rings) - 1)]
    return points, np.concatenate(edges)


def _ellipsoid(half: Points) -> tuple[Points, NDArray[np.int64]]:
    latitude = np.linspace(-np.pi / 2, np.pi / 2, 9)
    points, edges = _stack([(float(np.cos(a)), float(np.sin(a))) for a in latitude])
    return points * half, edges


def _mesh(model: mujoco.MjModel, mesh: int) -> tuple[Points, NDArray[np.int64]]:
    vertex, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    face, faces = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
    triangles = model.mesh_face[face : face + faces]
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    return model.mesh_vert[vertex : vertex + count].astype(float), np.unique(np.sort(edges, 1), axis=0).astype(np.int64)
