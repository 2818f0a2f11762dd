"""The life of a navigation goal, as data: which state may follow which, and what an error code means. Pure."""

from contracts.causes import GoalCause
from contracts.robot import Goal, GoalStatus
from robot_bridge.ports import GoalEnd

ALLOWED: dict[GoalStatus, frozenset[GoalStatus]] = {
    GoalStatus.PENDING: frozenset(
        {GoalStatus.EXECUTING, GoalStatus.REJECTED, GoalStatus.CANCELED, GoalStatus.ABORTED, GoalStatus.TIMED_OUT}
    ),
    GoalStatus.EXECUTING: frozenset(
        {GoalStatus.SUCCEEDED, GoalStatus.CANCELED, GoalStatus.ABORTED, GoalStatus.TIMED_OUT}
    ),
    GoalStatus.SUCCEEDED: frozenset(),
    GoalStatus.CANCELED: frozenset(),
    GoalStatus.ABORTED: frozenset(),
    GoalStatus.REJECTED: frozenset(),
    GoalStatus.TIMED_OUT: frozenset(),
}
"""What may follow what. An empty set is an ending."""

ERROR_NAMES: dict[int, str] = {
    0: "",
    100: "CONTROLLER_UNKNOWN",
    101: "INVALID_CONTROLLER",
    102: "CONTROLLER_TF_ERROR",
    103: "INVALID_PATH",
    104: "PATIENCE_EXCEEDED",
    105: "FAILED_TO_MAKE_PROGRESS",
    106: "NO_VALID_CONTROL",
    107: "CONTROLLER_TIMED_OUT",
    200: "PLANNER_UNKNOWN",
    201: "INVALID_PLANNER",
    202: "PLANNER_TF_ERROR",
    203: "START_OUTSIDE_MAP",
    204: "GOAL_OUTSIDE_MAP",
    205: "START_OCCUPIED",
    206: "GOAL_OCCUPIED",
    207: "TIMEOUT",
    208: "NO_VALID_PATH",
    9000: "NAVIGATOR_UNKNOWN",
    9001: "FAILED_TO_LOAD_BEHAVIOR_TREE",
    9002: "NAVIGATOR_TF_ERROR",
    9003: "NAVIGATOR_TIMEOUT",
}
"""Nav2's codes (Jazzy): 1xx from the controller under way, 2xx from the planner; 9xxx from Kilted's navigator."""

SERVERS: dict[range, str] = {
    range(100, 200): "CONTROLLER",
    range(200, 300): "PLANNER",
    range(300, 400): "PLANNER_THROUGH_POSES",
    range(400, 500): "ROUTE",
    range(500, 600): "SMOOTHER",
    range(600, 700): "WAYPOINTS",
    range(700, 800): "BEHAVIOR",
    range(900, 1000): "DOCKING",
    range(9000, 10000): "NAVIGATOR",
}
"""Whose a code is that has no name here: Nav2 gives each server a range of its own."""


START_OCCUPIED = 205
NO_VALID_PATH = 208

RETRIES: dict[int, int] = {
    **dict.fromkeys((0, 104, 105, 106), 2),
    **dict.fromkeys((100, 102, 103, 107, 200, 202, 205, 206, 207, 208, 9000, 9002, 9003), 1),
}  # fmt: skip
"""How often a goal that Nav2 aborted under way is asked for again, by Nav2's code; with no other code. Twice where the
controller lost patience, made no progress or found no way on, and without a code: Nav2's tree waits 20 ms for its
servers, which a busy computer misses. Once where a ghost in the costmap or a late transform may be to blame"""


def retries(end: GoalEnd) -> int:
    return RETRIES.get(end.error_code, 0) if end.status is GoalStatus.ABORTED else 0


def cause_of(end: GoalEnd) -> GoalCause:
    silent = end.status is GoalStatus.ABORTED and end.error_code == 0
    return GoalCause.NAV2_SILENT if silent else GoalCause.NAV2


def says_nothing_of_the_goal(code: int) -> bool:
    """The planner's trouble is with the start, the transforms or itself: another goal would meet the same."""
    return code in {200, 201, 202, 203, 205, 207}


def is_over(status: GoalStatus) -> bool:
    return not ALLOWED[status]


def error_name(code: int) -> str:
    server = next((name for codes, name in SERVERS.items() if code in codes), "NAV2")
    return ERROR_NAMES.get(code, f"{server}_{code}")


def with_status(
    goal: Goal,
    status: GoalStatus,
    *,
    stamp_s: float,
    cause: GoalCause | None = None,
    error_code: int = 0,
    error_msg: str = "",
    distance_remaining_m: float | None = None,
) -> Goal:
    """The goal in its next state; raises `ValueError` for a step the table does not have."""
    if status != goal.status and status not in ALLOWED[goal.status]:
        raise ValueError(f"{goal.status} cannot become {status}")
    message = error_msg or error_name(error_code) or (cause.sentence if cause is not None else "")
    return goal.model_copy(
        update={
            "status": status,
            "stamp_s": stamp_s,
            "cause": cause,
            "error_code": error_code,
            "error_name": error_name(error_code),
            "error_msg": message,
            "distance_remaining_m": goal.distance_remaining_m if distance_remaining_m is None else distance_remaining_m,
        }
    )
