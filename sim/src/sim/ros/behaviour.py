"""The base's own behaviours, docking and undocking, in the World's thread; meanwhile `cmd_vel` is ignored."""

import threading
from collections.abc import Callable
from enum import StrEnum
from typing import Final

from geometry.poses import compose, inverse
from sim.nav.docking import Docking, Undocking
from sim.world import World

_TIMEOUT_S: Final = 60.0


class Ending(StrEnum):
    DONE = "done"
    CANCELED = "canceled"
    FAILED = "failed"


class Behaviour:
    """One run of a behaviour; `ended` is set when `ending` and `is_docked` hold."""

    def __init__(self, name: str, controller: Docking | Undocking, cancel_requested: Callable[[], bool]) -> None:
        self.name = name
        self.controller = controller
        self.cancel_requested = cancel_requested
        self.began_s: float | None = None
        self.sees_dock = False
        self.is_docked = False
        self.ending: Ending | None = None
        self.ended = threading.Event()

    @classmethod
    def docking(cls, cancel_requested: Callable[[], bool]) -> "Behaviour":
        return cls("dock", Docking(), cancel_requested)

    @classmethod
    def undocking(cls, cancel_requested: Callable[[], bool]) -> "Behaviour":
        return cls("undock", Undocking(), cancel_requested)

    def end(self, how: Ending) -> None:
        self.ending = how
        self.ended.set()


class BaseBehaviours:
    """At most one behaviour at a time; lives in the World's thread."""

    def __init__(self) -> None:
        self._running: Behaviour | None = None

    def take(self, behaviour: Behaviour) -> None:
        """Starts it, or fails it at once while another runs."""
        if self._running is not None:
            behaviour.end(Ending.FAILED)
            return
        self._running = behaviour

    def step(self, world: World) -> bool:
        """Steers for one control period; true while the base is busy with itself."""
        running = self._running
        if running is None:
            return False
        status = world.dock_status()
        running.sees_dock, running.is_docked = status.dock_visible, status.is_docked
        ending = self._steer(running, world)
        if ending is None:
            return True
        world.command(0.0, 0.0, behaviour=True)
        self._running = None
        running.end(ending)
        return False

    def _steer(self, running: Behaviour, world: World) -> Ending | None:
        if running.began_s is None:
            running.began_s = world.time_s
            if running.name == "dock" and not running.sees_dock:
                return Ending.FAILED
            if running.name == "undock" and not running.is_docked:
                return Ending.FAILED
        if running.cancel_requested():
            return Ending.CANCELED
        if running.name == "dock" and running.is_docked:
            return Ending.DONE
        # Where the dock's infrared beacons put the robot: the truth, relative to the dock.
        twist = running.controller.step(compose(inverse(world.scene.dock), world.truth.pose))
        if twist is None:
            return Ending.DONE
        accepted = world.command(twist.linear_x, twist.angular_z, behaviour=True)
        timed_out = world.time_s - running.began_s > _TIMEOUT_S
        return None if accepted and not timed_out else Ending.FAILED
