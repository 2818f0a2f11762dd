"""The toy robot's base as create3_republisher puts it on ROS on a TurtleBot 4 (Jazzy), after its source:

each topic reliable and kept for late listeners, one message deep, and sent on change only; `cmd_vel` best effort, one
deep; an e_stop that is done and answered with `success: false`; actions that are accepted whatever the base says to
them, and a republisher that dies of what the base rejects.
"""

from typing import Any

from geometry_msgs.msg import Twist, TwistStamped
from irobot_create_msgs.action import Dock, Undock
from irobot_create_msgs.msg import DockStatus, HazardDetection, HazardDetectionVector, WheelStatus
from irobot_create_msgs.srv import EStop
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import BatteryState

from support.toy_robot import ToyRobot

REPUBLISHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
COMMANDS = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)


class RepublishedBase:
    """Topics and services on `node`; the actions are made by whoever owns the node, out of `dock`."""

    def __init__(self, node: Node, toy: ToyRobot, group: Any, *, velocity: type[Twist] | type[TwistStamped]) -> None:
        self._toy = toy
        self._sent: dict[str, Any] = {}
        self._topics = {
            name: node.create_publisher(kind, name, REPUBLISHED)
            for name, kind in {
                "battery_state": BatteryState,
                "dock_status": DockStatus,
                "hazard_detection": HazardDetectionVector,
                "wheel_status": WheelStatus,
            }.items()
        }
        node.create_subscription(velocity, "cmd_vel", self._told, COMMANDS)
        node.create_service(EStop, "e_stop", self._e_stop, callback_group=group)

    def publish(self) -> None:
        """What has changed. No hazard at all is nothing to tell before there was one."""
        toy = self._toy
        self._change("battery_state", BatteryState(percentage=0.8))
        self._change("dock_status", DockStatus(is_docked=toy.docked, dock_visible=toy.dock_visible))
        self._change("wheel_status", WheelStatus(wheels_enabled=not toy.base_stop))
        found = [HazardDetection(type=getattr(HazardDetection, name)) for name in sorted(toy.hazards)]
        if found or "hazard_detection" in self._sent:
            self._change("hazard_detection", HazardDetectionVector(detections=found))

    def dock(self, handle: Any, kind: type[Dock] | type[Undock]) -> Any:
        """What the base would reject kills the republisher: this one only says so, and does nothing."""
        toy = self._toy
        rejected = (toy.docked or not toy.dock_visible) if kind is Dock else not toy.docked
        if rejected:
            toy.republisher_deaths += 1
            handle.abort()
        elif toy.can_dock:
            toy.drive_onto_dock(kind is Dock)
            handle.succeed()
        else:
            handle.abort()
        return kind.Result(is_docked=toy.docked)

    def _told(self, message: Twist | TwistStamped) -> None:
        twist = message.twist if isinstance(message, TwistStamped) else message
        self._toy.told(twist.linear.x, twist.angular.z)

    def _e_stop(self, request: EStop.Request, response: EStop.Response) -> EStop.Response:
        self._toy.asked_to_stop(request.e_stop_on)
        return response

    def _change(self, topic: str, message: Any) -> None:
        if self._sent.get(topic) != message:
            self._sent[topic] = message
            self._topics[topic].publish(message)
