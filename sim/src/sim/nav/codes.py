"""Nav2's error codes that this stand-in for Nav2 can answer with (Jazzy: planner 2xx, controller 1xx)."""

from enum import IntEnum


class Code(IntEnum):
    """`error_code` of NavigateToPose and ComputePathToPose; NavigateToPose passes its sub-tasks' codes through."""

    NONE = 0
    """Of an abort: preempted by another client, or a server that did not answer the tree in time."""
    PATIENCE_EXCEEDED = 104
    """The way stayed blocked for longer than the controller is willing to wait."""
    FAILED_TO_MAKE_PROGRESS = 105
    """Velocity was asked for and the robot did not move: stopped, held, or stuck."""
    UNKNOWN = 200
    TF_ERROR = 202
    START_OUTSIDE_MAP = 203
    GOAL_OUTSIDE_MAP = 204
    GOAL_OCCUPIED = 206
    """Only from a planner without a tolerance."""
    NO_VALID_PATH = 208
    """Also where the robot itself stands in an obstacle: 205 (START_OCCUPIED) was never seen of the real one."""


class NavigationError(Exception):
    """A goal that cannot be planned or driven; `code` says why in Nav2's numbers."""

    def __init__(self, code: Code, detail: str) -> None:
        super().__init__(detail)
        self.code = code
        self.detail = detail
