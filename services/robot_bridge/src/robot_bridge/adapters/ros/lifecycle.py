"""Is Nav2 really there? Its nodes' lifecycle, asked once a second, in the robot's thread."""

from typing import Any

from lifecycle_msgs.msg import State
from lifecycle_msgs.srv import GetState
from rclpy.action.client import ActionClient
from rclpy.node import Node

from mesh.clock import Clock
from mesh.latest_value import LatestValue
from robot_bridge.adapters.ros.goal_cancels import GoalCancels
from robot_bridge.settings import RosSettings

ANSWER_S_MAX = 2.5


class Nav2Watch:
    """Says 'active' once every node answers so, and no cancel of its goals is owed: of those that an earlier process
    left, or that a stop found out of reach."""

    def __init__(
        self,
        node: Node,
        ros: RosSettings,
        missing: LatestValue[str],
        clock: Clock,
        navigate: ActionClient,
        *,
        cancel: GoalCancels,
    ) -> None:
        self._missing = missing
        self._clock = clock
        self._navigate = navigate
        self._cancel = cancel
        self._clients = {name: node.create_client(GetState, f"{name}/get_state") for name in ros.nav2_lifecycle_nodes}
        self._heard_s: dict[str, float] = {}

    def poll(self) -> None:
        """Asks every node anew and judges by what was heard lately."""
        now_s = self._clock.now_s()
        for name, client in self._clients.items():
            if client.service_is_ready():
                future = client.call_async(GetState.Request())
                future.add_done_callback(lambda done, name=name: self._heard(name, done))
        self._judge(now_s)

    def _heard(self, name: str, done: Any) -> None:
        answer = done.result()
        if answer is not None and answer.current_state.id == State.PRIMARY_STATE_ACTIVE:
            self._heard_s[name] = self._clock.now_s()
        else:
            self._heard_s.pop(name, None)
        self._judge(self._clock.now_s())

    def _judge(self, now_s: float) -> None:
        silent = [n for n in self._clients if now_s - self._heard_s.get(n, float("-inf")) > ANSWER_S_MAX]
        missing = ""
        if silent:
            missing = f"{', '.join(silent)} not active"
        elif not self._navigate.server_is_ready():
            missing = "its action is not there"
        elif self._cancel.late():
            missing = "it has not answered yet that its goals are cancelled"
        self._missing.put(missing, now_s)
