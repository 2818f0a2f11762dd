"""The ROS topics that a recording holds, and that Foxglove is shown live: name, type, how often."""

from dataclasses import dataclass

from robot_bridge.settings import Channel, RosSettings

INFO_HZ = 1.0
"""A camera's calibration hardly ever changes."""


@dataclass(frozen=True, slots=True)
class RosTopic:
    """`type_name` is ROS's own, as Foxglove knows it: package/msg/Type."""

    type_name: str
    channel: Channel
    rate_hz: float = 0.0
    """At most so often; 0 = every message."""


def image_type_name(channel: Channel) -> str:
    """By the topic's name, as image_transport gives it."""
    compressed = channel.name.endswith(("/compressed", "/compressedDepth"))
    return "sensor_msgs/msg/CompressedImage" if compressed else "sensor_msgs/msg/Image"


def ros_topics(ros: RosSettings, images_hz: float) -> tuple[RosTopic, ...]:
    """Without pictures where `images_hz` is 0."""
    found = (
        RosTopic("tf2_msgs/msg/TFMessage", ros.tf),
        RosTopic("tf2_msgs/msg/TFMessage", ros.tf_static),
        RosTopic("nav_msgs/msg/Odometry", ros.odom),
        RosTopic("sensor_msgs/msg/LaserScan", ros.scan),
        RosTopic("geometry_msgs/msg/PoseWithCovarianceStamped", ros.amcl_pose),
        RosTopic("nav_msgs/msg/OccupancyGrid", ros.map),
        RosTopic("nav_msgs/msg/Path", ros.plan),
        RosTopic("sensor_msgs/msg/BatteryState", ros.battery),
        RosTopic("irobot_create_msgs/msg/DockStatus", ros.dock_status),
        RosTopic("irobot_create_msgs/msg/HazardDetectionVector", ros.hazards),
        RosTopic("irobot_create_msgs/msg/WheelStatus", ros.wheel_status),
        RosTopic(f"geometry_msgs/msg/{ros.cmd_vel_type}", ros.cmd_vel),
        RosTopic(f"geometry_msgs/msg/{ros.cmd_vel_nav_type}", ros.cmd_vel_nav),
        RosTopic("sensor_msgs/msg/CameraInfo", ros.rgb_info, INFO_HZ),
        RosTopic("sensor_msgs/msg/CameraInfo", ros.depth_info, INFO_HZ),
        RosTopic("rcl_interfaces/msg/Log", ros.rosout),
    )
    if images_hz <= 0.0:
        return found
    return (*found, *(RosTopic(image_type_name(channel), channel, images_hz) for channel in (ros.rgb, ros.depth)))
