"""Lifecycle nodes of Nav2 and of the localiser, by their real names: clients wait for ever for what is not there."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Final

import structlog
from lifecycle_msgs.msg import State, Transition
from lifecycle_msgs.srv import ChangeState, GetState
from rclpy.node import Node

log = structlog.get_logger()

LOCALISER: Final = ("amcl", "map_server")
"""Whoever localises has these: beside a real Nav2 too, the simulator publishes pose and map."""

Parameters = Mapping[str, float]


class LifecycleNode:
    """`active` is what a person set last; `ready` says whether it can be. `failed` = for good."""

    def __init__(self, node: Node, *, active: bool, ready: Callable[[], bool], parameters: Parameters) -> None:
        self.name = node.get_name()
        self.failed = False
        self._active = active
        self._ready = ready
        for name, value in parameters.items():
            node.declare_parameter(name, value)
        node.create_service(GetState, f"{self.name}/get_state", self._get)
        node.create_service(ChangeState, f"{self.name}/change_state", self._change)

    @property
    def active(self) -> bool:
        return self._active and not self.failed

    def _get(self, _: GetState.Request, response: GetState.Response) -> GetState.Response:
        response.current_state = (
            State(id=State.PRIMARY_STATE_ACTIVE, label="active")
            if self.active and self._ready()
            else State(id=State.PRIMARY_STATE_INACTIVE, label="inactive")
        )
        return response

    def _change(self, request: ChangeState.Request, response: ChangeState.Response) -> ChangeState.Response:
        wanted = {Transition.TRANSITION_ACTIVATE: True, Transition.TRANSITION_DEACTIVATE: False}
        to = wanted.get(request.transition.id)
        response.success = to is not None and to is not self._active and not self.failed
        if response.success and to is not None:
            self._active = to
            log.info("changed state", server=self.name, active=to)
        return response


def make_lifecycle(
    make_node: Callable[..., Node],
    names: tuple[str, ...],
    *,
    active: bool,
    ready: Callable[[], bool],
    parameters: Mapping[str, Parameters] | None = None,
) -> dict[str, LifecycleNode]:
    """One node a name; those with `parameters` serve them, under the names that a real one has."""
    given = parameters or {}
    make = partial(LifecycleNode, active=active, ready=ready)
    return {
        name: make(make_node(name, parameter_services=name in given), parameters=given.get(name, {})) for name in names
    }
