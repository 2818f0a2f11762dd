"""What a camera cannot see is not drawn, and no pixel changes by that."""

import math

import numpy as np
import pytest

from sim.world.rendering import aim, open_renderer  # first: it settles how MuJoCo draws, before MuJoCo is loaded

import mujoco  # isort: skip
from sim.home import Home
from sim.world import CameraModel
from sim.world.robot import DEPTH_CAMERA, RGB_CAMERA
from sim.world.scenes import scene_of

HEADINGS = tuple(math.tau * k / 8 for k in range(8))


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    scene = scene_of(Home.generate(11))
    return mujoco.MjModel.from_xml_string(scene.xml, dict(scene.assets))


@pytest.mark.parametrize(("camera", "name"), [(RGB_CAMERA, "rgb"), (DEPTH_CAMERA, "depth")])
def test_leaving_out_what_a_camera_cannot_see_changes_no_pixel(
    model: mujoco.MjModel, camera: CameraModel, name: str
) -> None:
    data = mujoco.MjData(model)
    groups = model.geom_group.copy()
    drawn, whole = [], 0
    with open_renderer(model, camera.width_px, camera.height_px) as renderer:
        for heading in HEADINGS:
            data.qpos[:7] = (*model.stat.center[:2], 0.0, math.cos(heading / 2), 0.0, 0.0, math.sin(heading / 2))
            mujoco.mj_forward(model, data)
            aim(renderer, data, name)
            drawn.append(renderer.scene.ngeom)
            picture = renderer.render()
            renderer.update_scene(data, name)
            whole = renderer.scene.ngeom
            np.testing.assert_array_equal(picture, renderer.render())
    assert max(drawn) < whole / 2
    np.testing.assert_array_equal(model.geom_group, groups)
