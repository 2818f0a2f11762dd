"""The base's own emergency stop over ROS: `robot_bridge.safety.base_stop` decides, this asks and listens."""

from typing import Any

import structlog
from irobot_create_msgs.msg import WheelStatus
from irobot_create_msgs.srv import EStop
from rclpy.node import Node

from mesh.clock import Clock
from mesh.latest_value import LatestValue
from robot_bridge.safety.base_stop import BaseStop, BaseStopState

log = structlog.get_logger()


class BaseStopService:
    """Lives in the robot's thread.

    What the service answers is not looked at: behind create3_republisher it is always `success: false`.
    """

    def __init__(self, node: Node, service: str, clock: Clock, told: LatestValue[BaseStopState]) -> None:
        self._client = node.create_client(EStop, service)
        self._clock = clock
        self._told = told
        self._base = BaseStop()
        self._asked: Any = None

    def want(self, engaged: bool, *, restored: bool) -> None:
        """At once when the base is there, else as soon as it is (a stop; a reset that finds it away is not kept)."""
        self._base.there(self._client.service_is_ready())
        if engaged:
            self._base.stopped(restored=restored)
        else:
            self._base.reset()
        self.poll()

    def wheels(self, message: WheelStatus) -> None:
        self._base.heard(bool(message.wheels_enabled), self._clock.now_s())
        self.poll()

    def poll(self) -> None:
        """Called every second, too."""
        now_s = self._clock.now_s()
        self._base.there(self._client.service_is_ready())
        if (engaged := self._base.due(now_s)) is not None:
            log.info("the base is asked to stop" if engaged else "the base is asked to let go")
            if self._asked is not None:
                self._client.remove_pending_request(self._asked)
            self._asked = self._client.call_async(EStop.Request(e_stop_on=engaged))
        self._told.put(self._base.state(now_s), now_s)
