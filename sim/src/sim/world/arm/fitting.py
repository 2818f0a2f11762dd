"""The scene with an arm on the robot: a deck over its lidar, and the arm's model on that."""

from typing import Final

import mujoco

from sim.world.arm.models import ArmModel
from sim.world.robot import ROBOT_BODY
from sim.world.types import Scene

PREFIX: Final = "arm/"
"""Before the name of everything that is the arm's."""
DECK_Z_M: Final = 0.27
"""Upper face of the deck: so high and so short that the camera, 0.19 m high, looks out under it."""
FOOT_X_M: Final = 0.0
"""The arm's foot in base_link: over the middle, between the wheels."""
DECK_HALF_M: Final = (0.085, 0.125, 0.0025)
_DECK_KG: Final = 0.25
_POST_KG: Final = 0.02
_POSTS_M: Final = ((0.06, 0.115), (0.06, -0.115), (-0.07, 0.115), (-0.07, -0.115))
"""Beside the camera's view, within the footprint."""
_SHELL_TOP_M: Final = 0.092
_LOOKED_THROUGH: Final = 2
"""Geom group that the lidar's rays pass: the posts stand nearer than it measures, as the camera's bracket does."""

_IMPRATIO: Final = 10.0
_NOSLIP_ITERATIONS: Final = 5


def compile_with_arm(scene: Scene, arm: ArmModel) -> mujoco.MjModel:
    """The scene's model with the arm's foot on the robot's deck. Its weight is the robot's to carry.

    Raises `ArmMissingError` where the arm's wheel is not installed.
    """
    spec = mujoco.MjSpec.from_string(scene.xml, assets=dict(scene.assets))
    base = spec.body(ROBOT_BODY)
    _add_deck(base.add_body(name="deck"))
    file = arm.file()
    meshes = {path.name: path.read_bytes() for path in sorted(file.parent.rglob("*.stl"))}
    child = mujoco.MjSpec.from_string(file.read_text(), assets=meshes)
    for pad in arm.pads:  # inert as the model comes
        child.geom(pad).contype = child.geom(pad).conaffinity = 1
    spec.attach(child, prefix=PREFIX, frame=base.add_frame(pos=[FOOT_X_M, 0.0, DECK_Z_M]))
    # What is held by friction slips with MuJoCo's defaults: measured, docs/arm.md.
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = _IMPRATIO
    spec.option.noslip_iterations = _NOSLIP_ITERATIONS
    model = spec.compile()
    model.body_gravcomp[:] = 0.0  # MuJoCo's carries an arm from outside: on the robot it would weigh nothing
    return model


def _add_deck(deck: mujoco.MjsBody) -> None:
    """A plate on four posts. A body of its own: the base's mass is given, what stands on it adds to that."""
    grey = [0.3, 0.3, 0.32, 1.0]
    thick_m = 2 * DECK_HALF_M[2]
    deck.add_geom(
        name="deck", type=mujoco.mjtGeom.mjGEOM_BOX, size=list(DECK_HALF_M), pos=[0.0, 0.0, DECK_Z_M - thick_m / 2],
        mass=_DECK_KG, rgba=grey, group=_LOOKED_THROUGH,
    )  # fmt: skip
    half_m = (DECK_Z_M - thick_m - _SHELL_TOP_M) / 2
    for k, (x, y) in enumerate(_POSTS_M):
        deck.add_geom(
            name=f"post_{k}", type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=[0.004, half_m, 0.0],
            pos=[x, y, _SHELL_TOP_M + half_m], mass=_POST_KG, rgba=grey, group=_LOOKED_THROUGH,
        )  # fmt: skip
