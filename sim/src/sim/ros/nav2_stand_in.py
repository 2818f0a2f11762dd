"""A STAND-IN for Nav2 behind Nav2's own interfaces. Who has Nav2 runs Nav2 (`SIM_NAV2_STAND_IN=false`)."""

import math
import threading
import time
from collections.abc import Callable
from functools import partial
from typing import Any, Final

import structlog
from geometry_msgs.msg import Twist, TwistStamped
from nav2_msgs.action import ComputePathToPose, NavigateToPose
from nav2_msgs.srv import ClearEntireCostmap
from nav_msgs.msg import Path
from rclpy.action.server import ActionServer, CancelResponse, GoalResponse, ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.qos import QoSProfile

from contracts.geometry import Pose2D, Twist2D
from sim.nav.chain import ChainHabits
from sim.nav.codes import Code, NavigationError
from sim.nav.costmap import Costmap
from sim.nav.follower import Limits
from sim.nav.navigator import Navigator, Patience
from sim.nav.planner import Path as Planned
from sim.ros import messages
from sim.ros.drives import DEACTIVATED_S, Drive, DriveEnding, Drives, Habits
from sim.ros.lifecycle import Parameters, make_lifecycle
from sim.ros.realtime import RealTime
from sim.settings import SimSettings
from sim.world import OccupancyGrid, Scan, World

log = structlog.get_logger()

SERVERS: Final = (
    "bt_navigator",
    "planner_server",
    "controller_server",
    "smoother_server",
    "behavior_server",
    "velocity_smoother",
    "collision_monitor",
)
_FEEDBACK_PERIOD_S: Final = 0.2


