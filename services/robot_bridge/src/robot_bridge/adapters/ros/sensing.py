"""Subscriptions: what the robot publishes becomes the newest value of a sense. Runs in the robot's thread.

A message that makes no sense is refused with a reason, which `/ready`, `/state` and the log tell; a measurement that is
sent again is no news. Both are decided here, for every topic alike.
"""

import contextlib
from collections.abc import Callable, Generator
from functools import partial
from typing import Any, TypeVar

import structlog
from geometry_msgs.msg import PoseWithCovarianceStamped, TransformStamped, Twist, TwistStamped
from irobot_create_msgs.msg import DockStatus, HazardDetectionVector, WheelStatus
from nav_msgs.msg import OccupancyGrid
from nav_msgs.msg import Odometry as OdometryMessage
from prometheus_client import Counter
from rclpy.node import Node
from sensor_msgs.msg import BatteryState, CameraInfo, CompressedImage, Image, LaserScan
from tf2_msgs.msg import TFMessage

from mesh.clock import Clock
from mesh.latest_value import LatestValue
from robot_bridge.adapters.ros import convert
from robot_bridge.adapters.ros.subscriptions import BestAvailable, image_type, qos_profile
from robot_bridge.sensing.sensor_readings import SensorReadings
from robot_bridge.sensing.stamps import TF, Moment
from robot_bridge.sensing.transforms import planar
from robot_bridge.settings import Channel, Settings

log = structlog.get_logger()

M = TypeVar("M")
V = TypeVar("V")

MALFORMED = Counter("robot_bridge_ros_malformed_total", "ROS messages that made no sense and were dropped", ["topic"])


