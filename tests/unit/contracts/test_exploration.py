"""The typed tools of an exploration: what is read as a decision, and what is refused."""

import json
import math
from typing import Any

import jsonschema_rs
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from contracts.exploration import (
    DECISIONS,
    STEP_M_MAX,
    TOOLS,
    CheckPathClear,
    MoveToward,
    NavigateToGoal,
    ObserveScene,
    ReportDiscovery,
    RotateBy,
    StopRobot,
    function_tools,
)

GOOD = [
    ({"tool": "move_toward", "bearing_rad": -0.5, "distance_m": 1.5}, MoveToward(bearing_rad=-0.5, distance_m=1.5)),
    ({"tool": "navigate_to_goal", "x_m": 1.0, "y_m": -2.0}, NavigateToGoal(x_m=1.0, y_m=-2.0)),
    ({"tool": "navigate_to_goal", "frontier": 3}, NavigateToGoal(frontier=3)),
    ({"tool": "rotate", "angle_rad": math.pi}, RotateBy(angle_rad=math.pi)),
    ({"tool": "stop_robot"}, StopRobot()),
    ({"tool": "observe_scene"}, ObserveScene()),
    ({"tool": "check_path_clear", "bearing_rad": 0, "distance_m": 1}, CheckPathClear(bearing_rad=0.0, distance_m=1.0)),
    ({"tool": "report_discovery", "label": "cup", "note": "red"}, ReportDiscovery(label="cup", note="red")),
]
BAD: list[dict[str, Any]] = [
    {},
    {"tool": "cmd_vel", "linear_x": 0.3},
    {"tool": "move_toward", "bearing_rad": 0.0},
    {"tool": "move_toward", "bearing_rad": 0.0, "distance_m": 0.0},
    {"tool": "move_toward", "bearing_rad": 0.0, "distance_m": -1.0},
    {"tool": "move_toward", "bearing_rad": 0.0, "distance_m": STEP_M_MAX + 0.01},
    {"tool": "move_toward", "bearing_rad": 3.2, "distance_m": 1.0},
    {"tool": "move_toward", "bearing_rad": math.nan, "distance_m": 1.0},
    {"tool": "move_toward", "bearing_rad": 0.0, "distance_m": math.inf},
    {"tool": "move_toward", "bearing_rad": 0.0, "distance_m": 1.0, "speed_m_s": 2.0},
    {"tool": "rotate", "angle_rad": 1e300},
    {"tool": "navigate_to_goal"},
    {"tool": "navigate_to_goal", "x_m": 1.0},
    {"tool": "navigate_to_goal", "x_m": 1.0, "y_m": 1.0, "frontier": 1},
    {"tool": "navigate_to_goal", "x_m": 1e9, "y_m": 1.0},
    {"tool": "navigate_to_goal", "frontier": 0},
    {"tool": "stop_robot", "reason": "no"},
    {"tool": "report_discovery", "label": ""},
    {"tool": "report_discovery", "label": "cup\nnew line"},
    {"tool": "report_discovery", "label": "cup", "note": "x" * 201},
]


@pytest.mark.parametrize(("given_", "read"), GOOD, ids=str)
def test_a_decision_is_read_as_the_tool_it_names(given_: dict[str, Any], read: object) -> None:
    assert DECISIONS.validate_json(json.dumps(given_)) == read


@pytest.mark.parametrize("given_", BAD, ids=str)
def test_what_is_no_tool_or_beyond_its_bounds_is_refused(given_: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        DECISIONS.validate_python(given_)


NAMES = st.sampled_from(["tool", "bearing_rad", "distance_m", "x_m", "angle_rad", "frontier"])
LEAVES = st.none() | st.booleans() | st.floats() | st.text(max_size=20) | st.just("move_toward")
ANYTHING = st.recursive(LEAVES, lambda one: st.lists(one, max_size=3) | st.dictionaries(NAMES, one, max_size=5))


@given(ANYTHING)
def test_nothing_else_than_a_validation_error_comes_of_anything_at_all(anything: object) -> None:
    try:
        decision = DECISIONS.validate_python(anything)
    except ValidationError:
        return
    assert isinstance(decision, TOOLS)


def test_the_function_tools_describe_what_is_read_and_name_no_velocity() -> None:
    tools = {one["function"]["name"]: one["function"]["parameters"] for one in function_tools()}
    assert set(tools) == {tool.model_fields["tool"].default for tool in TOOLS}
    for given_, _ in GOOD:
        parameters = {name: value for name, value in given_.items() if name != "tool"}
        assert jsonschema_rs.is_valid(tools[given_["tool"]], parameters)
    text = json.dumps(function_tools())
    assert "m/s" not in text
    assert "rad/s" not in text
