"""The toy robot as a real ROS 2 node: what robot_bridge's adapter meets on a robot, small and obedient."""

import threading
from typing import Any

import numpy as np
import rclpy
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseWithCovarianceStamped, TransformStamped, Twist, TwistStamped
from irobot_create_msgs.action import Dock, LedAnimation, Undock
from irobot_create_msgs.msg import AudioNoteVector
from lifecycle_msgs.msg import State
from lifecycle_msgs.srv import GetState
from nav2_msgs.action import ComputePathToPose, NavigateToPose
from nav2_msgs.srv import ClearEntireCostmap
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from rcl_interfaces.msg import Log
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import CameraInfo, Image, LaserScan
from tf2_msgs.msg import TFMessage

from robot_bridge.adapters.ros.convert import pose_stamped
from support.ros_base import RepublishedBase
from support.toy_robot import BEAMS, CAMERA_X_M, CAMERA_Z_M, FX, OPTICAL_XYZW, START, ToyRobot

SENSOR = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
STEP_S = 0.05


class RosToyRobot:
    """`open()` and `close()`; in between the toy is the robot on this ROS domain."""

    def __init__(self, toy: ToyRobot, *, namespace: str = "", stamped: bool = True, scan: str = "scan") -> None:
        """`stamped` says whether its velocities are TwistStamped or Twist."""
        self.toy = toy
        self._namespace = namespace
        self._stamped = stamped
        self._scan_name = scan
        self._closing = threading.Event()

    def open(self) -> None:
        self._context = rclpy.Context()
        rclpy.init(context=self._context, signal_handler_options=SignalHandlerOptions.NO)
        self._node = Node(
            "toy_robot",
            namespace=self._namespace,
            context=self._context,
            start_parameter_services=False,
            enable_rosout=False,
        )
        self._group = ReentrantCallbackGroup()
        self._publishers()
        self._servers()
        self._executor = MultiThreadedExecutor(4, context=self._context)
        self._executor.add_node(self._node)
        self._thread = threading.Thread(target=self._spin, name="toy-robot")
        self._thread.start()

    def close(self) -> None:
        self._closing.set()
        self._thread.join()
        self._executor._executor.shutdown(wait=True)  # its pool: whatever still runs ends before what it uses is gone
        self._executor.shutdown()
        for action in self._actions:
            action.destroy()
        self._node.destroy_node()
        self._context.try_shutdown()
        self._context.destroy()

    def _spin(self) -> None:
        while not self._closing.is_set():
            self._executor.spin_once(timeout_sec=0.2)

    def _publishers(self) -> None:
        publisher = self._node.create_publisher
        self._scan = publisher(LaserScan, self._scan_name, SENSOR)
        self._odom = publisher(Odometry, "odom", SENSOR)
        self._rgb = publisher(Image, "oakd/rgb/preview/image_raw", SENSOR)
        self._rgb_info = publisher(CameraInfo, "oakd/rgb/preview/camera_info", SENSOR)
        self._depth = publisher(Image, "oakd/stereo/image_raw", SENSOR)
        self._depth_info = publisher(CameraInfo, "oakd/stereo/camera_info", SENSOR)
        self._tf = publisher(TFMessage, "tf", 100)
        self._tf_static = publisher(TFMessage, "tf_static", LATCHED)
        self._map = publisher(OccupancyGrid, "map", LATCHED)
        self._planned = publisher(Path, "plan", 1)
        self._rosout = publisher(Log, "/rosout", LATCHED)
        velocity = TwistStamped if self._stamped else Twist
        self._cmd_vel_nav = publisher(velocity, "cmd_vel_nav", 1)
        self._publish_fixed()
        self._base = RepublishedBase(self._node, self.toy, self._group, velocity=velocity)
        self._node.create_subscription(PoseWithCovarianceStamped, "initialpose", self._initial_pose, 10)
        self._node.create_subscription(AudioNoteVector, "cmd_audio", self._audio, 10)
        self._node.create_timer(STEP_S, self._step)

    def _initial_pose(self, message: PoseWithCovarianceStamped) -> None:
        self.toy.told_where(message.pose.pose.position.x, message.pose.pose.position.y)

    def _audio(self, message: AudioNoteVector) -> None:
        self.toy.notes = [(n.frequency, n.max_runtime.sec + n.max_runtime.nanosec * 1e-9) for n in message.notes]

    def _publish_fixed(self) -> None:
        """The laser looks to the left, as on a TurtleBot4; the two cameras share their place."""
        laser, optical = TransformStamped(), TransformStamped()
        laser.header.frame_id, laser.child_frame_id = "base_link", "laser"
        laser.transform.rotation.z = laser.transform.rotation.w = 0.5**0.5
        optical.header.frame_id, optical.child_frame_id = "base_link", "optical"
        optical.transform.translation.x, optical.transform.translation.z = CAMERA_X_M, CAMERA_Z_M
        q = optical.transform.rotation
        q.x, q.y, q.z, q.w = OPTICAL_XYZW
        self._tf_static.publish(TFMessage(transforms=[laser, optical]))
        grid = OccupancyGrid()
        cells = self.toy.cells()
        grid.info.height, grid.info.width, grid.info.resolution = cells.shape[0], cells.shape[1], 0.1
        grid.info.origin.orientation.w = 1.0
        grid.data = cells.flatten().tolist()
        self._map.publish(grid)
        self._rosout.publish(Log(level=Log.INFO, name="toy", msg="the toy is awake"))

    def _step(self) -> None:
        toy, now = self.toy, self._node.get_clock().now().to_msg()
        toy.step(STEP_S)
        if "odom" not in toy.silent:
            self._publish_odometry(now)
        if "pose" not in toy.silent:
            self._publish_correction(now)
        if "scan" not in toy.silent:
            self._publish_scan(now)
        self._publish_images(now)
        self._base.publish()
        if toy.navigation == "drives":  # always: also when no goal of the bridge is active
            velocity = TwistStamped() if self._stamped else Twist()
            (velocity.twist if isinstance(velocity, TwistStamped) else velocity).linear.x = 0.2
            self._cmd_vel_nav.publish(velocity)

    def _publish_odometry(self, now: Any) -> None:
        toy, message = self.toy, Odometry()
        message.header.stamp, message.header.frame_id, message.child_frame_id = now, "odom", "base_link"
        message.pose.pose.position.x, message.pose.pose.position.y = toy.x, toy.y
        message.pose.pose.orientation.z = float(np.sin(toy.yaw / 2))
        message.pose.pose.orientation.w = float(np.cos(toy.yaw / 2))
        message.twist.twist.linear.x, message.twist.twist.angular.z = toy.linear_x, toy.angular_z
        self._odom.publish(message)

    def _publish_correction(self, now: Any) -> None:
        correction = TransformStamped()
        correction.header.stamp, correction.header.frame_id, correction.child_frame_id = now, "map", "odom"
        correction.transform.translation.x, correction.transform.translation.y = START.x, START.y
        correction.transform.rotation.w = 1.0
        self._tf.publish(TFMessage(transforms=[correction]))

    def _publish_scan(self, now: Any) -> None:
        bearings, ranges = self.toy.bearings_and_ranges()
        message = LaserScan(angle_min=float(bearings[0] - np.pi / 2), angle_increment=2 * np.pi / BEAMS)
        message.header.stamp, message.header.frame_id = now, "laser"
        message.angle_max = message.angle_min + 2 * np.pi
        message.range_min, message.range_max = 0.15, 12.0
        message.ranges = ranges.astype(np.float32).tolist()
        self._scan.publish(message)

    def _publish_images(self, now: Any) -> None:
        if "rgb" not in self.toy.silent:
            rgb = _image(np.ascontiguousarray(self.toy.picture()[:, :, ::-1]), "rgb8", now)
            self._rgb.publish(rgb)
            self._rgb_info.publish(_info(250, 250, FX, now))
        if "depth" not in self.toy.silent:
            self._depth.publish(_image((self.toy.depths_m() * 1000).astype(np.uint16), "16UC1", now))
            self._depth_info.publish(_info(640, 400, 2 * FX, now))

    def _servers(self) -> None:
        node, group = self._node, self._group
        for name in ("bt_navigator", "planner_server", "controller_server"):
            node.create_service(GetState, f"{name}/get_state", self._get_state, callback_group=group)
        for name in ("global", "local"):
            service = f"{name}_costmap/clear_entirely_{name}_costmap"
            node.create_service(ClearEntireCostmap, service, self._clear, callback_group=group)
        self._actions = [
            self._action(NavigateToPose, "navigate_to_pose", self._navigate),
            self._action(ComputePathToPose, "compute_path_to_pose", self._plan),
            self._action(Dock, "dock", lambda handle: self._base.dock(handle, Dock)),
            self._action(Undock, "undock", lambda handle: self._base.dock(handle, Undock)),
            self._action(LedAnimation, "led_animation", self._lights),
        ]

    def _action(self, kind: Any, name: str, run: Any) -> ActionServer:
        def admit(_: Any) -> GoalResponse:
            rejected = self.toy.navigation == "rejects" and kind is NavigateToPose
            return GoalResponse.REJECT if rejected else GoalResponse.ACCEPT

        return ActionServer(
            self._node,
            kind,
            name,
            run,
            callback_group=self._group,
            goal_callback=admit,
            cancel_callback=self._cancel,
        )

    def _cancel(self, _: Any) -> CancelResponse:
        self.toy.cancelled += 1
        return CancelResponse.ACCEPT

    def _get_state(self, _: GetState.Request, response: GetState.Response) -> GetState.Response:
        active = self.toy.navigation != "is_inactive"
        response.current_state.id = State.PRIMARY_STATE_ACTIVE if active else State.PRIMARY_STATE_INACTIVE
        return response

    def _clear(self, _: Any, response: ClearEntireCostmap.Response) -> ClearEntireCostmap.Response:
        self.toy.cleared += 1
        return response

    def _navigate(self, handle: Any) -> NavigateToPose.Result:
        p = handle.request.pose.pose
        self.toy.goals.append((p.position.x, p.position.y, p.orientation.z))
        if self.toy.gives_up():
            handle.abort()
            return NavigateToPose.Result(error_code=self.toy.give_up_code)  # Jazzy's never fills error_msg
        match self.toy.navigation:
            case "succeeds":
                handle.succeed()
            case _:
                while not handle.is_cancel_requested and not self._closing.wait(0.05):
                    handle.publish_feedback(NavigateToPose.Feedback(distance_remaining=1.5))
                if handle.status != GoalStatus.STATUS_CANCELED and handle.is_cancel_requested:
                    handle.canceled()
                else:
                    handle.abort()
        return NavigateToPose.Result()

    def _plan(self, handle: Any) -> ComputePathToPose.Result:
        result = ComputePathToPose.Result()
        goal = handle.request.goal
        if code := self.toy.plan_code(goal.pose.position.x, goal.pose.position.y):
            handle.abort()
            result.error_code = code
            return result
        begin = pose_stamped(START, "map")
        corner = pose_stamped(START, "map")
        corner.pose.position.x = goal.pose.position.x
        result.path.poses = [begin, corner, goal]
        self._planned.publish(result.path)
        handle.succeed()
        return result

    def _lights(self, handle: Any) -> LedAnimation.Result:
        asked = handle.request
        colours = tuple((led.red, led.green, led.blue) for led in asked.lightring.leds)
        seconds = asked.max_runtime.sec + asked.max_runtime.nanosec * 1e-9
        self.toy.leds = asked.animation_type, colours, seconds
        handle.succeed()
        return LedAnimation.Result()


def _image(pixels: np.ndarray, encoding: str, now: Any) -> Image:
    message = Image(height=pixels.shape[0], width=pixels.shape[1], encoding=encoding, step=pixels.strides[0])
    message.header.stamp, message.header.frame_id = now, "optical"
    message.data = pixels.tobytes()
    return message


def _info(width: int, height: int, fx: float, now: Any) -> CameraInfo:
    message = CameraInfo(width=width, height=height)
    message.header.stamp, message.header.frame_id = now, "optical"
    message.k = [fx, 0.0, width / 2, 0.0, fx, height / 2, 0.0, 0.0, 1.0]
    return message
