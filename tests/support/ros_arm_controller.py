"""One of an arm's controllers as a real ROS 2 node of its own, which comes and goes. Its goals end when cancelled."""

import threading
from typing import Any

import rclpy
from rclpy.action import ActionServer, CancelResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

STEP_S = 0.02


class RosArmController:
    """`open()` and `close()`; `started` and `cancelled` count its goals, `refuses` is there to set."""

    def __init__(self, action: Any, name: str) -> None:
        self._action = action
        self._name = name
        self._closing = threading.Event()
        self.started = 0
        self.cancelled = 0
        self.refuses = False
        """Whether a goal that is to be cancelled goes on."""

    def open(self) -> None:
        self._context = rclpy.Context()
        rclpy.init(context=self._context, signal_handler_options=SignalHandlerOptions.NO)
        self._node = Node("controller", context=self._context, start_parameter_services=False, enable_rosout=False)
        self._server = ActionServer(
            self._node,
            self._action,
            self._name,
            self._run,
            callback_group=ReentrantCallbackGroup(),
            cancel_callback=lambda _: CancelResponse.REJECT if self.refuses else CancelResponse.ACCEPT,
        )
        self._executor = MultiThreadedExecutor(4, context=self._context)
        self._executor.add_node(self._node)
        self._thread = threading.Thread(target=self._spin, name="controller")
        self._thread.start()

    def close(self) -> None:
        self._closing.set()
        self._thread.join()
        self._executor._executor.shutdown(wait=True)  # its pool: a goal that still runs ends before its server is gone
        self._executor.shutdown()
        self._server.destroy()
        self._node.destroy_node()
        self._context.try_shutdown()
        self._context.destroy()

    def _spin(self) -> None:
        while not self._closing.is_set():
            self._executor.spin_once(timeout_sec=0.2)

    def _run(self, handle: Any) -> Any:
        self.started += 1
        while not handle.is_cancel_requested:
            if self._closing.wait(STEP_S):
                handle.abort()
                return self._action.Result()
        self.cancelled += 1
        handle.canceled()
        return self._action.Result()
