"""A robot's ends of the wire, in a process of its own: answers every action and service, and echoes messages.

What a goal asks for is read from it: a frame named `reject` is rejected, one named `abort` aborted with error 104, one
named `wait` runs until it is canceled, any other succeeds.
"""

import sys
from typing import Any

import rclpy
from irobot_create_msgs.action import Dock, LedAnimation, Undock
from irobot_create_msgs.msg import AudioNoteVector, DockStatus, HazardDetectionVector, LightringLeds
from irobot_create_msgs.srv import EStop
from nav2_msgs.action import ComputePathToPose, NavigateToPose
from nav2_msgs.srv import ClearEntireCostmap
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.task import Future
from tf2_msgs.msg import TFMessage

CONTROLLER_LOST_PATIENCE = 104
ECHOED = (AudioNoteVector, DockStatus, HazardDetectionVector, LightringLeds, TFMessage)
KEPT = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class WireServer(Node):
    """Callbacks and goals share one thread, so that a goal that waits for its cancel needs no lock."""

    def __init__(self, namespace: str) -> None:
        super().__init__("wire_server", namespace=namespace)
        self._canceled: Future[bool] = Future()
        self._actions = [
            ActionServer(
                self,
                NavigateToPose,
                "navigate_to_pose",
                self._navigate,
                goal_callback=self._judge,
                cancel_callback=self._cancel,
            ),
            ActionServer(self, ComputePathToPose, "compute_path_to_pose", self._plan),
            ActionServer(self, Dock, "dock", self._dock),
            ActionServer(self, Undock, "undock", self._undock),
            ActionServer(self, LedAnimation, "led_animation", self._animate),
        ]
        self.create_service(ClearEntireCostmap, "clear_entirely_global_costmap", lambda _, response: response)
        self.create_service(EStop, "e_stop", self._e_stop)
        for kind in ECHOED:
            echo = self.create_publisher(kind, f"{kind.__name__}_echo", KEPT)
            self.create_subscription(kind, kind.__name__, echo.publish, KEPT)

    def _judge(self, goal: Any) -> GoalResponse:
        return GoalResponse.REJECT if goal.pose.header.frame_id == "reject" else GoalResponse.ACCEPT

    def _cancel(self, _: Any) -> CancelResponse:
        self._canceled.set_result(True)
        return CancelResponse.ACCEPT

    async def _navigate(self, handle: Any) -> NavigateToPose.Result:
        pose = handle.request.pose
        feedback = NavigateToPose.Feedback(current_pose=pose, number_of_recoveries=-1, distance_remaining=1.5)
        feedback.navigation_time.sec = 3
        feedback.estimated_time_remaining.nanosec = 500
        handle.publish_feedback(feedback)
        if pose.header.frame_id == "abort":
            handle.abort()
            return NavigateToPose.Result(error_code=CONTROLLER_LOST_PATIENCE, error_msg="patience exceeded")
        if pose.header.frame_id == "wait":
            await self._canceled
            self._canceled = Future()
            handle.canceled()
            return NavigateToPose.Result()
        handle.succeed()
        return NavigateToPose.Result(error_msg=handle.request.behavior_tree)

    def _plan(self, handle: Any) -> ComputePathToPose.Result:
        handle.abort()
        result = ComputePathToPose.Result(error_code=ComputePathToPose.Result.GOAL_OCCUPIED)
        result.path.poses = [handle.request.start, handle.request.goal]
        result.planning_time.nanosec = 7
        return result

    def _dock(self, handle: Any) -> Dock.Result:
        handle.publish_feedback(Dock.Feedback(sees_dock=True))
        handle.succeed()
        return Dock.Result(is_docked=True)

    def _undock(self, handle: Any) -> Undock.Result:
        handle.succeed()
        return Undock.Result(is_docked=False)

    def _animate(self, handle: Any) -> LedAnimation.Result:
        handle.publish_feedback(LedAnimation.Feedback(remaining_runtime=handle.request.max_runtime))
        handle.succeed()
        result = LedAnimation.Result()
        result.runtime.sec = handle.request.lightring.leds[5].blue
        return result

    def _e_stop(self, request: EStop.Request, response: EStop.Response) -> EStop.Response:
        response.success, response.message = True, f"e-stop {request.e_stop_on}"
        return response


def main() -> None:
    """Serve below the namespace in the first argument until terminated."""
    rclpy.init()
    try:
        rclpy.spin(WireServer(sys.argv[1]))
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
