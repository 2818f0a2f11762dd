"""Nav2's error codes that this stand-in for Nav2 can answer with (Jazzy: planner 2xx, controller 1xx)."""

from enum import IntEnum


class Code(IntEnum):
    """`error_code` of NavigateToPose and ComputePathToPose; NavigateToPose passes its sub-tasks' codes through."""

    NONE = 0
    PATIENCE_EXCEEDED = 104
    """The way stayed blocked for longer than the controller is willing to wait."""
    FAILED_TO_MAKE_PROGRESS = 105
    """Velocity was asked for and the robot did not move: stopped, held, or stuck."""
    UNKNOWN = 200
    TF_ERROR = 202
    START_OUTSIDE_MAP = 203
    GOAL_OUTSIDE_MAP = 204
    START_OCCUPIED = 205
    GOAL_OCCUPIED = 206
    NO_VALID_PATH = 208


class NavigationError(Exception):
    """A goal that cannot be planned or driven; `code` says why in Nav2's numbers."""

    def __init__(self, code: Code, detail: str) -> None:
        super().__init__(detail)
        self.code = code
        self.detail = detail
