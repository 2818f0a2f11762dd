"""The robot's own ROS interface: sensors, base, localiser, lights and sound, as a TurtleBot4 Lite has them."""

import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

import structlog
from irobot_create_msgs.action import LedAnimation
from irobot_create_msgs.msg import AudioNoteVector
from nav_msgs.msg import OccupancyGrid as OccupancyGridMessage
from nav_msgs.msg import Odometry
from rclpy.action.server import ActionServer, CancelResponse, GoalResponse, ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo, Image, Imu, LaserScan
from tf2_msgs.msg import TFMessage

from contracts.geometry import Pose2D
from geometry.poses import compose
from sim.ros import messages
from sim.ros.base import BaseInterface
from sim.ros.localiser import LocaliserInterface
from sim.ros.quality import COMMAND, DRIVER, REPUBLISHED
from sim.ros.realtime import Duty, RealTime
from sim.settings import SimSettings
from sim.world import OccupancyGrid, Scan, World
from sim.world.arm.models import ARMS
from sim.world.robot import LIDAR, LIDAR_Z_M

if TYPE_CHECKING:
    from sim.ros.arm import ArmInterface

log = structlog.get_logger()


class RobotInterface:
    """Publishers, subscriptions and servers of one robot on `node`; `duties` is what the World's thread runs."""

    def __init__(self, node: Node, settings: SimSettings, realtime: RealTime) -> None:
        self._settings = settings
        self._realtime = realtime
        self._base = BaseInterface(node, settings, realtime)
        self._localiser = LocaliserInterface(node, settings, realtime)
        self._undocked_s = 0.0
        """When it was last seen on its dock."""
        self.pose = Pose2D(x=0.0, y=0.0, yaw=0.0)
        """base_link in the map, as the robot believes; replaced by the World's thread, read by any."""
        self.last_audio: tuple[tuple[int, float], ...] = ()
        """(frequency in Hz, seconds) of each note of the newest tune."""
        self.closing = self._base.closing
        self._arm = _arm_interface(node, settings, realtime, self.closing)
        self._make_publishers(node)
        node.create_subscription(AudioNoteVector, "cmd_audio", self._on_audio, COMMAND)
        self._lights = ActionServer(
            node,
            LedAnimation,
            "led_animation",
            self._led_animation,
            callback_group=ReentrantCallbackGroup(),
            goal_callback=lambda _: GoalResponse.ACCEPT,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )

    # --- the World's thread

    def duties(
        self,
        world: World,
        grid: OccupancyGrid,
        *,
        on_scan: Callable[[Scan, Pose2D], None],
        on_control: Callable[[World, int], None],
    ) -> list[Duty]:
        """What to do at which rate. `grid` is the map it begins with; `on_scan` gets each scan with the lidar's pose in
        the map."""
        world.rgb()  # the first pictures take long: before time starts to count
        world.depth()
        self._localiser.begin(world)
        now_ns = time.time_ns()
        self.publish_map(grid, now_ns)
        fixed = messages.fixed_frames(world.rgb_camera, world.depth_camera, LIDAR, LIDAR_Z_M, now_ns)
        self._tf_static.publish(fixed)
        period_s = 1.0 / self._settings.scan_hz

        def scan(world: World, stamp_ns: int) -> None:
            if self._saves_power(world, wakes_after_s=0.0):
                return
            measured = world.scan()
            self._scan.publish(messages.laser_scan(measured, period_s, stamp_ns))
            self._localiser.turn(stamp_ns)
            on_scan(measured, compose(self._believed(world), LIDAR))

        def control(world: World, stamp_ns: int) -> None:
            self._publish_motion(world, stamp_ns)
            self._realtime.base_is_busy = self._base.step(world)
            on_control(world, stamp_ns)

        return [
            Duty("localiser", self._settings.amcl_hz, self._localiser.localise),
            Duty("scan", self._settings.scan_hz, scan),
            Duty("control", self._settings.odom_hz, control),
            *self._base.duties(),
            *(self._arm.duties() if self._arm is not None else ()),
            Duty("rgb", self._settings.rgb_hz, self._publish_rgb, costly=True),
            Duty("depth", self._settings.depth_hz, self._publish_depth, costly=True),
        ]

    def publish_map(self, grid: OccupancyGrid, stamp_ns: int) -> None:
        self._map.publish(messages.occupancy_grid(grid, stamp_ns))

    def _believed(self, world: World) -> Pose2D:
        return compose(self._localiser.map_to_odom, world.odometry().pose)

    def _publish_motion(self, world: World, stamp_ns: int) -> None:
        measured = world.odometry()
        self.pose = self._believed(world)
        self._odom.publish(messages.odometry(measured, stamp_ns))
        self._tf.publish(messages.odometry_frame(measured.pose, stamp_ns))
        self._imu.publish(messages.imu(world.imu(), stamp_ns))

    def _saves_power(self, world: World, *, wakes_after_s: float) -> bool:
        """Whether the lidar or the camera is off: on the dock, and for a while after it."""
        if not self._settings.power_saver:
            return False
        if world.dock_status().is_docked:
            self._undocked_s = world.time_s
            return True
        return 0.0 < self._undocked_s > world.time_s - wakes_after_s

    def _publish_rgb(self, world: World, stamp_ns: int) -> None:
        """A camera renders only while somebody looks."""
        if self._saves_power(world, wakes_after_s=self._settings.camera_boot_s):
            return
        if self._rgb.get_subscription_count():
            self._rgb.publish(messages.rgb_image(world.rgb(), stamp_ns))
        if self._rgb_info.get_subscription_count():
            self._rgb_info.publish(messages.camera_info(world.rgb_camera, messages.RGB_OPTICAL, stamp_ns))

    def _publish_depth(self, world: World, stamp_ns: int) -> None:
        if self._saves_power(world, wakes_after_s=self._settings.camera_boot_s):
            return
        if self._depth.get_subscription_count():
            self._depth.publish(messages.depth_image(world.depth(), stamp_ns))
        if self._depth_info.get_subscription_count():
            self._depth_info.publish(messages.camera_info(world.depth_camera, messages.STEREO_OPTICAL, stamp_ns))

    # --- ROS threads

    def _make_publishers(self, node: Node) -> None:
        self._rgb = node.create_publisher(Image, "oakd/rgb/preview/image_raw", DRIVER)
        self._rgb_info = node.create_publisher(CameraInfo, "oakd/rgb/preview/camera_info", DRIVER)
        self._depth = node.create_publisher(Image, "oakd/stereo/image_raw", DRIVER)
        self._depth_info = node.create_publisher(CameraInfo, "oakd/stereo/camera_info", DRIVER)
        self._scan = node.create_publisher(LaserScan, "scan", DRIVER)
        self._odom = node.create_publisher(Odometry, "odom", REPUBLISHED)
        self._imu = node.create_publisher(Imu, "imu", REPUBLISHED)
        self._tf = node.create_publisher(TFMessage, "tf", 100)
        self._tf_static = node.create_publisher(TFMessage, "tf_static", REPUBLISHED)
        self._map = node.create_publisher(OccupancyGridMessage, "map", REPUBLISHED)

    def _on_audio(self, message: AudioNoteVector) -> None:
        self.last_audio = tuple((note.frequency, messages.seconds(note.max_runtime)) for note in message.notes)
        log.info("playing", notes=self.last_audio)

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


def _arm_interface(
    node: Node, settings: SimSettings, realtime: RealTime, closing: threading.Event
) -> "ArmInterface | None":
    if (arm := ARMS.get(settings.arm)) is None:
        return None
    from sim.ros.arm import ArmInterface  # a robot without an arm does without control_msgs

    return ArmInterface(node, arm, realtime, closing)
