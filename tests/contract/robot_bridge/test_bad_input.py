"""Whatever is wrong with a request is said in problem+json, and changes nothing."""

from collections.abc import AsyncIterator
from typing import Any

import httpx
import pytest

from contracts.problem import Problem
from contracts.robot import NavigationState
from contracts.topics import ROBOT_STATE
from support.bridge_behaviour import INSIDE, Rig
from support.waiting import until

BOX = {"bbox_xyxy": [10, 10, 50, 50], "image_width_px": 250, "image_height_px": 250}
GOAL = {"candidates": [{"pose": INSIDE}], "epoch": 0}

BAD: list[tuple[str, str, dict[str, Any], int]] = [
    ("POST", "/velocity", {}, 422),
    ("POST", "/velocity", {"twist": {"linear_x": "fast"}, "source": "t", "epoch": 0}, 422),
    ("POST", "/velocity", {"twist": {"linear_x": 99.0}, "source": "t", "epoch": 0}, 422),
    ("POST", "/velocity", {"twist": {}, "source": "t", "epoch": 3}, 409),
    ("POST", "/velocity", {"twist": {}, "source": "t", "epoch": 0, "session_id": "gone"}, 409),
    ("POST", "/rotate", {"angle_rad": 99.0, "epoch": 0}, 422),
    ("POST", "/rotate", {"angle_rad": 1.0, "epoch": 3}, 409),
    ("POST", "/rotate", {"angle_rad": 1.0, "epoch": 0, "session_id": "gone"}, 409),
    ("POST", "/drive", {"distance_m": 0.2, "epoch": 0, "surprise": 1}, 422),
    ("POST", "/drive", {"distance_m": -0.2, "epoch": 0}, 409),
    ("PUT", "/motion/gains", {"heading_kp": 1.0}, 422),
    ("POST", "/depth", BOX | {"bbox_xyxy": [50, 50, 10, 10]}, 422),
    ("POST", "/depth", BOX | {"bbox_xyxy": [900, 900, 950, 950]}, 422),
    ("POST", "/localize", BOX, 422),
    ("POST", "/depth", BOX | {"image_width_px": 0}, 422),
    ("POST", "/navigation/goals", {"candidates": [{"pose": {"x": 1.0}}], "epoch": 0}, 422),
    ("POST", "/navigation/goals", GOAL | {"candidates": [{"pose": {"x": 100.0, "y": 3.0, "yaw": 0.0}}]}, 422),
    ("POST", "/navigation/goals", GOAL | {"candidates": [{"pose": {"x": 7.5, "y": 5.5, "yaw": 0.0}}]}, 422),
    ("POST", "/navigation/goals", GOAL | {"epoch": 3}, 409),
    ("POST", "/navigation/goals", GOAL | {"session_id": "gone"}, 409),
    ("POST", "/navigation/path", {"goal": {"x": -3.0, "y": 0.0, "yaw": 0.0}}, 422),
    ("GET", "/navigation/goals/unknown", {}, 404),
    ("DELETE", "/navigation/goals/unknown", {}, 404),
    ("POST", "/dock?session_id=gone", {}, 409),
    ("GET", "/camera/frame?wait_s=99", {}, 422),
    ("GET", "/camera/frame?after=nan", {}, 422),
    ("POST", "/recordings", {"name": "../../etc"}, 422),
    ("POST", "/recordings", {"seconds_max": -1}, 422),
    ("GET", "/recordings/unknown", {}, 404),
    ("GET", "/recordings/..%2F..%2Fstop.json/file", {}, 404),
    ("POST", "/recordings/unknown/stop", {}, 404),
    ("DELETE", "/recordings/unknown", {}, 404),
    ("POST", "/navigation/goals", GOAL | {"ring_radius_m": 99.0}, 422),
    ("POST", "/navigation/goals", GOAL | {"candidates": []}, 422),
    ("POST", "/navigation/path", {"goal": INSIDE, "ring_radius_m": -1.0}, 422),
    ("POST", "/dock", {}, 409),
    ("POST", "/undock", {}, 409),
    ("GET", "/nowhere", {}, 404),
    ("PUT", "/velocity", {}, 405),
]


def problem(response: httpx.Response) -> Problem:
    assert response.headers["content-type"] == "application/problem+json"
    return Problem.model_validate_json(response.content)


@pytest.mark.parametrize(("method", "path", "body", "status"), BAD)
async def test_bad_requests_are_named_and_move_nothing(
    rig: Rig, method: str, path: str, body: dict[str, Any], status: int
) -> None:
    response = await rig.client.request(method, path, json=body or None)
    assert response.status_code == status
    assert problem(response).status == status
    assert rig.toy.at_rest
    assert not rig.toy.goals


@pytest.mark.parametrize("path", ["/velocity", "/rotate", "/drive", "/depth", "/localize", "/navigation/goals"])
async def test_a_body_that_is_no_json_is_malformed(rig: Rig, path: str) -> None:
    response = await rig.client.post(path, content=b'{"epoch": ', headers={"content-type": "application/json"})
    assert problem(response).status == 422


@pytest.mark.parametrize("path", ["/velocity", "/navigation/goals", "/emergency-stop/reset"])
async def test_a_20_mb_body_is_refused_before_it_is_read(rig: Rig, path: str) -> None:
    response = await rig.client.post(path, content=b" " * 20_000_000)
    assert problem(response).status == 413
    assert not (await rig.client.get("/emergency-stop")).json()["latched"]


async def test_a_goal_without_an_active_nav2_names_nav2(rig: Rig) -> None:
    rig.toy.navigation = "is_inactive"
    await until(lambda: rig.bus.of(ROBOT_STATE)[-1].navigation is NavigationState.INACTIVE)
    response = await rig.goal()
    assert problem(response).status == 503
    assert "nav2: bt_navigator not active" in problem(response).detail


async def test_a_silent_camera_is_named(rig: Rig) -> None:
    rig.toy.silent.add("rgb")
    newest = (await rig.client.get("/camera/frame")).headers["x-stamp-s"]
    response = await rig.client.get("/camera/frame", params={"after": newest, "wait_s": 3})
    assert problem(response).detail == "rgb: the camera is silent"


async def chunks() -> AsyncIterator[bytes]:
    for _ in range(40):
        yield b" " * 10_000


async def test_an_undeclared_length_is_counted_too(rig: Rig) -> None:
    response = await rig.client.post("/rotate", content=chunks())
    assert problem(response).status == 413
