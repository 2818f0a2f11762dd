"""An arm over ROS 2: joint_states, and the actions of its two controllers. Imported only where there is an arm."""

from collections.abc import Callable
from typing import Any

import structlog
from action_msgs.msg import GoalStatus as RosGoalStatus
from action_msgs.srv import CancelGoal
from control_msgs.action import FollowJointTrajectory, GripperCommand
from rclpy.action.client import ActionClient
from rclpy.node import Node
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectoryPoint

from contracts.arm import ArmEnd, ArmPart, TrajectoryPoint
from mesh.clock import Clock
from mesh.latest_value import LatestValue
from robot_bridge.adapters.ros.calls import Calls, RosGoal
from robot_bridge.adapters.ros.convert import set_duration
from robot_bridge.adapters.ros.subscriptions import qos_profile
from robot_bridge.arm.joint_states import Joints, JointStates
from robot_bridge.arm.models import ArmModel
from robot_bridge.arm.owed_cancel import AGAIN_S, OwedCancel
from robot_bridge.settings import RosSettings

log = structlog.get_logger()

_ENDS = {
    FollowJointTrajectory.Result.PATH_TOLERANCE_VIOLATED: ArmEnd.OFF_PATH,
    FollowJointTrajectory.Result.GOAL_TOLERANCE_VIOLATED: ArmEnd.NOT_REACHED,
    FollowJointTrajectory.Result.INVALID_GOAL: ArmEnd.REJECTED,
    FollowJointTrajectory.Result.INVALID_JOINTS: ArmEnd.REJECTED,
    FollowJointTrajectory.Result.OLD_HEADER_TIMESTAMP: ArmEnd.REJECTED,
}


class RosArm:
    """Implements `arm.port.RobotArm`. `open` runs in the robot's thread, the rest in asyncio."""

    def __init__(self, model: ArmModel, ros: RosSettings, clock: Clock) -> None:
        self._model = model
        self._ros = ros
        self._clock = clock
        self._joints: LatestValue[JointStates] = LatestValue()
        self._told = Joints((*model.names, model.jaw.joint))
        self._missing = "its controllers have not been looked for yet"
        self._owed = {part: OwedCancel() for part in ArmPart}

    @property
    def model(self) -> ArmModel:
        return self._model

    @property
    def joints(self) -> LatestValue[JointStates]:
        return self._joints

    def missing(self) -> str:
        return self._missing

    def open(self, node: Node, calls: Calls) -> None:
        self._calls = calls
        ros = self._ros
        self._controllers = {
            ArmPart.ARM: _Controller(node, FollowJointTrajectory, ros.arm_action, self._owed[ArmPart.ARM], self._clock),
            ArmPart.GRIPPER: _Controller(
                node, GripperCommand, ros.gripper_action, self._owed[ArmPart.GRIPPER], self._clock
            ),
        }
        node.create_subscription(JointState, ros.joint_states.name, self._heard, qos_profile(ros.joint_states))

    def poll(self) -> None:
        """Every second, in the robot's thread."""
        for controller in self._controllers.values():
            controller.poll()
        missing = (controller.missing() for controller in self._controllers.values())
        self._missing = "; ".join(each for each in missing if each)

    def shut(self) -> None:
        for controller in self._controllers.values():
            controller.actions.destroy()

    async def follow(self, points: tuple[TrajectoryPoint, ...]) -> "RosArmGoal | None":
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = list(self._model.names)
        goal.trajectory.points = [_message(point) for point in points]
        return self._accepted(
            await self._calls.send_goal(self._controllers[ArmPart.ARM].actions, "arm", goal), _followed
        )

    async def grip(self, position: float, effort_max: float) -> "RosArmGoal | None":
        goal = GripperCommand.Goal()
        goal.command.position, goal.command.max_effort = position, effort_max
        return self._accepted(
            await self._calls.send_goal(self._controllers[ArmPart.GRIPPER].actions, "gripper", goal), _gripped
        )

    def cancel(self, part: ArmPart) -> None:
        self._owed[part].owe(self._clock.now_s())
        self._calls.do(self._controllers[part].poll)

    def owes_cancel(self, part: ArmPart) -> bool:
        return self._owed[part].owed

    def _accepted(self, goal: RosGoal | None, read: Callable[[Any], ArmEnd]) -> "RosArmGoal | None":
        return RosArmGoal(goal, read) if goal is not None else None

    def _heard(self, message: JointState) -> None:
        """In the robot's thread. They may come from several publishers: the wheels have theirs."""
        now_s = self._clock.now_s()
        states = self._told.read(list(message.name), message.position, message.velocity, message.effort, now_s=now_s)
        if states is not None:
            self._joints.put(states, now_s)


