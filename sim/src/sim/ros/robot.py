"""The robot's own ROS interface: sensors, base, dock, lights and sound, as a TurtleBot4 Lite on a Create 3 has them."""

import threading
import time
from collections.abc import Callable
from typing import Any

import structlog
from geometry_msgs.msg import PoseWithCovarianceStamped, Twist, TwistStamped
from irobot_create_msgs.action import Dock, LedAnimation, Undock
from irobot_create_msgs.msg import AudioNoteVector, DockStatus, HazardDetectionVector
from irobot_create_msgs.srv import EStop
from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import BatteryState, CameraInfo, Image, Imu, LaserScan
from tf2_msgs.msg import TFMessage

from contracts.geometry import Pose2D
from sim.ros import messages
from sim.ros.behaviour import BaseBehaviours, Behaviour, Ending
from sim.ros.frames import compose, inverse
from sim.ros.realtime import Duty, RealTime
from sim.settings import SimSettings
from sim.world import Scan, World
from sim.world.robot import LIDAR_X_M, LIDAR_Z_M

log = structlog.get_logger()

SENSOR = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
"""As the drivers of the cameras, the lidar and the Create 3 publish."""
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class RobotInterface:
    """Publishers, subscriptions and servers of one robot on `node`; `duties` is what the World's thread runs."""

    def __init__(self, node: Node, settings: SimSettings, realtime: RealTime) -> None:
        self._node = node
        self._settings = settings
        self._realtime = realtime
        self._behaviours = BaseBehaviours()
        self._map_to_odom = Pose2D(x=0.0, y=0.0, yaw=0.0)
        self.pose = self._map_to_odom
        """base_link in the map, as the robot believes; replaced by the World's thread, read by any."""
        self.last_audio: tuple[tuple[int, float], ...] = ()
        """(frequency in Hz, seconds) of each note of the newest tune."""
        self.closing = threading.Event()
        self._make_publishers(node)
        self._make_inputs(node)
        self._make_servers(node)

    # --- the World's thread

    def duties(
        self, world: World, *, on_scan: Callable[[Scan, Pose2D], None], on_control: Callable[[World, int], None]
    ) -> list[Duty]:
        """What to do at which rate. `on_scan` gets each scan with the lidar's pose in the map."""
        world.rgb()  # the first pictures take long: before time starts to count
        world.depth()
        self._localize(world, time.time_ns())
        now_ns = time.time_ns()
        self._map.publish(messages.occupancy_grid(world.grid, now_ns))
        fixed = messages.fixed_frames(world.rgb_camera, world.depth_camera, (LIDAR_X_M, LIDAR_Z_M), now_ns)
        self._tf_static.publish(fixed)
        period_s = 1.0 / self._settings.scan_hz

        def scan(world: World, stamp_ns: int) -> None:
            measured = world.scan()
            self._scan.publish(messages.laser_scan(measured, period_s, stamp_ns))
            on_scan(measured, compose(self._believed(world), Pose2D(x=LIDAR_X_M, y=0.0, yaw=0.0)))

        def control(world: World, stamp_ns: int) -> None:
            self._publish_motion(world, stamp_ns)
            self._realtime.base_is_busy = self._behaviours.step(world)
            on_control(world, stamp_ns)

        return [
            Duty("amcl_pose", self._settings.amcl_hz, self._localize),
            Duty("scan", self._settings.scan_hz, scan),
            Duty("control", self._settings.odom_hz, control),
            Duty("base", 10.0, self._publish_base),
            Duty("battery", 1.0, self._publish_battery),
            Duty("rgb", self._settings.rgb_hz, self._publish_rgb, costly=True),
            Duty("depth", self._settings.depth_hz, self._publish_depth, costly=True),
        ]

    def _believed(self, world: World) -> Pose2D:
        return compose(self._map_to_odom, world.odometry().pose)

    def _localize(self, world: World, stamp_ns: int) -> None:
        estimate = world.localization()
        self._map_to_odom = compose(estimate.pose, inverse(world.odometry().pose))
        self._amcl.publish(messages.amcl_pose(estimate, stamp_ns))

    def _publish_motion(self, world: World, stamp_ns: int) -> None:
        measured = world.odometry()
        self.pose = compose(self._map_to_odom, measured.pose)
        self._odom.publish(messages.odometry(measured, stamp_ns))
        self._tf.publish(messages.moving_frames(self._map_to_odom, measured.pose, stamp_ns))
        self._imu.publish(messages.imu(world.imu(), stamp_ns))

    def _publish_base(self, world: World, stamp_ns: int) -> None:
        self._hazards.publish(messages.hazards(world.hazards(), stamp_ns))
        self._dock_status.publish(messages.dock_status(world.dock_status(), stamp_ns))

    def _publish_battery(self, world: World, stamp_ns: int) -> None:
        self._battery.publish(messages.battery(world.battery(), stamp_ns))

    def _publish_rgb(self, world: World, stamp_ns: int) -> None:
        """A camera renders only while somebody looks."""
        if self._rgb.get_subscription_count():
            self._rgb.publish(messages.rgb_image(world.rgb(), stamp_ns))
        if self._rgb_info.get_subscription_count():
            self._rgb_info.publish(messages.camera_info(world.rgb_camera, messages.RGB_OPTICAL, stamp_ns))

    def _publish_depth(self, world: World, stamp_ns: int) -> None:
        if self._depth.get_subscription_count():
            self._depth.publish(messages.depth_image(world.depth(), stamp_ns))
        if self._depth_info.get_subscription_count():
            self._depth_info.publish(messages.camera_info(world.depth_camera, messages.STEREO_OPTICAL, stamp_ns))

    # --- ROS threads

    def _make_publishers(self, node: Node) -> None:
        self._rgb = node.create_publisher(Image, "oakd/rgb/preview/image_raw", SENSOR)
        self._rgb_info = node.create_publisher(CameraInfo, "oakd/rgb/preview/camera_info", SENSOR)
        self._depth = node.create_publisher(Image, "oakd/stereo/image_raw", SENSOR)
        self._depth_info = node.create_publisher(CameraInfo, "oakd/stereo/camera_info", SENSOR)
        self._scan = node.create_publisher(LaserScan, "scan", SENSOR)
        self._odom = node.create_publisher(Odometry, "odom", SENSOR)
        self._imu = node.create_publisher(Imu, "imu", SENSOR)
        self._battery = node.create_publisher(BatteryState, "battery_state", SENSOR)
        self._dock_status = node.create_publisher(DockStatus, "dock_status", SENSOR)
        self._hazards = node.create_publisher(HazardDetectionVector, "hazard_detection", SENSOR)
        self._tf = node.create_publisher(TFMessage, "tf", QoSProfile(depth=100))
        self._tf_static = node.create_publisher(TFMessage, "tf_static", LATCHED)
        self._amcl = node.create_publisher(PoseWithCovarianceStamped, "amcl_pose", LATCHED)
        self._map = node.create_publisher(OccupancyGrid, "map", LATCHED)

    def _make_inputs(self, node: Node) -> None:
        if self._settings.cmd_vel_stamped:
            node.create_subscription(TwistStamped, "cmd_vel", lambda m: self._on_velocity(m.twist), SENSOR)
        else:
            node.create_subscription(Twist, "cmd_vel", self._on_velocity, SENSOR)
        node.create_subscription(PoseWithCovarianceStamped, "initialpose", self._on_initial_pose, 10)
        node.create_subscription(AudioNoteVector, "cmd_audio", self._on_audio, SENSOR)
        self._inputs_group = ReentrantCallbackGroup()
        node.create_service(EStop, "e_stop", self._on_e_stop, callback_group=self._inputs_group)

    def _make_servers(self, node: Node) -> None:
        group = ReentrantCallbackGroup()

        def action(kind: Any, name: str, run: Callable[[ServerGoalHandle], Any]) -> ActionServer:
            return ActionServer(
                node,
                kind,
                name,
                run,
                callback_group=group,
                goal_callback=lambda _: GoalResponse.ACCEPT,
                cancel_callback=lambda _: CancelResponse.ACCEPT,
            )

        self._actions = [
            action(Dock, "dock", self._dock),
            action(Undock, "undock", self._undock),
            action(LedAnimation, "led_animation", self._led_animation),
        ]

    def _on_velocity(self, message: Twist) -> None:
        twist = messages.twist2d(message.linear.x, message.angular.z)
        if twist is None:
            log.warning("ignored a velocity that is none", linear_x=message.linear.x, angular_z=message.angular.z)
        else:
            self._realtime.command(twist)

    def _on_initial_pose(self, message: PoseWithCovarianceStamped) -> None:
        """Takes the pose as the estimate; the localiser then finds back to its own within its next turn."""
        try:
            given = messages.pose2d(message.pose.pose)
        except ValueError:
            log.warning("ignored an initial pose that is none")
            return

        def reset(world: World) -> None:
            self._map_to_odom = compose(given, inverse(world.odometry().pose))

        self._realtime.call(reset)
        log.info("initial pose taken", x=round(given.x, 2), y=round(given.y, 2), yaw=round(given.yaw, 2))

    def _on_audio(self, message: AudioNoteVector) -> None:
        self.last_audio = tuple((note.frequency, messages.seconds(note.max_runtime)) for note in message.notes)
        log.info("playing", notes=self.last_audio)

    def _on_e_stop(self, request: EStop.Request, response: EStop.Response) -> EStop.Response:
        on = bool(request.e_stop_on)
        response.success = self._realtime.ask(lambda world: world.set_e_stop(on))
        response.message = f"e-stop is {'on' if on else 'off'}" if response.success else "the base does not answer"
        log.info("e-stop", on=on, success=response.success)
        return response

    def _dock(self, handle: ServerGoalHandle) -> Dock.Result:
        behaviour = Behaviour.docking(lambda: handle.is_cancel_requested)

        def feedback() -> None:
            handle.publish_feedback(Dock.Feedback(sees_dock=behaviour.sees_dock))

        return Dock.Result(is_docked=self._behave(handle, behaviour, feedback))

    def _undock(self, handle: ServerGoalHandle) -> Undock.Result:
        behaviour = Behaviour.undocking(lambda: handle.is_cancel_requested)
        return Undock.Result(is_docked=self._behave(handle, behaviour, lambda: None))

    def _behave(self, handle: ServerGoalHandle, behaviour: Behaviour, feedback: Callable[[], None]) -> bool:
        """Runs one of the base's own behaviours to its end; is it docked then?"""
        if not self._realtime.ask(lambda _: self._behaviours.take(behaviour)):
            behaviour.end(Ending.FAILED)
        while not behaviour.ended.wait(0.2) and not self.closing.is_set():
            feedback()
        match behaviour.ending:
            case Ending.DONE:
                handle.succeed()
            case Ending.CANCELED:
                handle.canceled()
            case _:
                handle.abort()
        log.info("the base ended a behaviour", name=behaviour.name, ending=str(behaviour.ending))
        return behaviour.is_docked

    def _led_animation(self, handle: ServerGoalHandle) -> LedAnimation.Result:
        wanted_s = min(messages.seconds(handle.request.max_runtime), 60.0)
        began_s = time.monotonic()
        log.info("light ring", animation=handle.request.animation_type, seconds=wanted_s)
        while (left_s := began_s + wanted_s - time.monotonic()) > 0 and not handle.is_cancel_requested:
            if self.closing.wait(min(left_s, 0.2)):
                break
            handle.publish_feedback(LedAnimation.Feedback(remaining_runtime=messages.duration(max(left_s, 0.0))))
        if handle.is_cancel_requested:
            handle.canceled()
        else:
            handle.succeed()
        return LedAnimation.Result(runtime=messages.duration(time.monotonic() - began_s))
