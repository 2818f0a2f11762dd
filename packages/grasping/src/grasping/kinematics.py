"""The arm's inverse kinematics and what it touches, over its own MuJoCo model; no dynamics, no clock.

Needs the extra `kinematics` (mink, MuJoCo). Differential inverse kinematics after mink: each round solves a quadratic
program for the joints' velocities that bring the tip nearer, within their ranges.
"""

import ctypes.util
import hashlib
import io
import math
import os
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

if "MUJOCO_GL" not in os.environ and ctypes.util.find_library("EGL") is not None:
    os.environ["MUJOCO_GL"] = "egl"  # nothing is drawn here, but MuJoCo chooses once, also for whoever draws

import mink
import mujoco
import numpy as np
from numpy.typing import NDArray

from grasping.candidates import TipPose
from grasping.hands import Hand
from grasping.planning import Joints
from grasping.reachability import ReachabilityMap, table_of
from grasping.things import MeasuredThing

NEAR_M: Final = 0.003
NEAR_RAD: Final = 0.06
"""The tip counts as there within these."""
ROUNDS: Final = 60
_DT_S: Final = 0.1
_TRIES_EACH: Final = 32
"""Angles of each of three joints that the reachability map is made of."""
_TABLE: Final = 1
"""Rises when the map is made in another way: an older one in the cache counts no more."""
_THINGS: Final = ("thing", "round thing")
_FAR_M: Final = 50.0
PREFIX: Final = "arm/"


@dataclass(frozen=True, slots=True)
class ArmMount:
    """The robot round the arm, m: where its foot stands in base_link, and what of the robot it may touch."""

    foot_x_m: float
    foot_z_m: float
    base_radius_m: float
    base_top_m: float
    deck_half_m: tuple[float, float]
    """Of the plate under the foot, along x and y."""


@dataclass(frozen=True, slots=True)
class ArmDescription:
    """The arm's MJCF, with the meshes in folders beside it, and the names in it. Joints from the foot to the wrist."""

    mjcf: Path
    joints: tuple[str, ...]
    jaw: str
    hand: Hand


