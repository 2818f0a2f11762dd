"""The arm in the compiled scene: its servos, what they measure, and the controllers that send them somewhere."""

from dataclasses import dataclass

import mujoco
import numpy as np

from sim.world.arm.controller import GripperController, Tolerances, TrajectoryController
from sim.world.arm.fitting import PREFIX
from sim.world.arm.models import ArmModel
from sim.world.arm.trajectory import Trajectory


@dataclass(frozen=True, slots=True)
class JointReading:
    """What a servo tells: rad, rad/s, Nm."""

    name: str
    position: float
    velocity: float
    effort: float


class SimulatedArm:
    """Lives in the World's thread. The servos hold positions with no more than their torque; the arm's own weight is
    fed forward into where they are sent, as a servo's integral part does, and borne by the robot."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, arm: ArmModel) -> None:
        self.model = arm
        self.names = (*arm.joints, arm.gripper)
        self._mujoco, self._data = model, data
        self._servos = np.array([model.actuator(PREFIX + name).id for name in self.names])
        self._dofs = np.array([model.joint(PREFIX + name).dofadr[0] for name in self.names])
        self._at = np.array([model.joint(PREFIX + name).qposadr[0] for name in self.names])
        self._stiffness = model.actuator_gainprm[self._servos, 0].copy()
        self._torque_nm = float(model.actuator_forcerange[self._servos[-1], 1])
        self.geoms = np.array([_is_of_arm(model, int(body)) for body in model.geom_bodyid])
        """Which geoms of the scene are the arm's."""
        self.trajectory = TrajectoryController(arm.home)
        self.gripper = GripperController(arm.gripper_home)

    def place(self) -> None:
        """At home and at rest, with nothing under way."""
        self.trajectory = TrajectoryController(self.model.home)
        self.gripper = GripperController(self.model.gripper_home)
        self._data.qpos[self._at] = (*self.model.home, self.model.gripper_home)
        self._data.qvel[self._dofs] = 0.0

    def readings(self) -> tuple[JointReading, ...]:
        """Of every joint, the jaw's last."""
        data = self._data
        positions, velocities = data.qpos[self._at].tolist(), data.qvel[self._dofs].tolist()
        efforts = data.actuator_force[self._servos].tolist()
        return tuple(JointReading(*each) for each in zip(self.names, positions, velocities, efforts, strict=True))

    def follow(self, trajectory: Trajectory, tolerances: Tolerances) -> None:
        """Begins a valid trajectory, its joints in the model's order; a newer one replaces an older."""
        self.trajectory.follow(trajectory, tolerances, self._data.time)

    def grip(self, position: float, max_effort_nm: float) -> None:
        """Sends the jaw somewhere, with at most so much torque (0 = all it has)."""
        self.gripper.grip(position, max_effort_nm, self._data.time)

    def hold_arm(self) -> None:
        """The joints stay where they are."""
        self.trajectory.hold(self._joint_positions())

    def hold_gripper(self) -> None:
        """The jaw stays where it is, or goes on pressing on what it holds."""
        self.gripper.hold(float(self._data.qpos[self._at[-1]]))

    def step(self) -> None:
        """Before each physics step: the controllers say where to, the servos are sent there."""
        jaw, speed = float(self._data.qpos[self._at[-1]]), float(self._data.qvel[self._dofs[-1]])
        self.trajectory.tick(self._data.time, self._joint_positions())
        self.gripper.tick(self._data.time, jaw, speed)
        wanted = np.array((*self.trajectory.wanted, self.gripper.wanted))
        self._data.ctrl[self._servos] = wanted + self._data.qfrc_bias[self._dofs] / self._stiffness
        most = min(self._torque_nm, self.gripper.max_effort or self._torque_nm)
        self._mujoco.actuator_forcerange[self._servos[-1]] = (-most, most)

    def _joint_positions(self) -> tuple[float, ...]:
        return tuple(self._data.qpos[self._at[:-1]].tolist())


def _is_of_arm(model: mujoco.MjModel, body: int) -> bool:
    return model.body(body).name.startswith(PREFIX)
