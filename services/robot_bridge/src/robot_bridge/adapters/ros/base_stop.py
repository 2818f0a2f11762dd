"""The base's own emergency stop, kept as wanted: asked for again until the base has confirmed it."""

from typing import Any

import structlog
from irobot_create_msgs.srv import EStop
from rclpy.node import Node

from mesh.clock import Clock

log = structlog.get_logger()

ANSWER_S_MAX = 2.5


class BaseStop:
    """Lives in the robot's thread. A base without the service is left alone; one that comes late or back is told."""

    def __init__(self, node: Node, service: str, clock: Clock) -> None:
        self._client = node.create_client(EStop, service)
        self._clock = clock
        self._wanted: bool | None = None
        self._confirmed: bool | None = None
        self._asked_s: float | None = None

    def want(self, engaged: bool) -> None:
        """At once when the base is there, else as soon as it is."""
        self._wanted, self._asked_s = engaged, None
        self.poll()

    def poll(self) -> None:
        """Called every second."""
        if self._wanted is None:
            return
        if not self._client.service_is_ready():
            self._confirmed = self._asked_s = None  # whoever answers next may know nothing of it
            return
        now_s = self._clock.now_s()
        waiting = self._asked_s is not None and now_s - self._asked_s < ANSWER_S_MAX
        if self._confirmed is self._wanted or waiting:
            return
        wanted, self._asked_s = self._wanted, now_s
        request = self._client.call_async(EStop.Request(e_stop_on=wanted))
        request.add_done_callback(lambda done: self._answered(done, wanted))

    def _answered(self, done: Any, wanted: bool) -> None:
        answer = done.result()
        if answer is not None and answer.success:
            self._confirmed = wanted
        else:
            log.warning(
                "the base refuses its own emergency stop", wanted=wanted, message=getattr(answer, "message", "")
            )
        if wanted is self._wanted:
            self._asked_s = None
