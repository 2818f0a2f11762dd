"""The robot over ROS 2: one thread owns rclpy and does what asyncio hands to it, another ticks the wheels."""

import asyncio
import threading
from collections.abc import Callable
from concurrent.futures import Future as ThreadFuture
from typing import TYPE_CHECKING, Any

import rclpy
import structlog
from action_msgs.msg import GoalStatus as RosGoalStatus
from geometry_msgs.msg import PoseWithCovarianceStamped
from irobot_create_msgs.action import Dock, LedAnimation, Undock
from irobot_create_msgs.msg import AudioNoteVector
from nav2_msgs.action import ComputePathToPose, NavigateToPose
from nav2_msgs.srv import ClearEntireCostmap
from rclpy.action.client import ActionClient
from rclpy.clock import Clock as RosClock
from rclpy.clock_type import ClockType
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions

from contracts.geometry import Pose2D, Twist2D
from mesh.clock import Clock
from mesh.errors import ServiceTimeoutError, UnavailableError
from robot_bridge.adapters.ros import convert
from robot_bridge.adapters.ros.base_stop import BaseStopService
from robot_bridge.adapters.ros.calls import Calls, GoalsUnderWay, Handover, RosGoal
from robot_bridge.adapters.ros.goal_cancels import GoalCancels
from robot_bridge.adapters.ros.graph import TypeWatch
from robot_bridge.adapters.ros.lifecycle import Nav2Watch
from robot_bridge.adapters.ros.other_drivers import OtherDrivers
from robot_bridge.adapters.ros.recording import RosRecording
from robot_bridge.adapters.ros.sensing import Sensing
from robot_bridge.adapters.ros.subscriptions import qos_profile
from robot_bridge.adapters.ros.velocity import TICK_S, Ticker, VelocityPublisher
from robot_bridge.arm.models import MODELS
from robot_bridge.ports import Celebration, Path, Sink
from robot_bridge.sensing.sensor_readings import SensorReadings
from robot_bridge.settings import Settings

if TYPE_CHECKING:
    from robot_bridge.adapters.ros.arm import RosArm

log = structlog.get_logger()

CLOSE_S_MAX = 3.0


