"""A STAND-IN for Nav2 behind Nav2's own interfaces. Who has Nav2 runs Nav2 (`SIM_NAV2_STAND_IN=false`)."""

import threading
import time
from collections.abc import Callable
from functools import partial
from typing import Any, Final

import structlog
from geometry_msgs.msg import Twist, TwistStamped
from lifecycle_msgs.msg import State, Transition
from lifecycle_msgs.srv import ChangeState, GetState
from nav2_msgs.action import ComputePathToPose, NavigateToPose
from nav2_msgs.srv import ClearEntireCostmap
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.qos import QoSProfile

from contracts.geometry import Pose2D, Twist2D
from sim.nav.codes import Code, NavigationError
from sim.nav.costmap import Costmap
from sim.nav.navigator import Navigator
from sim.nav.planner import plan
from sim.ros import messages
from sim.ros.drives import Drive, DriveEnding, Drives
from sim.ros.realtime import RealTime
from sim.settings import SimSettings
from sim.world import Scan, World

log = structlog.get_logger()

SERVERS: Final = ("bt_navigator", "planner_server", "controller_server")
_FEEDBACK_PERIOD_S: Final = 0.2


class Nav2StandIn:
    """Actions, services and `cmd_vel_nav` of the stand-in on `node`. `open` is called once the World has a map."""

    def __init__(self, node: Node, settings: SimSettings, realtime: RealTime, robot_pose: Callable[[], Pose2D]) -> None:
        """`robot_pose` gives base_link in the map, as the robot believes."""
        self._realtime = realtime
        self._robot_pose = robot_pose
        self._stamped = settings.cmd_vel_stamped
        self._active = dict.fromkeys(SERVERS, settings.nav2_active)
        self._navigator: Navigator | None = None
        self._drives: Drives | None = None
        self.closing = threading.Event()
        velocity = TwistStamped if self._stamped else Twist
        self._velocity = node.create_publisher(velocity, "cmd_vel_nav", QoSProfile(depth=1))
        self._group = ReentrantCallbackGroup()
        self._make_services(node)
        self._actions = [
            self._action(node, NavigateToPose, "navigate_to_pose", self._navigate, "bt_navigator"),
            self._action(node, ComputePathToPose, "compute_path_to_pose", self._compute_path, "planner_server"),
        ]

    # --- the World's thread

    def open(self, world: World) -> None:
        self._navigator = Navigator(Costmap.from_map(world.grid))
        self._drives = Drives(self._navigator, self._publish_velocity)

    def on_scan(self, scan: Scan, laser: Pose2D) -> None:
        if self._navigator is not None:
            self._navigator.observe(scan, laser)

    def on_control(self, world: World, stamp_ns: int) -> None:
        if self._drives is None:
            return
        if not all(self._active.values()):
            self._drives.abort(Code.UNKNOWN, "a server of the stand-in is not active", stamp_ns)
        self._drives.tick(self._robot_pose(), world.time_s, stamp_ns)

    def _publish_velocity(self, twist: Twist2D, stamp_ns: int) -> None:
        """Only ever on `cmd_vel_nav`: what reaches the wheels is for robot_bridge to decide."""
        message = TwistStamped(header=messages.header(messages.BASE, stamp_ns)) if self._stamped else Twist()
        plain = message.twist if isinstance(message, TwistStamped) else message
        plain.linear.x, plain.angular.z = float(twist.linear_x), float(twist.angular_z)
        self._velocity.publish(message)

    # --- ROS threads

    def _action(
        self, node: Node, kind: Any, name: str, run: Callable[[ServerGoalHandle], Any], server: str
    ) -> ActionServer:
        def admit(_: object) -> GoalResponse:
            open_ = self._navigator is not None and self._active[server]
            if not open_:
                log.info("Nav2 stand-in rejected a goal: its server is not active", action=name, server=server)
            return GoalResponse.ACCEPT if open_ else GoalResponse.REJECT

        return ActionServer(
            node,
            kind,
            name,
            run,
            callback_group=self._group,
            goal_callback=admit,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )

    def _make_services(self, node: Node) -> None:
        clears = {
            "global_costmap/clear_entirely_global_costmap": Navigator.clear_global,
            "local_costmap/clear_entirely_local_costmap": Navigator.clear_local,
        }
        for name, clear in clears.items():
            node.create_service(ClearEntireCostmap, name, partial(self._clear, clear), callback_group=self._group)
        for server in SERVERS:
            get, change = partial(self._get_state, server), partial(self._change_state, server)
            node.create_service(GetState, f"{server}/get_state", get, callback_group=self._group)
            node.create_service(ChangeState, f"{server}/change_state", change, callback_group=self._group)

    def _clear(
        self,
        clear: Callable[[Navigator], None],
        _: ClearEntireCostmap.Request,
        response: ClearEntireCostmap.Response,
    ) -> ClearEntireCostmap.Response:
        navigator = self._navigator
        if navigator is not None:
            self._realtime.ask(lambda _: clear(navigator))
        return response

    def _get_state(self, server: str, _: GetState.Request, response: GetState.Response) -> GetState.Response:
        active = self._active[server] and self._navigator is not None
        response.current_state = (
            State(id=State.PRIMARY_STATE_ACTIVE, label="active")
            if active
            else State(id=State.PRIMARY_STATE_INACTIVE, label="inactive")
        )
        return response

    def _change_state(
        self, server: str, request: ChangeState.Request, response: ChangeState.Response
    ) -> ChangeState.Response:
        wanted = {Transition.TRANSITION_ACTIVATE: True, Transition.TRANSITION_DEACTIVATE: False}
        to = wanted.get(request.transition.id)
        response.success = to is not None and to is not self._active[server]
        if response.success and to is not None:
            self._active[server] = to
            log.info("Nav2 stand-in changed state", server=server, active=to)
        return response

    def _navigate(self, handle: ServerGoalHandle) -> NavigateToPose.Result:
        drives = self._drives
        assert drives is not None, "goals are admitted once the World is there"
        try:
            goal = _in_map(handle.request.pose)
        except NavigationError as error:
            handle.abort()
            return NavigateToPose.Result(error_code=int(error.code), error_msg=error.detail)
        log.info("Nav2 stand-in: goal", x=round(goal.x, 2), y=round(goal.y, 2), yaw=round(goal.yaw, 2))
        drive = Drive(goal, lambda: handle.is_cancel_requested)
        drives.submit(drive)
        began_s = time.monotonic()
        while not drive.ended.wait(_FEEDBACK_PERIOD_S) and not self.closing.is_set():
            self._feed_back(handle, drive, time.monotonic() - began_s)
        match drive.ending:
            case DriveEnding.SUCCEEDED:
                handle.succeed()
            case DriveEnding.CANCELED:
                handle.canceled()
            case _:
                handle.abort()
        progress = drive.progress
        log.info("Nav2 stand-in: goal ended", how=str(drive.ending), code=int(progress.code), detail=progress.detail)
        return NavigateToPose.Result(error_code=int(progress.code), error_msg=progress.detail)

    def _feed_back(self, handle: ServerGoalHandle, drive: Drive, spent_s: float) -> None:
        progress = drive.progress
        feedback = NavigateToPose.Feedback(
            current_pose=messages.pose_stamped(self._robot_pose(), time.time_ns()),
            navigation_time=messages.duration(spent_s),
            estimated_time_remaining=messages.duration(progress.remaining_m / 0.2),
            number_of_recoveries=progress.recoveries,
            distance_remaining=float(progress.remaining_m),
        )
        handle.publish_feedback(feedback)

    def _compute_path(self, handle: ServerGoalHandle) -> ComputePathToPose.Result:
        navigator, request = self._navigator, handle.request
        assert navigator is not None, "goals are admitted once the World is there"
        result = ComputePathToPose.Result()
        began_s = time.monotonic()
        try:
            start = _in_map(request.start) if request.use_start else self._robot_pose()
            found = plan(navigator.costmap, start, _in_map(request.goal))
        except NavigationError as error:
            result.error_code, result.error_msg = int(error.code), error.detail
            handle.abort()
        else:
            result.path = messages.path(found.poses(), time.time_ns())
            handle.succeed()
        result.planning_time = messages.duration(time.monotonic() - began_s)
        return result


def _in_map(message: Any) -> Pose2D:
    """The pose of a PoseStamped. Raises `NavigationError` for another frame than the map and for no numbers."""
    if message.header.frame_id not in {"", messages.MAP}:
        raise NavigationError(Code.TF_ERROR, f"poses are wanted in {messages.MAP}, not in {message.header.frame_id}")
    try:
        return messages.pose2d(message.pose)
    except ValueError as error:
        raise NavigationError(Code.GOAL_OUTSIDE_MAP, "the pose is outside any map") from error
