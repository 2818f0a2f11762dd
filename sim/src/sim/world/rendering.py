"""The one way pictures of a home are made, so that the robot sees what its detector was trained on.

MuJoCo renders on the processor through EGL and Mesa. Both read their settings from the environment when they are first
loaded: import this module before `mujoco`.
"""

import ctypes.util
import math
import os
from typing import Any

os.environ.setdefault("MUJOCO_GL", "egl")
os.environ.setdefault("LP_NUM_THREADS", "1")

import mujoco
import numpy as np
from numpy.typing import NDArray

from sim.world.types import Floats

MAX_GEOMS = 5000
UNDRAWN_GROUP = 5
"""MuJoCo draws the geom groups 0 to 2."""
INSTALL_HINT = "apt-get install -y --no-install-recommends libegl1 libopengl0 libgl1-mesa-dri"


class RenderingUnavailableError(RuntimeError):
    """Pictures cannot be made on this machine; the message names what to install."""


def open_renderer(model: mujoco.MjModel, width: int, height: int) -> mujoco.Renderer:
    """A colour renderer of the project's look; the caller closes it, and uses it from one thread only.

    The look is the model's own lights and materials, without shadows (each would cost 100 ms and more) and with the
    model's `offsamples` (MuJoCo's default of 4). Raises RenderingUnavailableError where EGL is missing.
    """
    _require_egl()
    model.light_castshadow[:] = 0
    try:
        return mujoco.Renderer(model, height=height, width=width, max_geom=MAX_GEOMS)
    except (RuntimeError, ImportError, AttributeError) as error:
        raise _unavailable(str(error)) from error


class DepthRenderer:
    """Distances along the optical axis, from a renderer without colours, lights or smoothing."""

    def __init__(self, model: mujoco.MjModel, height_px: int, width_px: int) -> None:
        samples = int(model.vis.quality.offsamples)
        model.vis.quality.offsamples = 0
        try:
            self._renderer = open_renderer(model, width_px, height_px)
        finally:
            model.vis.quality.offsamples = samples
        self._renderer.enable_depth_rendering()
        self._out = np.empty((height_px, width_px), np.float32)

    def render(self, data: mujoco.MjData, camera: str) -> Floats:
        """Float32 (height, width), m; the array is reused by the next call."""
        aim(self._renderer, data, camera)
        return self._renderer.render(out=self._out)

    def close(self) -> None:
        self._renderer.close()


def render_rgb(renderer: mujoco.Renderer, data: mujoco.MjData, camera: str) -> "np.ndarray[Any, np.dtype[np.uint8]]":
    """uint8 (height, width, 3) from a named camera of the model."""
    aim(renderer, data, camera)
    return renderer.render()


def aim(renderer: mujoco.Renderer, data: mujoco.MjData, camera: str) -> None:
    """Makes the scene that a camera sees. MuJoCo would have every geom of the home drawn, also behind the camera."""
    model = renderer.model
    groups = model.geom_group.copy()
    model.geom_group[_unseen(model, data, model.camera(camera).id, renderer.width / renderer.height)] = UNDRAWN_GROUP
    try:
        renderer.update_scene(data, camera)
    finally:
        model.geom_group[:] = groups


def _unseen(model: mujoco.MjModel, data: mujoco.MjData, camera: int, aspect: float) -> NDArray[np.bool_]:
    """Geoms whose bounding sphere lies outside of what the camera's picture shows."""
    right_up_back = (data.geom_xpos - data.cam_xpos[camera]) @ data.cam_xmat[camera].reshape(3, 3)
    aside, ahead = np.abs(right_up_back[:, :2]), -right_up_back[:, 2]
    tall = math.radians(model.cam_fovy[camera]) / 2
    wide = math.atan(math.tan(tall) * aspect)
    beside_m = aside[:, 0] * math.cos(wide) - ahead * math.sin(wide)
    above_m = aside[:, 1] * math.cos(tall) - ahead * math.sin(tall)
    outside_m = np.maximum(np.maximum(beside_m, above_m), -ahead)
    bounded = model.geom_rbound > 0.0  # a plane has none
    return bounded & (outside_m > model.geom_rbound)


def _require_egl() -> None:
    if os.environ.get("MUJOCO_GL") == "egl" and ctypes.util.find_library("EGL") is None:
        raise _unavailable("libEGL was not found")


def _unavailable(why: str) -> RenderingUnavailableError:
    return RenderingUnavailableError(f"The simulated cameras need EGL and Mesa ({why}): {INSTALL_HINT}")