class ArmKinematics:
    """Not for two threads at once. An `ArmSolver`."""

    def __init__(self, arm: ArmDescription, mount: ArmMount) -> None:
        self.arm, self.mount = arm, mount
        self._model = _compile(arm, mount)
        self._data = mujoco.MjData(self._model)
        model = self._model
        ids = [model.joint(PREFIX + name).id for name in arm.joints]
        self._at = model.jnt_qposadr[ids]
        self._range = model.jnt_range[ids]
        self._jaw = int(model.joint(PREFIX + arm.jaw).qposadr[0])
        self._things = [model.geom(name).id for name in _THINGS]
        self._task = mink.FrameTask(
            PREFIX + arm.hand.tip, "site", position_cost=1.0, orientation_cost=0.3, lm_damping=1e-4, gain=0.9
        )
        frozen = np.ones(model.nv, bool)
        frozen[model.jnt_dofadr[ids]] = False
        self._freeze = mink.DofFreezingTask(model, dof_indices=np.flatnonzero(frozen).tolist())
        self._limits = [mink.ConfigurationLimit(model)]
        self._configuration = mink.Configuration(model)

    # --- ArmSolver

    def solve(self, pose: TipPose, start: Joints) -> Joints | None:
        """Within `NEAR_M` and `NEAR_RAD`, or None. Raises ValueError for a start of another arm."""
        self._check(start)
        target = mink.SE3.from_rotation_and_translation(mink.SO3.from_matrix(pose.rotation), pose.at)
        self._task.set_target(target)
        configuration = self._configuration
        posture = configuration.q.copy()
        posture[self._at] = np.clip(start, self._range[:, 0] + 1e-4, self._range[:, 1] - 1e-4)
        configuration.update(posture)
        for _ in range(ROUNDS):
            error = self._task.compute_error(configuration)
            if np.linalg.norm(error[:3]) < NEAR_M and np.linalg.norm(error[3:]) < NEAR_RAD:
                return tuple(configuration.q[self._at].tolist())
            try:
                velocity = mink.solve_ik(
                    configuration, [self._task], _DT_S, "daqp", damping=1e-4, limits=self._limits,
                    constraints=[self._freeze],
                )  # fmt: skip
            except mink.NoSolutionFound:
                return None
            configuration.integrate_inplace(velocity, _DT_S)
        return None

    def touches(self, joints: Joints, jaw_rad: float, thing: MeasuredThing | None) -> tuple[str, ...]:
        """Names of what the arm would touch; its own links by their bodies' names."""
        self._check(joints)
        self._place(thing)
        return self._touched(np.asarray(joints), jaw_rad)

    def margin(self, joints: Joints) -> float:
        self._check(joints)
        return float(self._margins(np.asarray(joints)))

    # --- the tip, the map

    def tip_at(self, joints: Joints) -> TipPose:
        """Forward kinematics: the tip in base_link."""
        self._check(joints)
        self._data.qpos[self._at] = joints
        mujoco.mj_kinematics(self._model, self._data)
        return self._tip()

    def reachability(self, cache: Path | None = None) -> ReachabilityMap:
        """The map of this arm on this robot: made once (a second or two), and kept in the folder `cache` if there is
        one. A file there that is damaged is made anew."""
        file = cache / f"reachability-{self._digest()}.npz" if cache is not None else None
        if file is not None and file.is_file():
            try:
                with np.load(io.BytesIO(file.read_bytes()), allow_pickle=False) as kept:
                    return ReachabilityMap(kept["margin"], kept["postures"])
            except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
                pass  # made anew below
        made = self._sampled()
        if file is not None:
            file.parent.mkdir(parents=True, exist_ok=True)
            half = file.with_suffix(".part.npz")
            np.savez_compressed(half, margin=made.margin, postures=made.postures)
            half.replace(file)
        return made

    def _sampled(self) -> ReachabilityMap:
        """The joints between the first and the last over all their ranges; what touches something does not count."""
        self._place(None)
        axes = [np.linspace(low, high, _TRIES_EACH) for low, high in self._range[1:4].tolist()]
        postures = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
        rows: list[tuple[float, float, float, float]] = []
        kept: list[NDArray[np.float64]] = []
        pan_x = self.mount.foot_x_m + self.arm.hand.pan_from_foot_m
        jaw = self.arm.hand.angles_rad[len(self.arm.hand.angles_rad) // 2]
        for posture in postures:
            joints = np.array((0.0, *posture, math.pi / 2))
            self._posed(joints, jaw)
            if self._data.ncon:
                continue
            tip = self._tip()
            out_m = float(tip.at[0]) - pan_x
            rows.append((out_m, float(tip.at[2]), tip.pitch_rad, float(self._margins(joints))))
            kept.append(posture)
        columns = np.array(rows).T
        return table_of(columns[0], columns[1], columns[2], columns[3], np.array(kept))

    def _digest(self) -> str:
        of = hashlib.sha256(self.arm.mjcf.read_bytes())
        of.update(repr((_TABLE, _TRIES_EACH, self.mount, self.arm.joints, self.arm.hand)).encode())
        return of.hexdigest()[:16]

    def _margins(self, joints: NDArray[np.float64]) -> float:
        low, high = self._range[:4].T  # the last joint turns the hand only
        part = joints[:4]
        return float((np.minimum(part - low, high - part) / ((high - low) / 2)).min())

    def _tip(self) -> TipPose:
        site = self._data.site(PREFIX + self.arm.hand.tip)
        rotation = site.xmat.reshape(3, 3)
        return TipPose(site.xpos.copy(), rotation[:, 0].copy(), rotation[:, 2].copy())

    def _place(self, thing: MeasuredThing | None) -> None:
        """As a box or an upright cylinder; none = out of everybody's way."""
        data = self._data
        data.mocap_pos[:] = (0.0, 0.0, _FAR_M)
        if thing is None:
            return
        which = int(thing.round)
        data.mocap_pos[which] = thing.centre
        data.mocap_quat[which] = (math.cos(thing.yaw_rad / 2), 0.0, 0.0, math.sin(thing.yaw_rad / 2))
        half = (thing.length_m / 2, thing.width_m / 2, thing.height_m / 2)
        size = (max(half[:2]), half[2], 0.0) if thing.round else half
        self._model.geom_size[self._things[which]] = size
        self._model.geom_rbound[self._things[which]] = math.hypot(*half)

    def _touched(self, joints: NDArray[np.float64], jaw_rad: float) -> tuple[str, ...]:
        self._posed(joints, jaw_rad)
        geoms = set(self._data.contact.geom[: self._data.ncon].ravel().tolist())
        return tuple(sorted({self._name_of(geom) for geom in geoms}))

    def _posed(self, joints: NDArray[np.float64], jaw_rad: float) -> None:
        """Nothing but the arm touches anything: floor and robot are of the world, the thing is put among them."""
        data = self._data
        data.qpos[self._at], data.qpos[self._jaw] = joints, jaw_rad
        mujoco.mj_kinematics(self._model, data)
        mujoco.mj_collision(self._model, data)

    def _name_of(self, geom: int) -> str:
        body = int(self._model.geom_bodyid[geom])
        return self._model.body(body).name.removeprefix(PREFIX) if body else self._model.geom(geom).name

    def _check(self, joints: Joints) -> None:
        if len(joints) != len(self.arm.joints) or not all(map(math.isfinite, joints)):
            raise ValueError(f"{len(self.arm.joints)} finite joints are wanted, not {joints}")


def _compile(arm: ArmDescription, mount: ArmMount) -> mujoco.MjModel:
    """The arm over the robot's base and a floor. Its links are bodies; all else belongs to the world."""
    spec = mujoco.MjSpec()
    world, kinds = spec.worldbody, mujoco.mjtGeom
    world.add_geom(name="floor", type=kinds.mjGEOM_PLANE, size=[2.0, 2.0, 0.1])
    half_m = mount.base_top_m / 2
    world.add_geom(name="base", type=kinds.mjGEOM_CYLINDER, size=[mount.base_radius_m, half_m, 0.0], pos=[0, 0, half_m])
    world.add_geom(
        name="deck", type=kinds.mjGEOM_BOX, size=[*mount.deck_half_m, (mount.foot_z_m - mount.base_top_m) / 2],
        pos=[0, 0, (mount.foot_z_m + mount.base_top_m) / 2],
    )  # fmt: skip
    # what stands there is put there by hand, in a size that the tree of bounding boxes does not know
    for name, shape in zip(_THINGS, (kinds.mjGEOM_BOX, kinds.mjGEOM_CYLINDER), strict=True):
        world.add_body(name=name, mocap=True).add_geom(name=name, type=shape, size=[0.05, 0.05, 0.05])
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_MIDPHASE
    meshes: Mapping[str, bytes] = {path.name: path.read_bytes() for path in sorted(arm.mjcf.parent.rglob("*.stl"))}
    child = mujoco.MjSpec.from_string(arm.mjcf.read_text(), assets=dict(meshes))
    for pad in arm.hand.pads:
        child.geom(pad).contype = child.geom(pad).conaffinity = 1
    frame = world.add_frame(pos=[mount.foot_x_m, 0.0, mount.foot_z_m])
    spec.attach(child, prefix=PREFIX, frame=frame)
    return spec.compile()
