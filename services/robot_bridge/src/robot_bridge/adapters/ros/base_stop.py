"""The base's own e_stop, the second way to stop: asked for until the base agrees, and again while it lasts."""

from typing import Any

import structlog
from irobot_create_msgs.srv import EStop
from rclpy.node import Node

from robot_bridge.settings import RosSettings

log = structlog.get_logger()


class BaseStop:
    """In the robot's thread. A base that has none, or is not there yet, hinders nothing."""

    def __init__(self, node: Node, ros: RosSettings) -> None:
        self._client = node.create_client(EStop, ros.e_stop_service)
        self._wanted: bool | None = None
        self._agreed: bool | None = None

    def engage(self, engaged: bool) -> None:
        self._wanted, self._agreed = engaged, None
        self.poll()

    def poll(self) -> None:
        """Call it once a second: a base that has restarted forgets, and a call may have been lost."""
        wanted = self._wanted
        if wanted is None or (wanted is False and self._agreed is False) or not self._client.service_is_ready():
            return
        future = self._client.call_async(EStop.Request(e_stop_on=wanted))
        future.add_done_callback(lambda done: self._answered(wanted, done))

    def _answered(self, wanted: bool, done: Any) -> None:
        answer = done.result()
        if answer is None or wanted is not self._wanted:
            return
        if answer.success:
            self._agreed = wanted
        else:
            log.warning("the base refuses its e_stop", engaged=wanted, reason=str(answer.message)[:200])