class Nav2StandIn:
    """Actions, services, `cmd_vel_nav` and `plan` of the stand-in on `node`. `open` comes once the World has a map."""

    def __init__(
        self,
        node: Node,
        settings: SimSettings,
        realtime: RealTime,
        robot_pose: Callable[[], Pose2D],
        make_node: Callable[..., Node],
    ) -> None:
        """`robot_pose` gives base_link in the map, as the robot believes; `make_node` the lifecycle nodes."""
        self._settings = settings
        self._realtime = realtime
        self._robot_pose = robot_pose
        self._stamped = settings.cmd_vel_stamped
        self._navigator: Navigator | None = None
        self._drives: Drives | None = None
        self._servers = make_lifecycle(
            make_node,
            SERVERS,
            active=settings.nav2_active,
            ready=lambda: self._navigator is not None,
            parameters=parameters(settings),
        )
        self.closing = threading.Event()
        velocity = TwistStamped if self._stamped else Twist
        self._velocity = node.create_publisher(velocity, "cmd_vel_nav", QoSProfile(depth=1))
        self._plan = node.create_publisher(Path, "plan", QoSProfile(depth=1))
        self._group = ReentrantCallbackGroup()
        self._make_services(node)
        self._actions = [
            self._action(node, NavigateToPose, "navigate_to_pose", self._navigate, "bt_navigator"),
            self._action(node, ComputePathToPose, "compute_path_to_pose", self._compute_path, "planner_server"),
        ]

    # --- the World's thread

    def open(self, grid: OccupancyGrid) -> None:
        """With its first map."""
        settings = self._settings
        self._navigator = Navigator(
            Costmap.from_map(grid),
            limits=Limits(
                goal_tolerance_m=settings.nav2_goal_tolerance_m, goal_tolerance_rad=settings.nav2_goal_tolerance_rad
            ),
            patience=Patience(lost_one_in=settings.nav2_abort_one_in),
            tolerance_m=settings.nav2_planner_tolerance_m,
        )
        habits = Habits(
            ChainHabits(settings.nav2_delay_s, settings.nav2_gap_s),
            drives_on_s=settings.nav2_drives_on_s,
            dies_after_s=settings.nav2_dies_after_s or math.inf,
        )
        self._drives = Drives(self._navigator, self._publish_velocity, habits)

    def take_map(self, grid: OccupancyGrid) -> None:
        """As from SLAM: goals go on."""
        if self._navigator is not None:
            self._navigator.take_map(Costmap.from_map(grid))

    def on_scan(self, scan: Scan, laser: Pose2D) -> None:
        if self._navigator is not None:
            self._navigator.observe(scan, laser)

    def on_control(self, world: World, stamp_ns: int) -> None:
        if self._drives is None:
            return
        died_s = self._drives.died_s
        if died_s is not None:
            self._servers["controller_server"].failed = True
            for server in self._servers.values():  # its lifecycle manager notices late, and gives up for good
                server.failed = server.failed or world.time_s - died_s > DEACTIVATED_S
        elif not all(server.active for server in self._servers.values()):
            self._drives.abort(Code.NONE, world.time_s)
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
            open_ = self._navigator is not None and self._servers[server].active
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

    def _navigate(self, handle: ServerGoalHandle) -> NavigateToPose.Result:
        drives = self._drives
        assert drives is not None, "goals are admitted once the World is there"
        try:
            goal = _in_map(handle.request.pose)
        except NavigationError as error:
            handle.abort()
            return NavigateToPose.Result(error_code=int(error.code))
        log.info("Nav2 stand-in: goal", x=round(goal.x, 2), y=round(goal.y, 2), yaw=round(goal.yaw, 2))
        drive = Drive(goal, lambda: handle.is_cancel_requested)
        drives.submit(drive)
        began_s = time.monotonic()
        told: Planned | None = None
        self._feed_back(handle, drive, 0.0)  # before there is a path: 0.0 m left
        while not drive.ended.wait(_FEEDBACK_PERIOD_S) and not self.closing.is_set():
            self._feed_back(handle, drive, time.monotonic() - began_s)
            told = self._tell_plan(told)
        match drive.ending:
            case DriveEnding.SUCCEEDED:
                handle.succeed()
            case DriveEnding.CANCELED:
                handle.canceled()
            case _:
                handle.abort()
        progress = drive.progress
        log.info("Nav2 stand-in: goal ended", how=str(drive.ending), code=int(progress.code), detail=progress.detail)
        return NavigateToPose.Result(error_code=int(progress.code))  # Jazzy's never fills error_msg

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

    def _tell_plan(self, told: Planned | None) -> Planned | None:
        """Each new path of the goal under way, for whoever looks."""
        now = self._navigator.path if self._navigator is not None else None
        if now is not None and now is not told and self._plan.get_subscription_count():
            self._plan.publish(messages.path(now.poses(), time.time_ns()))
        return now

    def _compute_path(self, handle: ServerGoalHandle) -> ComputePathToPose.Result:
        navigator, request = self._navigator, handle.request
        assert navigator is not None, "goals are admitted once the World is there"
        result = ComputePathToPose.Result()
        began_s = time.monotonic()
        try:
            start = _in_map(request.start) if request.use_start else self._robot_pose()
            found = navigator.plan(start, _in_map(request.goal))
        except NavigationError as error:
            result.error_code = int(error.code)
            log.info("Nav2 stand-in: no path", code=int(error.code), detail=error.detail)
            handle.abort()
        else:
            result.path = messages.path(found.poses(), time.time_ns())
            self._plan.publish(result.path)
            handle.succeed()
        result.planning_time = messages.duration(time.monotonic() - began_s)
        return result


def parameters(settings: SimSettings) -> dict[str, Parameters]:
    """What the stand-in keeps to, under the names that turtlebot4's `nav2.yaml` gives it."""
    return {
        "controller_server": {
            "general_goal_checker.xy_goal_tolerance": settings.nav2_goal_tolerance_m,
            "general_goal_checker.yaw_goal_tolerance": settings.nav2_goal_tolerance_rad,
            "progress_checker.required_movement_radius": Patience.moved_m,
            "progress_checker.movement_time_allowance": Patience.stuck_s,
        },
        "planner_server": {"GridBased.tolerance": settings.nav2_planner_tolerance_m},
    }


def _in_map(message: Any) -> Pose2D:
    """The pose of a PoseStamped. Raises `NavigationError` for another frame than the map and for no numbers."""
    if message.header.frame_id not in {"", messages.MAP}:
        raise NavigationError(Code.TF_ERROR, f"poses are wanted in {messages.MAP}, not in {message.header.frame_id}")
    try:
        return messages.pose2d(message.pose)
    except ValueError as error:
        raise NavigationError(Code.GOAL_OUTSIDE_MAP, "the pose is outside any map") from error
