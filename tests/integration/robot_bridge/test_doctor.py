"""The doctor on a real ROS graph that is wrong in many ways at once."""

import threading
from collections.abc import Iterator

import pytest
import rclpy
from geometry_msgs.msg import TransformStamped, Twist, TwistStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import Image, LaserScan
from tf2_msgs.msg import TFMessage

from robot_bridge.doctor.checks import diagnose
from robot_bridge.doctor.examination import examine
from robot_bridge.doctor.findings import Check
from robot_bridge.settings import Settings

PERIOD_S = 0.1


def transform(parent: str, child: str) -> TransformStamped:
    each = TransformStamped(child_frame_id=child)
    each.header.frame_id = parent
    each.transform.rotation.w = 1.0
    return each


class WrongRobot:
    """Two nodes: a driver with nearly everything wrong, and Nav2's controller straight on the wheels."""

    def __init__(self, context: rclpy.Context) -> None:
        options = {"context": context, "start_parameter_services": False, "enable_rosout": False}
        self.nodes = [Node("driver", **options), Node("controller_server", **options)]
        driver, controller = self.nodes
        self._scans = driver.create_publisher(LaserScan, "scan", 5)
        self._pictures = driver.create_publisher(Image, "oakd/rgb/preview/image_raw", 5)
        self._frames = driver.create_publisher(TFMessage, "tf", 100)
        self._silent = [
            driver.create_publisher(LaserScan, "odom", 5),  # of another type
            driver.create_publisher(OccupancyGrid, "map", 1),  # volatile
            driver.create_publisher(Image, "camera/depth", 5),  # under another name
            driver.create_publisher(Odometry, "odometry", 5),
            driver.create_publisher(Twist, "cmd_vel_nav", 5),  # unstamped
            controller.create_publisher(TwistStamped, "cmd_vel", 5),  # past the bridge
        ]
        driver.create_timer(PERIOD_S, self._speak)

    def _speak(self) -> None:
        self._scans.publish(LaserScan(ranges=[1.0] * 9, angle_increment=0.1, range_max=0.0))
        self._pictures.publish(Image(encoding="yuv999", width=4, height=4, step=12, data=bytes(48)))
        self._frames.publish(TFMessage(transforms=[transform("base_link", "laser"), transform("tower", "laser")]))


@pytest.fixture
def wrong_robot(ros_domain: int) -> Iterator[None]:
    context = rclpy.Context()
    rclpy.init(context=context, signal_handler_options=SignalHandlerOptions.NO)
    robot = WrongRobot(context)
    executor = SingleThreadedExecutor(context=context)
    for node in robot.nodes:
        executor.add_node(node)
    closing = threading.Event()

    def spin() -> None:
        while not closing.is_set():
            executor.spin_once(timeout_sec=0.2)

    thread = threading.Thread(target=spin)
    thread.start()
    yield
    closing.set()
    thread.join()
    executor.shutdown()
    for node in robot.nodes:
        node.destroy_node()
    context.try_shutdown()
    context.destroy()


def test_what_is_wrong_on_a_live_graph_is_found_by_name(wrong_robot: None) -> None:
    findings = diagnose(examine(Settings(), seconds=6.0, environment={}, bridge=None))
    assert {(finding.check, finding.about) for finding in findings} >= {
        (Check.NOT_UNDERSTOOD, "/scan"),
        (Check.NOT_UNDERSTOOD, "/oakd/rgb/preview/image_raw"),
        (Check.OTHER_TYPE, "/odom"),
        (Check.OTHER_TYPE, "/cmd_vel_nav"),
        (Check.DURABILITY, "/map"),
        (Check.OTHER_NAME, "/oakd/stereo/image_raw"),
        (Check.NOT_PUBLISHED, "/oakd/rgb/preview/camera_info"),
        (Check.NOT_PUBLISHED, "/tf_static"),
        (Check.TWO_PARENTS, "laser"),
        (Check.BASE_NOT_IN_ODOM, "base_link"),
        (Check.NAV2_AWAY, "Nav2"),
        (Check.NAV2_PAST_THE_BRIDGE, "controller_server"),
        (Check.HAZARDS_NOT_REPUBLISHED, "/hazard_detection"),
        (Check.BASE_DEAF, "/cmd_vel"),
        (Check.SERVER_AWAY, "e_stop"),
    }


def test_an_empty_domain_is_said_to_be_that(ros_domain: int) -> None:
    (finding,) = diagnose(examine(Settings(), seconds=1.0, environment={}, bridge=None))
    assert finding.check is Check.NOTHING_THERE
