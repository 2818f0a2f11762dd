"""Bad input gets a clear problem from the running mesh, and changes nothing."""

from typing import Any

import pytest

from support.mesh_run import MeshRun

HUGE = "x" * 20_000_000


@pytest.fixture(autouse=True)
def begin_at_rest(mesh: MeshRun) -> None:
    mesh.rested()


@pytest.mark.parametrize(
    ("service", "method", "path", "body", "status"),
    [
        ("coordinator", "POST", "/missions", {"command": ""}, 422),
        ("coordinator", "POST", "/missions", {"command": "find the blorp"}, 422),
        ("coordinator", "POST", "/missions", "not an object", 422),
        ("coordinator", "POST", "/missions", {"command": HUGE}, 413),
        ("robot_bridge", "POST", "/velocity", {"twist": {"linear_x": "fast"}}, 422),
        ("robot_bridge", "POST", "/velocity", {"source": HUGE}, 413),
        ("robot_bridge", "GET", "/navigation/goals/unknown", None, 404),
        ("robot_bridge", "DELETE", "/navigation/goals/unknown", None, 404),
        (
            "robot_bridge",
            "POST",
            "/navigation/goals",
            {"candidates": [{"pose": {"x": 900.0, "y": 0.0, "yaw": 0.0}}], "epoch": -1},
            422,
        ),
        ("memory", "POST", "/observations", {"observations": []}, 422),
        ("memory", "POST", "/recall", {"target": HUGE}, 413),
        ("inference", "POST", "/parse-task", {"command": ""}, 422),
    ],
)
def test_bad_input_is_a_clear_problem_and_changes_nothing(
    mesh: MeshRun, service: str, method: str, path: str, body: Any, status: int
) -> None:
    before = mesh.truth()["path_length_m"]
    answer = mesh.http.request(method, mesh.url(service, path), json=body)
    assert answer.status_code == status
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.json()["title"]
    assert mesh.get("coordinator", "/state")["state"] == "IDLE"
    assert mesh.truth()["path_length_m"] == pytest.approx(before, abs=0.01)


def test_a_goal_outside_the_map_is_refused(mesh: MeshRun) -> None:
    epoch = mesh.get("robot_bridge", "/emergency-stop")["epoch"]
    answer = mesh.post(
        "robot_bridge",
        "/navigation/goals",
        {"candidates": [{"pose": {"x": 900.0, "y": 0.0, "yaw": 0.0}}], "epoch": epoch},
    )
    assert answer.status_code == 422
    assert "map" in answer.json()["detail"]