class Sensing:
    """Fills `senses` from the node's subscriptions."""

    def __init__(
        self,
        node: Node,
        settings: Settings,
        senses: SensorReadings,
        clock: Clock,
        *,
        navigation_velocity: Callable[[float, float], None],
        wheels: Callable[[WheelStatus], None],
    ) -> None:
        ros = settings.ros
        self._node = node
        self._ros = ros
        self._settings = settings
        self._senses = senses
        self._clock = clock
        self._changing: list[BestAvailable] = []
        self._battery = convert.BatteryReading()
        senses.frames.set_base(ros.base_frame)
        senses.clocks.simulated = ros.use_sim_time
        self._subscribe(TFMessage, ros.tf_static, partial(self._frames, ros.tf_static, self._fixed_frame))
        self._subscribe(TFMessage, ros.tf, partial(self._frames, ros.tf, self._moving_frame))
        self._on("odom", OdometryMessage, ros.odom, self._odometry)
        self._on("scan", LaserScan, ros.scan, self._scan)
        self._on("pose", PoseWithCovarianceStamped, ros.amcl_pose, self._localisation)
        self._on("rgb", image_type(ros.rgb), ros.rgb, self._colour)
        self._on("depth", image_type(ros.depth), ros.depth, self._depth)
        self._keep("rgb_info", CameraInfo, ros.rgb_info, senses.rgb_intrinsics, convert.intrinsics)
        self._keep("depth_info", CameraInfo, ros.depth_info, senses.depth_intrinsics, convert.intrinsics)
        self._on("map", OccupancyGrid, ros.map, self._map)
        self._on("battery", BatteryState, ros.battery, self._charge)
        self._keep("dock", DockStatus, ros.dock_status, senses.dock, convert.dock)
        self._keep("hazards", HazardDetectionVector, ros.hazards, senses.hazards, convert.hazards)
        self._subscribe(WheelStatus, ros.wheel_status, wheels)
        if ros.cmd_vel_nav_type == "TwistStamped":
            self._subscribe(
                TwistStamped, ros.cmd_vel_nav, lambda m: navigation_velocity(m.twist.linear.x, m.twist.angular.z)
            )
        else:
            self._subscribe(Twist, ros.cmd_vel_nav, lambda m: navigation_velocity(m.linear.x, m.angular.z))

    def poll(self) -> None:
        """Called every second: looks anew at who publishes the topics that come on change only."""
        unpublished = [each.name for each in self._changing if not each.poll()]
        self._senses.hazards_offered.put(self._ros.hazards.name not in unpublished, self._clock.now_s())

    def _subscribe(self, kind: type[M], channel: Channel, heard: Callable[[M], None]) -> None:
        MALFORMED.labels(channel.name)  # there from the first, at 0
        if "best_available" in {channel.reliability, channel.durability}:
            self._changing.append(BestAvailable(self._node, kind, channel, heard))
        else:
            self._node.create_subscription(kind, channel.name, heard, qos_profile(channel))

    def _on(self, sensor: str, kind: type[M], channel: Channel, take: Callable[[M], str | None]) -> None:
        """`take` answers what is to be known of the message ('' = nothing), or none where it brings nothing new."""

        def heard(message: M) -> None:
            with self._refusing(sensor, channel):
                if (note := take(message)) is not None:
                    self._senses.reception.take(sensor, note)

        self._subscribe(kind, channel, heard)

    def _keep(
        self, sensor: str, kind: type[Any], channel: Channel, into: LatestValue[V], read: Callable[[Any], V]
    ) -> None:
        def take(message: Any) -> str:
            into.put(read(message), self._clock.now_s())
            return ""

        self._on(sensor, kind, channel, take)

    @contextlib.contextmanager
    def _refusing(self, sensor: str, channel: Channel) -> Generator[None]:
        """A message that makes no sense is counted, and its reason kept."""
        try:
            yield
        except (ValueError, OverflowError) as error:  # pydantic's ValidationError is a ValueError
            MALFORMED.labels(channel.name).inc()
            reason = " ".join(str(error).split())
            if self._senses.reception.refuse(sensor, reason, self._clock.now_s()):
                log.warning("received, not understood", sensor=sensor, topic=channel.name, reason=reason)

    def _moment(self, sensor: str, header: Any) -> Moment | None:
        return self._senses.clocks.moment(sensor, convert.stamp_s(header.stamp), self._clock.now_s())

    def _frames(self, channel: Channel, take: Callable[[TransformStamped], str], message: TFMessage) -> None:
        """Each transform on its own: one that makes no sense does not cost the others."""
        for each in message.transforms:
            name = "pose" if self._is_correction(each) else TF
            with self._refusing(name, channel):
                note = take(each)
                if name == "pose":  # many publish the others: a good one of another does not make up for a bad one
                    self._senses.reception.take(name, note)

    def _is_correction(self, each: TransformStamped) -> bool:
        """The localiser's: where odom lies in the map."""
        names = each.header.frame_id.lstrip("/"), each.child_frame_id.lstrip("/")
        return names == (self._ros.map_frame, self._ros.odom_frame)

    def _fixed_frame(self, each: TransformStamped) -> str:
        self._senses.frames.fix(each.header.frame_id, each.child_frame_id, convert.transform(each.transform))
        return ""

    def _moving_frame(self, each: TransformStamped) -> str:
        """The localiser's correction, and joints of the body; odometry comes with its velocity on its own topic."""
        now_s, transform = self._clock.now_s(), convert.transform(each.transform)
        if self._is_correction(each):
            correction = planar(transform)
            moment = self._moment(TF, each.header)
            if moment is None:
                self._senses.poses.still_localised(now_s)
                return ""
            self._senses.poses.add_map_to_odom(moment.stamp_s, correction, received_s=now_s)
            return moment.note
        if each.header.frame_id.lstrip("/") != self._ros.odom_frame:
            stamp_s = self._senses.clocks.on_bridge_s(convert.stamp_s(each.header.stamp), now_s)
            self._senses.frames.move(each.header.frame_id, each.child_frame_id, stamp_s, transform)
        return ""

    def _odometry(self, message: OdometryMessage) -> str | None:
        if (moment := self._moment("odom", message.header)) is None:
            return None
        odometry = convert.odometry(message, moment.stamp_s)
        self._senses.poses.add_odometry(odometry.stamp_s, odometry.pose)
        self._senses.odometry.put(odometry, self._clock.now_s())
        return _notes(moment.note, _other_frame(message.header.frame_id, self._ros.odom_frame))

    def _localisation(self, message: PoseWithCovarianceStamped) -> str:
        pose = convert.localisation(message, self._ros.map_frame)
        now_s = self._clock.now_s()
        stamp_s = self._senses.clocks.on_bridge_s(convert.stamp_s(message.header.stamp), now_s)
        self._senses.poses.add_localisation(stamp_s, pose, received_s=now_s)
        return ""

    def _scan(self, message: LaserScan) -> str | None:
        if (moment := self._moment("scan", message.header)) is None:
            return None
        frame = message.header.frame_id
        mount = self._senses.frames.in_base(frame) if frame else None
        if mount is None:
            raise ValueError(
                f"no transform leads from {self._ros.base_frame} to its frame, {frame or 'which is unnamed'}"
            )
        scan = convert.scan(message, mount, moment.stamp_s, self._settings)
        self._senses.scan.put(scan, self._clock.now_s())
        return _notes(moment.note, scan.note)

    def _colour(self, message: Image | CompressedImage) -> str | None:
        if (moment := self._moment("rgb", message.header)) is None:
            return None
        self._senses.rgb.put(convert.colour_image(message, moment.stamp_s), self._clock.now_s())
        return moment.note

    def _depth(self, message: Image | CompressedImage) -> str | None:
        if (moment := self._moment("depth", message.header)) is None:
            return None
        image = convert.depth_image(message, moment.stamp_s, self._settings.depth_m_max)
        self._senses.depth_history.add(image)
        self._senses.depth.put(image, self._clock.now_s())
        return moment.note

    def _map(self, message: OccupancyGrid) -> str:
        grid = convert.grid(message)
        self._senses.map.put(grid, self._clock.now_s())
        return grid.note

    def _charge(self, message: BatteryState) -> str:
        battery, note = self._battery.read(message)
        self._senses.charging_told.put(convert.charges(message) is not None, self._clock.now_s())
        self._senses.battery.put(battery, self._clock.now_s())
        return note


def _notes(*notes: str) -> str:
    return "; ".join(note for note in notes if note)


def _other_frame(frame: str, expected: str) -> str:
    return "" if frame.lstrip("/") == expected else f"it is in the frame {frame or '(unnamed)'}, not in {expected}"
