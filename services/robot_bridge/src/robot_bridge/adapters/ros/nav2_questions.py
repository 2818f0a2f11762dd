"""What the doctor asks Nav2: the state of its nodes, and the parameters that decide how well it gets there."""

from collections.abc import Callable
from typing import Any

from lifecycle_msgs.srv import GetState
from rcl_interfaces.msg import ParameterType, ParameterValue
from rcl_interfaces.srv import GetParameters
from rclpy.node import Node

PLUGINS = {
    "controller_server": ("goal_checker_plugins", "xy_goal_tolerance"),
    "planner_server": ("planner_plugins", "tolerance"),
}
"""Of its nodes: the parameter that names the plugins, and what each plugin is asked for."""
PLAIN = {"bt_navigator": ("default_server_timeout",)}


class Nav2Questions:
    """Answers come while the node is spun; who does not answer leaves no trace."""

    def __init__(self, node: Node, lifecycle_nodes: tuple[str, ...]) -> None:
        self._node = node
        self.lifecycle = dict.fromkeys(lifecycle_nodes, "")
        self.parameters: dict[str, float] = {}
        self._asked: set[str] = set()
        self._states = {name: node.create_client(GetState, f"{name}/get_state") for name in lifecycle_nodes}
        self._clients = {
            name: node.create_client(GetParameters, f"{name}/get_parameters") for name in (*PLUGINS, *PLAIN)
        }

    def ask(self) -> None:
        """Each server once, when it is there: call it as long as the node is spun, a busy machine finds some late."""
        for name, client in self._states.items():
            if self._first(client):
                self._call(client, GetState.Request(), lambda answer, name=name: self._heard_state(name, answer))
        for name, (plugins, wanted) in PLUGINS.items():
            if self._first(self._clients[name]):
                self._get(
                    name, [plugins], lambda values, name=name, wanted=wanted: self._ask_plugins(name, wanted, values)
                )
        for name, wanted in PLAIN.items():
            if self._first(self._clients[name]):
                self._get(name, list(wanted), lambda values, name=name, wanted=wanted: self._keep(name, wanted, values))

    def _first(self, client: Any) -> bool:
        if client.srv_name in self._asked or not client.service_is_ready():
            return False
        self._asked.add(client.srv_name)
        return True

    def _heard_state(self, name: str, answer: Any) -> None:
        self.lifecycle[name] = answer.current_state.label

    def _ask_plugins(self, name: str, wanted: str, values: list[ParameterValue]) -> None:
        names = tuple(f"{plugin}.{wanted}" for value in values for plugin in value.string_array_value)
        if names:
            self._get(name, list(names), lambda found: self._keep(name, names, found))

    def _keep(self, node: str, names: tuple[str, ...], values: list[ParameterValue]) -> None:
        for name, value in zip(names, values, strict=False):
            if value.type == ParameterType.PARAMETER_DOUBLE:
                self.parameters[f"{node}.{name}"] = value.double_value
            elif value.type == ParameterType.PARAMETER_INTEGER:
                self.parameters[f"{node}.{name}"] = float(value.integer_value)

    def _get(self, node: str, names: list[str], then: Callable[[list[ParameterValue]], None]) -> None:
        self._call(self._clients[node], GetParameters.Request(names=names), lambda answer: then(list(answer.values)))

    def _call(self, client: Any, request: Any, then: Callable[[Any], None]) -> None:
        if client.service_is_ready():
            client.call_async(request).add_done_callback(lambda done: then(done.result()))
