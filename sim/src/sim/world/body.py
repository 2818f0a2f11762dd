"""The robot's body in the compiled home: MuJoCo state in plain words."""

import math

import mujoco
import numpy as np
from numpy.typing import NDArray

from contracts.geometry import Pose2D, Twist2D
from geometry.poses import compose, yaw_of
from sim.world.arm.arm import SimulatedArm
from sim.world.arm.fitting import compile_with_arm
from sim.world.arm.models import ArmModel
from sim.world.robot import LIDAR, LIDAR_Z_M, ROBOT_BODY, TIMESTEP_S
from sim.world.types import Scene

_BUMPER_HALF_ANGLE_RAD = math.radians(100.0)
"""The Create 3's bumper covers its front half and a little more."""
_CEILING_GROUP = 2
_REST_Z_M = 0.0005


class Body:
    """Compiles the scene and owns MuJoCo's model and data."""

    def __init__(self, scene: Scene, start: Pose2D, *, light: float = 1.0, arm: ArmModel | None = None) -> None:
        """`arm`: on the robot's deck, where there is one. Raises `ArmMissingError`."""
        self.model = (
            mujoco.MjModel.from_xml_string(scene.xml, dict(scene.assets))
            if arm is None
            else compile_with_arm(scene, arm)
        )
        lamp = self.model.vis.headlight
        for shines in (self.model.light_diffuse, self.model.light_specular, lamp.ambient, lamp.diffuse):
            np.multiply(shines, light, out=shines)
        self.model.opt.timestep = TIMESTEP_S
        # The implicit integrators move a servo-driven wheel by less than the contact solver reckoned with: it slips.
        self.model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
        self.data = mujoco.MjData(self.model)
        self.arm = None if arm is None else SimulatedArm(self.model, self.data, arm)
        self._then = mujoco.MjData(self.model)
        self.root = int(self.model.body(ROBOT_BODY).id)
        joint = self.model.joint("base")
        self._q, self._v = int(joint.qposadr[0]), int(joint.dofadr[0])
        self._left = int(self.model.actuator("wheel_left").id)
        self._right = int(self.model.actuator("wheel_right").id)
        self._gyro = int(self.model.sensor("gyro").adr[0])
        self._accelerometer = int(self.model.sensor("accelerometer").adr[0])
        self._geom_of_robot = self.model.body_rootid[self.model.geom_bodyid] == self.root
        self._geom_of_arm = np.zeros_like(self._geom_of_robot) if self.arm is None else self.arm.geoms
        self._geom_names = [self.model.body(int(b)).name for b in self.model.geom_bodyid]
        self._floor = self.model.geom_type == mujoco.mjtGeom.mjGEOM_PLANE
        self._lidar_groups = np.ones(6, np.uint8)
        self._lidar_groups[_CEILING_GROUP] = 0
        self.place(start)

    def step(self, left_rad_s: float, right_rad_s: float) -> None:
        """One physics step with these wheel speeds asked for."""
        self.data.ctrl[self._left], self.data.ctrl[self._right] = left_rad_s, right_rad_s
        if self.arm is not None:
            self.arm.step()
        mujoco.mj_step(self.model, self.data)

    def place(self, pose: Pose2D) -> None:
        """At rest on its wheels."""
        data = self.data
        time = data.time
        mujoco.mj_resetData(self.model, data)
        data.time = time
        data.qpos[self._q : self._q + 7] = (
            *(pose.x, pose.y, _REST_Z_M),
            *(math.cos(pose.yaw / 2), 0.0, 0.0, math.sin(pose.yaw / 2)),
        )
        if self.arm is not None:
            self.arm.place()
        mujoco.mj_forward(self.model, data)

    def move(self, name: str, at_m: tuple[float, float, float], yaw: float) -> None:
        """Of a body that nothing joins to the world."""
        body = int(self.model.body(name).id)
        self.model.body_pos[body] = at_m
        self.model.body_quat[body] = (math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2))
        mujoco.mj_forward(self.model, self.data)

    def data_at(self, qpos: NDArray[np.float64]) -> mujoco.MjData:
        """Where everything was in another state, for a picture of it; good until the next call."""
        self._then.qpos[:] = qpos
        mujoco.mj_kinematics(self.model, self._then)
        mujoco.mj_camlight(self.model, self._then)
        return self._then

    def pose(self) -> Pose2D:
        """base_link in the map."""
        x, y, _, qw, qx, qy, qz = self.data.qpos[self._q : self._q + 7].tolist()
        return Pose2D(x=x, y=y, yaw=yaw_of(qx, qy, qz, qw))

    def speeds(self) -> tuple[float, float]:
        """Forward speed (m/s) and turn rate (rad/s)."""
        qw, qx, qy, qz = self.data.qpos[self._q + 3 : self._q + 7].tolist()
        vx, vy, _, _, _, wz = self.data.qvel[self._v : self._v + 6].tolist()
        forward_x, forward_y = 1 - 2 * (qy * qy + qz * qz), 2 * (qw * qz + qx * qy)
        return vx * forward_x + vy * forward_y, wz

    def twist(self) -> Twist2D:
        """Velocity of base_link in base_link."""
        linear_x, angular_z = self.speeds()
        return Twist2D(linear_x=max(-2.0, min(2.0, linear_x)), angular_z=max(-4.0, min(4.0, angular_z)))

    def imu(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Turn rates (rad/s) and specific force (m/s^2) in base_link."""
        values = self.data.sensordata
        return (
            values[self._gyro : self._gyro + 3].copy(),
            values[self._accelerometer : self._accelerometer + 3].copy(),
        )

    def ranges(self, angles_rad: NDArray[np.float64], range_max_m: float) -> NDArray[np.float64]:
        """True distances (m) at these angles of the lidar's frame; -1 where nothing is hit.

        The robot itself is looked through: its camera's bracket stands nearer than the lidar measures.
        """
        laser = compose(self.pose(), LIDAR)
        origin = np.array([laser.x, laser.y, LIDAR_Z_M])
        count = len(angles_rad)
        rays = np.zeros((count, 3))
        rays[:, 0], rays[:, 1] = np.cos(angles_rad + laser.yaw), np.sin(angles_rad + laser.yaw)
        geoms, distances = np.zeros(count, np.int32), np.zeros(count)
        mujoco.mj_multiRay(
            self.model, self.data, origin, rays.ravel(), self._lidar_groups, True, self.root, geoms, distances, None,
            count, range_max_m,
        )  # fmt: skip
        return distances

    def first_hit(self, start: NDArray[np.float64], target: NDArray[np.float64]) -> tuple[str, float]:
        """Name of the body that a ray meets first, and its distance in m; ("", inf) where it meets none."""
        along = target - start
        geom = np.full(1, -1, np.int32)
        share = mujoco.mj_ray(self.model, self.data, start, along, self._lidar_groups, True, self.root, geom)
        if share < 0:
            return "", math.inf
        return self._geom_names[int(geom[0])], share * float(np.linalg.norm(along))

    def touching(self) -> tuple[str, ...]:
        """Names of the bodies that the robot touches, the floor left out."""
        return tuple(sorted({name for name, _, _ in self._contacts()}))

    def bumped(self) -> bool:
        """Whether something presses on the front bumper; what the arm touches does not."""
        of_arm = self._geom_of_arm
        return any(abs(bearing) < _BUMPER_HALF_ANGLE_RAD and not of_arm[geom] for _, bearing, geom in self._contacts())

    def _contacts(self) -> list[tuple[str, float, int]]:
        """Body, bearing (rad, from ahead) and the robot's own geom of every contact that is not with the floor."""
        data, robot = self.data, self._geom_of_robot
        if data.ncon == 0:
            return []
        pairs = data.contact.geom
        found: list[tuple[str, float, int]] = []
        for index in np.flatnonzero(robot[pairs[:, 0]] != robot[pairs[:, 1]]).tolist():
            one, other = pairs[index].tolist()
            if robot[other]:
                one, other = other, one
            if self._floor[other] or data.contact.dist[index] > 0.0:
                continue
            pose, (x, y, _) = self.pose(), data.contact.pos[index].tolist()
            bearing = math.remainder(math.atan2(y - pose.y, x - pose.x) - pose.yaw, 2 * math.pi)
            found.append((self._geom_names[other] or "world", bearing, one))
        return found
