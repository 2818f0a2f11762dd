"""The toy's base stop as the real adapter follows it, without the wire; for both robots that need no ROS."""

import threading

from mesh.clock import Clock
from robot_bridge.safety.base_stop import BaseStop
from robot_bridge.sensing.sensor_readings import SensorReadings
from support.toy_robot import ToyRobot


class ToyBaseStop:
    """Asked from asyncio, followed in the robot's own loop or thread."""

    def __init__(self, toy: ToyRobot, senses: SensorReadings, clock: Clock) -> None:
        self._toy = toy
        self._senses = senses
        self._clock = clock
        self._base = BaseStop()
        self._lock = threading.Lock()

    def want(self, engaged: bool, *, restored: bool) -> None:
        with self._lock:
            if engaged:
                self._base.stopped(restored=restored)
            else:
                self._base.reset()
        self.follow()

    def follow(self) -> None:
        with self._lock:
            now_s = self._clock.now_s()
            self._base.there("base" not in self._toy.silent)
            self._base.heard(not self._toy.base_stop, now_s)
            if (asked := self._base.due(now_s)) is not None:
                self._toy.asked_to_stop(asked)
                self._base.heard(not asked, now_s)
            self._senses.base_stop.put(self._base.state(now_s), now_s)