class _Controller:
    """One of the arm's controllers: its action, and the cancel of all its goals that it is owed."""

    def __init__(self, node: Node, action: Any, name: str, owed: OwedCancel, clock: Clock) -> None:
        self.actions = ActionClient(node, action, name)
        self._cancels = node.create_client(CancelGoal, f"{name}/_action/cancel_goal")
        self._name = name
        self._owed = owed
        self._clock = clock
        self._asked: Any = None

    def poll(self) -> None:
        """In the robot's thread: asks for what is owed, as soon as the controller is there."""
        now_s = self._clock.now_s()
        self._owed.there(self._is_there(), now_s)
        if (number := self._owed.due(now_s)) is not None:
            if self._asked is not None:
                self._cancels.remove_pending_request(self._asked)
            self._asked = self._cancels.call_async(CancelGoal.Request())  # no id, no time: every goal
            self._asked.add_done_callback(lambda done: self._answered(number, done))

    def missing(self) -> str:
        """What is not as it should be, in words; '' where nothing is."""
        if not self._is_there():
            return f"nobody offers {self._name}"
        late = self._owed.owed_for_s(self._clock.now_s()) > AGAIN_S
        return f"{self._name} has not answered yet that its goals are cancelled" if late else ""

    def _is_there(self) -> bool:
        return self.actions.server_is_ready() and self._cancels.service_is_ready()

    def _answered(self, number: int, done: Any) -> None:
        if done.cancelled() or done.exception() is not None or (answer := done.result()) is None:
            return
        if answer.return_code == CancelGoal.Response.ERROR_REJECTED:
            log.error("the arm's controller refuses to cancel its goals; it is asked again", action=self._name)
            return
        if left := len(answer.goals_canceling):
            log.info("goals of the arm's controller are cancelled", action=self._name, goals=left)
        self._owed.answered(number)


class RosArmGoal:
    """A goal of either controller; `read` makes an end of its result."""

    def __init__(self, goal: RosGoal, read: Callable[[Any], ArmEnd]) -> None:
        self._goal = goal
        self._read = read

    async def end(self) -> ArmEnd:
        return self._read(await self._goal.result())


def _message(point: TrajectoryPoint) -> JointTrajectoryPoint:
    message = JointTrajectoryPoint(positions=point.positions_rad, velocities=point.velocities_rad_s)
    set_duration(message.time_from_start, point.time_s)
    return message


def _followed(result: Any) -> ArmEnd:
    if result.status == RosGoalStatus.STATUS_SUCCEEDED:
        return ArmEnd.COMPLETED
    if result.status == RosGoalStatus.STATUS_CANCELED:
        return ArmEnd.CANCELED
    return _ENDS.get(int(result.result.error_code), ArmEnd.ABORTED)


def _gripped(result: Any) -> ArmEnd:
    """A stalled jaw aborts by default, and succeeds where the controller is told `allow_stalling`: the same to us."""
    if result.result.stalled and not result.result.reached_goal:
        return ArmEnd.STALLED
    if result.status == RosGoalStatus.STATUS_SUCCEEDED:
        return ArmEnd.COMPLETED
    return ArmEnd.CANCELED if result.status == RosGoalStatus.STATUS_CANCELED else ArmEnd.ABORTED
