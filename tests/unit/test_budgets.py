"""Nobody waits less than what it calls may take, by the settings of both: else work goes on that its caller gave up."""

import pytest

from atom_cli.services import STARTING_S
from contracts.robot import GOAL_ANSWER_S
from coordinator.adapters.robot_bridge import MARGIN_S
from coordinator.settings import Settings as Coordinator
from inference.settings import Settings as Inference
from robot_bridge.navigation.goal_executor import CANCEL_S_MAX
from robot_bridge.settings import Settings as Bridge
from ui.settings import Settings as Ui

BRIDGE, COORDINATOR, INFERENCE, UI = Bridge(), Coordinator(), Inference(), Ui()

GOAL_S = (
    BRIDGE.nav2_active_wait_s
    + CANCEL_S_MAX
    + BRIDGE.costmap_timeout_s
    + BRIDGE.fresh_scan_wait_s_max
    + BRIDGE.preflight_s_max
    + BRIDGE.nav2_timeout_s
)
"""Until POST /navigation/goals answers: Nav2 awake, the goal before ended, costmaps, paths, and Nav2's word."""
PARSED_S = COORDINATOR.parse_timeout_s + 2 * COORDINATOR.recall_timeout_s
"""A command read, and memory asked what it knows."""
ANSWERED_S = COORDINATOR.call_timeout_s + COORDINATOR.reason_timeout_s

WAITS = {
    "the coordinator and the page for a goal to be taken": (GOAL_ANSWER_S, GOAL_S),
    "the page for a path": (UI.call_timeout_s, BRIDGE.preflight_s_max),
    "the coordinator for the dock": (COORDINATOR.dock_timeout_s, BRIDGE.dock_timeout_s),
    "the coordinator to leave the dock": (COORDINATOR.undock_timeout_s, BRIDGE.dock_timeout_s),
    "the page for the dock": (UI.dock_timeout_s, BRIDGE.dock_timeout_s),
    "the coordinator for a motion that is blocked at the last moment": (MARGIN_S, BRIDGE.gains.blocked_s_max),
    "a mission for a call that has its own limit": (COORDINATOR.call_margin_s, MARGIN_S),
    "the coordinator for a command to be read": (COORDINATOR.parse_timeout_s, INFERENCE.parse_deadline_s),
    "the coordinator for an answer's words": (COORDINATOR.reason_timeout_s, INFERENCE.reason_deadline_s),
    "the coordinator for the votes": (
        COORDINATOR.validate_timeout_s,
        INFERENCE.validate_frame_wait_s + INFERENCE.vlm_deadline_s,
    ),
    "the page for a command": (UI.command_timeout_s, PARSED_S),
    "the page for an answer": (UI.command_timeout_s, ANSWERED_S),
    "the command line for a command": (STARTING_S, PARSED_S),
}


@pytest.mark.parametrize("who", WAITS)
def test_a_caller_waits_longer_than_what_it_calls_may_take(who: str) -> None:
    waits_s, takes_s = WAITS[who]
    assert waits_s > takes_s
