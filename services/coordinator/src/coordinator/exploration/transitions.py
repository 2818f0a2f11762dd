"""The modes of requirement C6, what each means, and which may follow which and why."""

from contracts.exploration import ExplorationMode

_M = ExplorationMode

SENTENCES: dict[ExplorationMode, str] = {
    _M.IDLE: "Nothing is explored.",
    _M.MODEL: "A language model chooses among the typed tools; each decision is checked against the newest scan.",
    _M.FRONTIERS: "Nav2 drives to the most worthwhile border of what is known.",
    _M.REACTIVE: "A careful wander by the laser alone.",
    _M.LISTENING: "Somebody speaks to the robot: it stands.",
    _M.RETURNING: "The robot drives home.",
}

_HOME = "all explored, out of time, or the model silent for too long"
_OVER = "cancelled, the emergency stop, another map, or nothing that moves it is taken"
_LISTEN = "somebody speaks to the robot"
_HEARD = "nobody says more: on as before"

TRANSITIONS: dict[ExplorationMode, dict[ExplorationMode, str]] = {
    _M.IDLE: {
        _M.MODEL: "begun",
        _M.FRONTIERS: "begun without a model",
        _M.REACTIVE: "begun by the laser alone",
    },
    _M.MODEL: {
        _M.FRONTIERS: "no answer for 10 s, refused three times in a row, nothing new to see, or nothing left to spend",
        _M.REACTIVE: "the same, and no frontier can be reached",
        _M.LISTENING: _LISTEN,
        _M.RETURNING: _HOME,
        _M.IDLE: _OVER,
    },
    _M.FRONTIERS: {
        _M.MODEL: "the model answers again, or one stretch was explored without it",
        _M.REACTIVE: "no frontier can be reached",
        _M.LISTENING: _LISTEN,
        _M.RETURNING: _HOME,
        _M.IDLE: _OVER,
    },
    _M.REACTIVE: {
        _M.MODEL: "the model answers again, or one stretch was explored without it",
        _M.FRONTIERS: "there is a frontier that can be reached",
        _M.LISTENING: _LISTEN,
        _M.RETURNING: _HOME,
        _M.IDLE: _OVER,
    },
    _M.LISTENING: {
        _M.MODEL: _HEARD,
        _M.FRONTIERS: _HEARD,
        _M.REACTIVE: _HEARD,
        _M.RETURNING: _HEARD,
        _M.IDLE: _OVER,
    },
    _M.RETURNING: {_M.LISTENING: _LISTEN, _M.IDLE: f"at home, or home cannot be reached; {_OVER}"},
}

ALLOWED: dict[ExplorationMode, frozenset[ExplorationMode]] = {one: frozenset(to) for one, to in TRANSITIONS.items()}


class ForbiddenModeError(RuntimeError):
    """The core would leave its table: a bug."""


def diagram() -> str:
    """The table as a Mermaid state diagram."""
    lines = ["stateDiagram-v2", "    [*] --> idle"]
    lines += [
        f"    {before.value} --> {after.value}: {why.replace(';', ' #59;')}"
        for before, to in TRANSITIONS.items()
        for after, why in to.items()
    ]
    return "\n".join(lines)
