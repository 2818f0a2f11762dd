"""The arm on ROS, as ros2_control's controllers offer one: `joint_states`, and an action each for joints and jaw."""

import threading
from collections.abc import Callable, Sequence
from typing import Any, Final

import structlog
from control_msgs.action import FollowJointTrajectory, GripperCommand
from rclpy.action.server import ActionServer, CancelResponse, GoalResponse, ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from sensor_msgs.msg import JointState

from sim.ros import messages
from sim.ros.realtime import Duty, RealTime
from sim.world import World
from sim.world.arm.arm import SimulatedArm
from sim.world.arm.controller import GOAL_TIME_S, Outcome, Tolerances
from sim.world.arm.models import ArmModel
from sim.world.arm.trajectory import Knot, Trajectory

log = structlog.get_logger()

JOINT_STATES_HZ: Final = 40.0
_LOOK_S: Final = 0.02
_CODES: Final = {
    Outcome.SUCCEEDED: FollowJointTrajectory.Result.SUCCESSFUL,
    Outcome.PATH_TOLERANCE: FollowJointTrajectory.Result.PATH_TOLERANCE_VIOLATED,
    Outcome.GOAL_TOLERANCE: FollowJointTrajectory.Result.GOAL_TOLERANCE_VIOLATED,
}


class ArmInterface:
    """Publishers and servers of the arm on `node`; what they are asked is done in the World's thread."""

    def __init__(self, node: Node, arm: ArmModel, realtime: RealTime, closing: threading.Event) -> None:
        self._arm = arm
        self._realtime = realtime
        self._closing = closing
        self._newest: ServerGoalHandle | None = None
        self._joint_states = node.create_publisher(JointState, "joint_states", 10)
        group = ReentrantCallbackGroup()
        self._actions = [
            ActionServer(
                node,
                FollowJointTrajectory,
                "arm_controller/follow_joint_trajectory",
                self._follow,
                callback_group=group,
                goal_callback=self._admit,
                cancel_callback=lambda _: CancelResponse.ACCEPT,
            ),
            ActionServer(
                node,
                GripperCommand,
                "gripper_controller/gripper_cmd",
                self._grip,
                callback_group=group,
                cancel_callback=lambda _: CancelResponse.ACCEPT,
            ),
        ]

    def duties(self) -> list[Duty]:
        return [Duty("joint_states", JOINT_STATES_HZ, self._tell)]

    # --- the World's thread

    def _tell(self, world: World, stamp_ns: int) -> None:
        readings = _arm_of(world).readings()
        self._joint_states.publish(
            JointState(
                header=messages.header("", stamp_ns),
                name=[each.name for each in readings],
                position=[each.position for each in readings],
                velocity=[each.velocity for each in readings],
                effort=[each.effort for each in readings],
            )
        )

    # --- ROS threads

    def _admit(self, request: Any) -> GoalResponse:
        """As the joint_trajectory_controller: what it cannot follow is rejected, joints' limits are not its matter."""
        if why := _trajectory(request.trajectory).why_invalid(self._arm.joints):
            log.info("the arm rejects a trajectory", why=why)
            return GoalResponse.REJECT
        return GoalResponse.ACCEPT

    def _follow(self, handle: ServerGoalHandle) -> Any:
        """A newer goal aborts an older one."""
        self._newest = handle
        trajectory = _trajectory(handle.request.trajectory).in_order(self._arm.joints)
        tolerances = self._tolerances(handle.request)
        begun = self._realtime.ask(lambda world: _arm_of(world).follow(trajectory, tolerances))
        outcome = self._watch(
            handle,
            lambda world: _arm_of(world).trajectory.outcome,
            lambda world: _arm_of(world).hold_arm(),
            over=lambda: not begun or self._newest is not handle,
        )
        return FollowJointTrajectory.Result(error_code=_CODES.get(outcome, 0), error_string=outcome.value)

    def _grip(self, handle: ServerGoalHandle) -> Any:
        command = handle.request.command
        begun = self._realtime.ask(lambda world: _arm_of(world).grip(command.position, command.max_effort))
        outcome = self._watch(
            handle,
            lambda world: _arm_of(world).gripper.outcome,
            lambda world: _arm_of(world).hold_gripper(),
            over=lambda: not begun,
        )
        result = GripperCommand.Result(stalled=outcome is Outcome.STALLED, reached_goal=outcome is Outcome.SUCCEEDED)
        if not self._closing.is_set():
            jaw = self._realtime.call(lambda world: _arm_of(world).readings()[-1]).result(timeout=5.0)
            result.position, result.effort = jaw.position, jaw.effort
        return result

    def _watch(
        self,
        handle: ServerGoalHandle,
        outcome_in: Callable[[World], Outcome],
        hold: Callable[[World], None],
        *,
        over: Callable[[], bool],
    ) -> Outcome:
        """Until the goal has ended, by itself, by its client, or because it is `over` for another reason."""
        outcome = Outcome.RUNNING
        while outcome is Outcome.RUNNING:
            if over() or self._closing.wait(_LOOK_S):
                handle.abort()
                return Outcome.HELD
            if handle.is_cancel_requested:
                self._realtime.ask(hold)
                handle.canceled()
                return Outcome.HELD
            outcome = self._realtime.call(outcome_in).result(timeout=5.0)
        if outcome is Outcome.SUCCEEDED:
            handle.succeed()
        else:
            handle.abort()
        log.info("the arm ended a goal", outcome=outcome.value)
        return outcome

    def _tolerances(self, request: Any) -> Tolerances:
        said_s = messages.seconds(request.goal_time_tolerance)
        return Tolerances(
            path_rad=self._by_joint(request.path_tolerance),
            goal_rad=self._by_joint(request.goal_tolerance),
            goal_time_s=said_s or GOAL_TIME_S,
        )

    def _by_joint(self, said: Sequence[Any]) -> tuple[float, ...]:
        limits = {each.name: float(each.position) for each in said}
        return tuple(limits.get(name, 0.0) for name in self._arm.joints)


def _trajectory(message: Any) -> Trajectory:
    """trajectory_msgs/JointTrajectory, as it is."""
    return Trajectory(
        tuple(message.joint_names),
        tuple(
            Knot(messages.seconds(point.time_from_start), tuple(point.positions), tuple(point.velocities))
            for point in message.points
        ),
    )


def _arm_of(world: World) -> SimulatedArm:
    assert world.arm is not None, "the interface is opened for a World with an arm only"
    return world.arm
