"""Passes navigation goals on to Nav2 under names of its own, so that "Nav2" can be killed without the robot.

The bridge knows `relay/navigate_to_pose` and the lifecycle node `relay` only; ended by SIGKILL it is gone as a crashed
Nav2 is: its action, its services and its answers.
"""

import threading
from typing import Any

import rclpy
from lifecycle_msgs.msg import State
from lifecycle_msgs.srv import GetState
from nav2_msgs.action import NavigateToPose
from rclpy.action import ActionClient, ActionServer, CancelResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from mesh.dds import use_mesh_profile

POLL_S = 0.05


class Relay:
    def __init__(self, node: Node) -> None:
        group = ReentrantCallbackGroup()
        self._client = ActionClient(node, NavigateToPose, "navigate_to_pose", callback_group=group)
        self._pause = threading.Event()
        self._server = ActionServer(
            node,
            NavigateToPose,
            "relay/navigate_to_pose",
            self._run,
            callback_group=group,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )
        node.create_service(GetState, "relay/get_state", self._state, callback_group=group)

    def _state(self, _: GetState.Request, response: GetState.Response) -> GetState.Response:
        there = self._client.server_is_ready()
        response.current_state.id = State.PRIMARY_STATE_ACTIVE if there else State.PRIMARY_STATE_INACTIVE
        return response

    def _run(self, handle: Any) -> NavigateToPose.Result:
        sending = self._client.send_goal_async(
            handle.request,
            feedback_callback=lambda m: handle.publish_feedback(m.feedback) if handle.is_active else None,
        )
        goal = self._wait(sending)
        if not goal.accepted:
            handle.abort()
            return NavigateToPose.Result()
        ending = goal.get_result_async()
        asked = False
        while not ending.done():
            if handle.is_cancel_requested and not asked:
                goal.cancel_goal_async()
                asked = True
            self._pause.wait(POLL_S)
        ended = ending.result()
        {4: handle.succeed, 5: handle.canceled}.get(ended.status, handle.abort)()
        return ended.result

    def _wait(self, future: Any) -> Any:
        while not future.done():
            self._pause.wait(POLL_S)
        return future.result()


def main() -> None:
    use_mesh_profile()
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = Node("nav2_relay", enable_rosout=False, start_parameter_services=False)
    relay = Relay(node)
    executor = MultiThreadedExecutor(4)
    executor.add_node(node)
    executor.spin()
    del relay


if __name__ == "__main__":
    main()
