"""A home's MuJoCo model compiles, names its bodies after the home's items, and carries a robot along."""

import mujoco
import numpy as np
import pytest

from sim.home import Home, home_mjcf
from sim.home.catalog import FURNITURE, KINDS, THINGS, rgb_of
from sim.home.furniture import furniture_geoms
from sim.home.mjcf import CEILING_GROUP
from sim.home.shapes import WHITE, Geom
from sim.home.things import thing_geoms

ROBOT = '<body name="robot" pos="0 0 0.1"><freejoint/><geom name="hull" type="sphere" size="0.1"/></body>'


def model_of(home: Home, robot_xml: str = "") -> mujoco.MjModel:
    text, assets = home_mjcf(home, robot_xml=robot_xml)
    return mujoco.MjModel.from_xml_string(text, assets)


@pytest.mark.parametrize("seed", range(20, 26))
def test_the_model_compiles_and_stays_small(seed: int) -> None:
    home = Home.generate(seed)
    model = model_of(home)
    bodies = {model.body(k).name for k in range(model.nbody)}
    assert {item.id for item in (*home.things, *home.furniture)} <= bodies
    assert model.ngeom < 700
    assert model.nmeshface < 60_000
    assert model.nq == 0


def test_the_floor_is_named_and_the_ceiling_can_be_left_out() -> None:
    model = model_of(Home.generate(0))
    assert model.geom("floor").type == mujoco.mjtGeom.mjGEOM_PLANE
    groups = [int(model.geom_group[k]) for k in range(model.ngeom)]
    assert groups.count(CEILING_GROUP) == 1
    assert model.geom_group[model.geom("ceiling").id] == CEILING_GROUP


def test_a_robot_snippet_and_its_actuator_become_part_of_the_model() -> None:
    home = Home.generate(1)
    wheel = '<body name="robot" pos="0 0 1"><joint name="j" type="hinge"/><geom type="sphere" size="0.1"/></body>'
    text, assets = home_mjcf(
        home,
        robot_xml=wheel,
        robot_assets={"extra.bin": b""},
        actuators='<velocity name="drive" joint="j" kv="1"/>',
        sensors='<jointpos name="angle" joint="j"/>',
    )
    model = mujoco.MjModel.from_xml_string(text, assets)
    assert model.actuator("drive").id == 0
    assert model.sensor("angle").id == 0


def test_a_body_that_falls_comes_to_rest_on_the_floor() -> None:
    home = Home.generate(2)
    model = model_of(home, ROBOT)
    data = mujoco.MjData(model)
    data.qpos[:2] = (home.dock.x_m, home.dock.y_m)
    data.qpos[2] = 0.3
    for _ in range(300):
        mujoco.mj_step(model, data)
    assert data.qpos[2] == pytest.approx(0.1, abs=0.01)


def test_walls_furniture_and_things_collide_but_leaves_and_rugs_do_not() -> None:
    home = Home.generate(3)
    model = model_of(home)
    solid = {model.body(model.geom_bodyid[k]).name for k in range(model.ngeom) if model.geom_contype[k]}
    assert {item.id for item in (*home.things, *home.furniture)} <= solid
    assert all(model.geom_contype[model.geom(f"wall_{k}").id] for k in range(len(home.walls)))


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_a_kind_keeps_to_the_box_the_catalogue_gives_it(kind: str) -> None:
    entry = KINDS[kind]
    build = thing_geoms if kind in THINGS else furniture_geoms
    for variant in range(entry.variants):
        low, high = outline(build(kind, WHITE, entry.size_m, variant))
        assert np.all(high - low <= np.array(entry.size_m) * 1.12 + 0.03), (kind, variant, high - low)
        assert high[2] - low[2] >= entry.size_m[2] * 0.6, (kind, variant)
        assert low[2] > -0.04, (kind, variant)


def outline(geoms: list[Geom]) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper corner of what the geoms cover, from their turned boxes (loose for turned ellipsoids)."""
    corners: list[np.ndarray] = []
    for geom in geoms:
        quat = np.zeros(4)
        mujoco.mju_euler2Quat(quat, np.array(geom.euler_rad), "xyz")
        turn = np.zeros(9)
        mujoco.mju_quat2Mat(turn, quat)
        lift = geom.size_m[2] / 2 if geom.shape == "mesh" else 0.0
        for signs in np.ndindex(2, 2, 2):
            corner = (np.array(signs) - 0.5) * np.array(geom.size_m) + np.array([0.0, 0.0, lift])
            corners.append(turn.reshape(3, 3) @ corner + np.array(geom.centre_m))
    return np.min(corners, axis=0), np.max(corners, axis=0)


def test_named_colours_are_well_apart() -> None:
    names = [*FURNITURE["couch"].colours]
    for first in set(names):
        for second in set(names) - {first}:
            assert np.linalg.norm(np.subtract(rgb_of(first), rgb_of(second))) > 0.25, (first, second)