class RosRobot:
    """Implements `ports.Robot`. Everything of rclpy but publishing velocities happens in its own thread."""

    def __init__(self, settings: Settings, clock: Clock, *, on_death: Callable[[], None]) -> None:
        self._settings = settings
        self._clock = clock
        self._on_death = on_death
        self._senses = SensorReadings()
        self._closing = threading.Event()
        self._can_send = False
        self.arm = _arm(settings, clock)

    @property
    def senses(self) -> SensorReadings:
        return self._senses

    async def start(self, *, tick: Callable[[], None], navigation_velocity: Callable[[float, float], None]) -> None:
        self._loop = asyncio.get_running_loop()
        self._calls = Calls(self._loop, self._do, accept_s_max=self._settings.nav2_timeout_s)
        opened: ThreadFuture[None] = ThreadFuture()
        self._thread = threading.Thread(
            target=self._live, args=(navigation_velocity, opened), name="rclpy", daemon=True
        )
        self._thread.start()
        await asyncio.wrap_future(opened)
        self._ticker = Ticker(tick, period_s=TICK_S, on_death=self._on_death)
        self._ticker.start()

    async def close(self) -> None:
        """What was handed over before (cancelling a goal, say) is still done."""
        await asyncio.to_thread(self._ticker.stop)
        self._can_send = False
        self._do(self._closing.set)
        await asyncio.to_thread(self._thread.join, CLOSE_S_MAX)

    def send_velocity(self, twist: Twist2D) -> None:
        if self._can_send:
            self._velocity.send(twist)

    def engage_base_stop(self, engaged: bool, *, restored: bool = False) -> None:
        self._do(lambda: self._base_stop.want(engaged, restored=restored))

    def cancel_all_goals(self) -> None:
        for each in self._cancels:
            each.owe()
        self._do(self._ask_for_cancels)

    async def navigate(self, pose: Pose2D, on_progress: Callable[[float], None]) -> "RosGoal | None":
        await self._nav2_cancel.settle(self._settings.nav2_timeout_s)
        goal = NavigateToPose.Goal(pose=convert.pose_stamped(pose, self._settings.ros.map_frame))

        def heard(message: Any) -> None:  # in the robot's thread
            self._loop.call_soon_threadsafe(on_progress, float(message.feedback.distance_remaining))

        return await self._calls.send_goal(self._navigate, "nav2", goal, heard, under_way=self._goals)

    async def compute_path(self, goal: Pose2D, start: Pose2D | None) -> Path:
        frame = self._settings.ros.map_frame
        request = ComputePathToPose.Goal(goal=convert.pose_stamped(goal, frame), use_start=start is not None)
        if start is not None:
            request.start = convert.pose_stamped(start, frame)
        accepted = await self._calls.send_goal(self._plan, "nav2", request)
        if accepted is None:
            raise UnavailableError("nav2", "the planner rejects requests (is it active?)")
        try:
            async with asyncio.timeout(self._settings.nav2_timeout_s):
                result = await accepted.result()
        except TimeoutError as error:
            accepted.cancel()
            raise ServiceTimeoutError("nav2", "the planner did not answer in time") from error
        poses = tuple(convert.pose(each.pose) for each in result.result.path.poses)
        return Path(poses, int(result.result.error_code))

    async def clear_costmaps(self) -> None:
        for client in self._clear_costmaps:
            await self._calls.ask(
                "nav2",
                lambda client=client: client.call_async(ClearEntireCostmap.Request()),
                ready=client.service_is_ready,
                timeout_s=self._settings.costmap_timeout_s,
            )

    async def dock(self) -> bool:
        await self._dock_cancel.settle(self._settings.nav2_timeout_s)
        return await self._base_drives(self._dock, Dock.Goal(), docked=True)

    async def undock(self) -> bool:
        await self._undock_cancel.settle(self._settings.nav2_timeout_s)
        return await self._base_drives(self._undock, Undock.Goal(), docked=False)

    def set_initial_pose(self, pose: Pose2D) -> None:
        def call() -> None:
            now = self._node.get_clock().now().to_msg()
            self._initial_pose.publish(convert.initial_pose(pose, self._settings.ros.map_frame, now))

        self._do(call)

    def celebrate(self, celebration: Celebration) -> None:
        def call() -> None:
            self._audio.publish(convert.notes(celebration))
            if self._lights.server_is_ready():
                goal = LedAnimation.Goal(
                    animation_type=celebration.led_animation_type, lightring=convert.lights(celebration)
                )
                convert.set_duration(goal.max_runtime, celebration.led_duration_s)
                self._lights.send_goal_async(goal)

        self._do(call)

    def record(self, sink: Sink, *, images_hz: float) -> Callable[[], None]:
        opened: list[RosRecording] = []

        def open_() -> None:
            try:
                opened.append(RosRecording(self._node, self._settings.ros, sink, images_hz=images_hz))
            except OSError as error:
                log.error("ROS topics are not recorded: a definition is missing", error=str(error))  # noqa: TRY400

        def close() -> None:
            while opened:
                opened.pop().close()

        self._do(open_)
        return lambda: self._do(close)

    def _live(self, navigation_velocity: Callable[[float, float], None], opened: ThreadFuture[None]) -> None:
        """The thread's life. When it ends unasked the process ends with it."""
        context = Context()
        try:
            rclpy.init(context=context, signal_handler_options=SignalHandlerOptions.NO)
            self._open(context, navigation_velocity)
            self._can_send = True
            opened.set_result(None)
            while not self._closing.is_set():
                self._executor.spin_once(timeout_sec=0.5)
            self._shut()
        finally:
            self._can_send = False
            if not opened.done():
                opened.set_exception(UnavailableError("rclpy", "could not be started; see the log"))
            elif not self._closing.is_set():
                log.error("the robot's thread died; ending the process")
                self._on_death()
            context.try_shutdown()
            context.destroy()

    def _open(self, context: Context, navigation_velocity: Callable[[float, float], None]) -> None:
        ros = self._settings.ros
        self._executor = SingleThreadedExecutor(context=context)
        self._handover = Handover(self._executor)
        node = self._node = Node(
            ros.node_name,
            namespace=ros.namespace,
            context=context,
            parameter_overrides=[Parameter("use_sim_time", value=ros.use_sim_time)],
            start_parameter_services=False,
            enable_rosout=False,
        )
        self._velocity = VelocityPublisher(node, ros)
        self._audio = node.create_publisher(AudioNoteVector, ros.cmd_audio.name, qos_profile(ros.cmd_audio))
        self._initial_pose = node.create_publisher(
            PoseWithCovarianceStamped, ros.initial_pose.name, qos_profile(ros.initial_pose)
        )
        self._navigate = ActionClient(node, NavigateToPose, ros.navigate_action)
        self._goals = GoalsUnderWay(node, ros.navigate_action)
        self._plan = ActionClient(node, ComputePathToPose, ros.path_action)
        self._dock = ActionClient(node, Dock, ros.dock_action)
        self._undock = ActionClient(node, Undock, ros.undock_action)
        self._lights = ActionClient(node, LedAnimation, ros.led_action)
        self._base_stop = BaseStopService(node, ros.e_stop_service, self._clock, self._senses.base_stop)
        self._clear_costmaps = [node.create_client(ClearEntireCostmap, name) for name in ros.clear_costmap_services]
        self._nav2_cancel = GoalCancels(node, ros.navigate_action, "nav2", self._clock)
        self._dock_cancel = GoalCancels(node, ros.dock_action, "base", self._clock)
        self._undock_cancel = GoalCancels(node, ros.undock_action, "base", self._clock)
        self._cancels = (self._nav2_cancel, self._dock_cancel, self._undock_cancel)
        sensing = Sensing(
            node,
            self._settings,
            self._senses,
            self._clock,
            navigation_velocity=navigation_velocity,
            wheels=self._base_stop.wheels,
        )
        self._nav2 = Nav2Watch(
            node, ros, self._senses.nav2_missing, self._clock, self._navigate, cancel=self._nav2_cancel
        )
        steady = RosClock(clock_type=ClockType.STEADY_TIME)  # whatever a simulated or stepped clock does
        node.create_timer(1.0, self._ask_for_cancels, clock=steady)
        node.create_timer(1.0, self._nav2.poll, clock=steady)
        node.create_timer(1.0, self._base_stop.poll, clock=steady)
        node.create_timer(1.0, sensing.poll, clock=steady)
        others = OtherDrivers(node, self._velocity, self._senses, self._clock)
        node.create_timer(1.0, others.poll, clock=steady)
        node.create_timer(1.0, self._look_for_the_localiser, clock=steady)
        actions = (ros.navigate_action, ros.path_action, ros.dock_action, ros.undock_action)
        types = TypeWatch(node, actions, self._senses.mismatches, self._clock)
        node.create_timer(2.0, types.poll, clock=steady)
        if self.arm is not None:
            self.arm.open(node, self._calls)
            node.create_timer(1.0, self.arm.poll, clock=steady)
        self._executor.add_node(node)

    def _ask_for_cancels(self) -> None:
        for each in self._cancels:
            each.poll()

    def _look_for_the_localiser(self) -> None:
        self._senses.localiser_listens.put(self._initial_pose.get_subscription_count() > 0, self._clock.now_s())

    def _shut(self) -> None:
        """Leaves nothing on the network that others would take for a robot_bridge."""
        self._can_send = False
        self._executor.shutdown()
        for client in (self._navigate, self._plan, self._dock, self._undock, self._lights):
            client.destroy()
        if self.arm is not None:
            self.arm.shut()
        self._node.destroy_node()

    async def _base_drives(self, client: ActionClient, goal: Any, *, docked: bool) -> bool:
        accepted = await self._calls.send_goal(client, "base", goal)
        if accepted is None:
            return False
        try:
            result = await accepted.result()
        except asyncio.CancelledError:
            accepted.cancel()
            raise
        succeeded = result.status == RosGoalStatus.STATUS_SUCCEEDED
        return succeeded and bool(result.result.is_docked) is docked

    def _do(self, work: Callable[[], Any]) -> None:
        """Hands work to the robot's thread."""
        if not self._closing.is_set():
            self._handover.put(work)


def _arm(settings: Settings, clock: Clock) -> "RosArm | None":
    """As the settings say; a robot without an arm needs no control_msgs."""
    if (model := MODELS.get(settings.arm)) is None:
        return None
    from robot_bridge.adapters.ros.arm import RosArm

    return RosArm(model, settings.ros, clock)
