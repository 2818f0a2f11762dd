"""A camera in a home: the picture, and a box for everything that can be seen in it, from segmentation."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import TracebackType
from typing import Self

import numpy as np
import numpy.typing as npt

from sim.home import Home, home_mjcf
from sim.training.records import IMAGE_SIZE_PX, LABEL_ID, Box
from sim.training.views import View
from sim.world.rendering import open_renderer  # first: it settles how MuJoCo draws, before MuJoCo is loaded
from sim.world.robot import CAMERA_X_M, SHELL_XML

import mujoco  # isort: skip

SHORT_SIDE_MIN_PX = 7
PIXELS_MIN = 30
VISIBLE_BOX_MIN = 0.25
"""A box smaller than this share of what it would be with nothing in the way is not labelled."""
FILLED_MIN = 0.10
THIN_KINDS = frozenset({"chair", "dining table", "bench", "umbrella", "potted plant"})
"""Kinds of which one sees mostly what is behind them: how much of their box they fill says nothing."""

_CAMERA = "training_camera"
_ROBOT_XML = (
    f'<body name="{_CAMERA}" mocap="true"><camera name="{_CAMERA}" xyaxes="0 -1 0 0 0 1"/></body>'
    f'<body name="training_robot" mocap="true">{SHELL_XML}</body>'
)
"""The camera by itself, so that it can be a little askew on the robot, whose front edge it sees."""
_GEOM = int(mujoco.mjtObj.mjOBJ_GEOM)


@dataclass(frozen=True)
class _Owner:
    """Something that gets a label."""

    name: str
    kind: str
    colour: str
    x_m: float
    y_m: float
    geoms: npt.NDArray[np.intp]


class HomeCamera:
    """Renders views of one home; a context manager, because the graphics context must be given back."""

    def __init__(self, home: Home) -> None:
        text, assets = home_mjcf(home, robot_xml=_ROBOT_XML, offscreen_px=(IMAGE_SIZE_PX, IMAGE_SIZE_PX))
        self._model = mujoco.MjModel.from_xml_string(text, assets)
        self._data = mujoco.MjData(self._model)
        self._owners = [
            _Owner(piece.id, piece.kind, piece.colour or "", piece.x_m, piece.y_m, self._geoms_of(piece.id))
            for piece in (*home.things, *home.furniture)
            if piece.kind in LABEL_ID
        ]
        self._owner_of = np.full(self._model.ngeom + 1, -1)  # the last entry stands for "no geom"
        for index, owner in enumerate(self._owners):
            self._owner_of[owner.geoms] = index
        self._renderer = open_renderer(self._model, IMAGE_SIZE_PX, IMAGE_SIZE_PX)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._renderer.close()

    def boxes(self, view: View) -> tuple[Box, ...]:
        """Everything visible enough to be named; also moves the camera, so that `picture` shows the same view."""
        self._move(view)
        self._renderer.enable_segmentation_rendering()
        self._renderer.update_scene(self._data, _CAMERA)
        segments = self._renderer.render()
        self._renderer.disable_segmentation_rendering()
        geoms = np.where(segments[..., 1] == _GEOM, segments[..., 0], self._model.ngeom)
        owners = self._owner_of[geoms]
        found = (self._box(owners == index, self._owners[index], view) for index in np.unique(owners[owners >= 0]))
        return tuple(box for box in found if box is not None)

    def picture(self) -> npt.NDArray[np.uint8]:
        """The RGB picture (size, size, 3) from where `boxes` looked."""
        self._renderer.update_scene(self._data, _CAMERA)
        return self._renderer.render()

    def _geoms_of(self, body_name: str) -> npt.NDArray[np.intp]:
        body = self._model.body(body_name)
        first = int(body.geomadr[0])
        return np.arange(first, first + int(body.geomnum[0]))

    def _move(self, view: View) -> None:
        self._model.cam_fovy[0] = view.field_of_view_deg
        self._data.mocap_pos[0] = (view.x_m, view.y_m, view.z_m)
        turns = [((0, 0, 1), view.yaw), ((0, 1, 0), view.pitch), ((1, 0, 0), view.roll)]
        pose = np.array([1.0, 0.0, 0.0, 0.0])
        for axis, angle in turns:
            turn, product = np.zeros(4), np.zeros(4)
            mujoco.mju_axisAngle2Quat(turn, np.array(axis, float), angle)
            mujoco.mju_mulQuat(product, pose, turn)
            pose = product
        self._data.mocap_quat[0] = pose
        cos, sin = math.cos(view.yaw), math.sin(view.yaw)
        self._data.mocap_pos[1] = (view.x_m - CAMERA_X_M * cos, view.y_m - CAMERA_X_M * sin, 0.0)
        self._data.mocap_quat[1] = (math.cos(view.yaw / 2), 0.0, 0.0, math.sin(view.yaw / 2))
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_camlight(self._model, self._data)

    def _box(self, mask: npt.NDArray[np.bool_], owner: _Owner, view: View) -> Box | None:
        rows, columns = np.nonzero(mask)
        x_min, y_min = int(columns.min()), int(rows.min())
        x_max, y_max = int(columns.max()) + 1, int(rows.max()) + 1
        if min(x_max - x_min, y_max - y_min) < SHORT_SIDE_MIN_PX or len(rows) < PIXELS_MIN:
            return None
        whole_px2 = self._unhidden_area_px2(owner, view)
        if whole_px2 is not None:
            if (x_max - x_min) * (y_max - y_min) < VISIBLE_BOX_MIN * whole_px2:
                return None
            if len(rows) < FILLED_MIN * whole_px2 and owner.kind not in THIN_KINDS:
                return None
        distance_m = math.hypot(owner.x_m - view.x_m, owner.y_m - view.y_m)
        return Box(owner.name, owner.kind, owner.colour, (x_min, y_min, x_max, y_max), round(distance_m, 2), len(rows))

    def _unhidden_area_px2(self, owner: _Owner, view: View) -> float | None:
        """Area of the box the thing would have with nothing in front, cut to the picture; None when partly behind."""
        model, data = self._model, self._data
        corner = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
        bounds = model.geom_aabb[owner.geoms]
        local = bounds[:, None, :3] + corner[None] * bounds[:, None, 3:]
        turned = np.einsum("gij,gkj->gki", data.geom_xmat[owner.geoms].reshape(-1, 3, 3), local)
        world = turned + data.geom_xpos[owner.geoms][:, None]
        seen = (world.reshape(-1, 3) - data.cam_xpos[0]) @ data.cam_xmat[0].reshape(3, 3)
        depth_m = -seen[:, 2]  # a MuJoCo camera looks along its own -z, y up
        if (depth_m < 0.03).any():
            return None
        half_px = IMAGE_SIZE_PX / 2
        focal_px = half_px / math.tan(math.radians(view.field_of_view_deg) / 2)
        x_px = np.clip(half_px + focal_px * seen[:, 0] / depth_m, 0, IMAGE_SIZE_PX)
        y_px = np.clip(half_px - focal_px * seen[:, 1] / depth_m, 0, IMAGE_SIZE_PX)
        return float((x_px.max() - x_px.min()) * (y_px.max() - y_px.min()))


def kinds_in(frames_boxes: Mapping[str, int]) -> str:
    """A count of kinds as one readable line, most frequent first."""
    return ", ".join(f"{kind} {count}" for kind, count in sorted(frames_boxes.items(), key=lambda item: -item[1]))
