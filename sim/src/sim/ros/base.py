"""The Create 3 base on ROS, as create3_republisher passes it on: what it tells, and what it can be told."""

import threading
from collections.abc import Callable
from typing import Any

import structlog
from geometry_msgs.msg import Twist, TwistStamped
from irobot_create_msgs.action import Dock, Undock
from irobot_create_msgs.msg import DockStatus, HazardDetectionVector, WheelStatus
from irobot_create_msgs.srv import EStop
from rclpy.action.server import ActionServer, CancelResponse, GoalResponse, ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from sensor_msgs.msg import BatteryState

from sim import world
from sim.ros import messages
from sim.ros.behaviour import BaseBehaviours, Behaviour, Ending
from sim.ros.quality import COMMAND, REPUBLISHED
from sim.ros.realtime import Duty, RealTime
from sim.settings import SimSettings
from sim.world import World

log = structlog.get_logger()


class BaseInterface:
    """Battery, dock, hazards and wheels are told on change only, and kept for late listeners."""

    def __init__(self, node: Node, settings: SimSettings, realtime: RealTime) -> None:
        self._settings = settings
        self._realtime = realtime
        self._behaviours = BaseBehaviours()
        self._dock_now = world.DockStatus(dock_visible=False, is_docked=False)
        self._told: dict[str, object] = {}
        self.closing = threading.Event()
        self._battery = node.create_publisher(BatteryState, "battery_state", REPUBLISHED)
        self._dock_status = node.create_publisher(DockStatus, "dock_status", REPUBLISHED)
        self._hazards = node.create_publisher(HazardDetectionVector, "hazard_detection", REPUBLISHED)
        self._wheels = node.create_publisher(WheelStatus, "wheel_status", REPUBLISHED)
        if settings.cmd_vel_stamped:
            node.create_subscription(TwistStamped, "cmd_vel", self._on_stamped, COMMAND)
        else:
            node.create_subscription(Twist, "cmd_vel", self._on_velocity, COMMAND)
        group = ReentrantCallbackGroup()
        node.create_service(EStop, "e_stop", self._on_e_stop, callback_group=group)

        def action(
            kind: Any, name: str, run: Callable[[ServerGoalHandle], Any], can: Callable[[], str]
        ) -> ActionServer:
            def admit(_: Any) -> GoalResponse:
                if why_not := can():
                    log.info("the base rejects a behaviour", name=name, why=why_not)
                return GoalResponse.REJECT if why_not else GoalResponse.ACCEPT

            return ActionServer(
                node,
                kind,
                name,
                run,
                callback_group=group,
                goal_callback=admit,
                cancel_callback=lambda _: CancelResponse.ACCEPT,
            )

        self._actions = [
            action(Dock, "dock", self._dock, self._why_no_docking),
            action(Undock, "undock", self._undock, self._why_no_undocking),
        ]

    # --- the World's thread

    @property
    def dock(self) -> world.DockStatus:
        """As it was last told."""
        return self._dock_now

    def step(self, world: World) -> bool:
        """One control period; true while the base is busy with itself."""
        return self._behaviours.step(world)

    def duties(self) -> list[Duty]:
        return [Duty("base", 10.0, self._tell), Duty("battery", 1.0, self._tell_battery)]

    def _tell(self, world: World, stamp_ns: int) -> None:
        self._dock_now, enabled = world.dock_status(), not world.e_stop_on
        if self._changed("dock", self._dock_now):
            self._dock_status.publish(messages.dock_status(self._dock_now, stamp_ns))
        if self._changed("wheels", enabled):
            self._wheels.publish(messages.wheel_status(stamp_ns, enabled=enabled))
        found = world.hazards()
        if (found or "hazards" in self._told) and self._changed("hazards", found):
            self._hazards.publish(messages.hazards(found, stamp_ns))

    def _tell_battery(self, world: World, stamp_ns: int) -> None:
        measured = world.battery()
        if self._changed("battery", (round(measured.percentage), measured.charging)):
            self._battery.publish(messages.battery(measured, stamp_ns))

    def _changed(self, what: str, now: object) -> bool:
        before = self._told.get(what)
        self._told[what] = now
        return before is None or before != now

    # --- ROS threads

    def _on_stamped(self, message: TwistStamped) -> None:
        self._on_velocity(message.twist)

    def _on_velocity(self, message: Twist) -> None:
        twist = messages.twist2d(message.linear.x, message.angular.z)
        if twist is None:
            log.warning("ignored a velocity that is none", linear_x=message.linear.x, angular_z=message.angular.z)
        else:
            self._realtime.command(twist)

    def _on_e_stop(self, request: EStop.Request, response: EStop.Response) -> EStop.Response:
        """Done, and answered with `success: false` as create3_republisher answers everything, unless set otherwise."""
        on = bool(request.e_stop_on)
        done = self._realtime.ask(lambda world: world.set_e_stop(on))
        response.success = done and self._settings.e_stop_confirms
        log.info("e-stop", on=on, done=done)
        return response

    def _why_no_docking(self) -> str:
        """'' where it may begin; else it is rejected, in create3_sim's cases."""
        if self._dock_now.is_docked:
            return "already docked"
        return "" if self._dock_now.dock_visible else "does not see the dock"

    def _why_no_undocking(self) -> str:
        return "" if self._dock_now.is_docked else "already undocked"

    def _dock(self, handle: ServerGoalHandle) -> Dock.Result:
        behaviour = Behaviour.docking(lambda: handle.is_cancel_requested)

        def feedback() -> None:
            handle.publish_feedback(Dock.Feedback(sees_dock=behaviour.sees_dock))

        return Dock.Result(is_docked=self._behave(handle, behaviour, feedback))

    def _undock(self, handle: ServerGoalHandle) -> Undock.Result:
        behaviour = Behaviour.undocking(lambda: handle.is_cancel_requested)
        return Undock.Result(is_docked=self._behave(handle, behaviour, lambda: None))

    def _behave(self, handle: ServerGoalHandle, behaviour: Behaviour, feedback: Callable[[], None]) -> bool:
        """Runs one of the base's own behaviours to its end; is it docked then?"""
        if not self._realtime.ask(lambda _: self._behaviours.take(behaviour)):
            behaviour.end(Ending.FAILED)
        while not behaviour.ended.wait(0.2) and not self.closing.is_set():
            feedback()
        match behaviour.ending:
            case Ending.DONE:
                handle.succeed()
            case Ending.CANCELED:
                handle.canceled()
            case _:
                handle.abort()
        log.info("the base ended a behaviour", name=behaviour.name, ending=str(behaviour.ending))
        return behaviour.is_docked
