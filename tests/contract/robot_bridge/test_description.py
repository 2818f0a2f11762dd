"""The body the bridge tells of, and what that body cannot do."""

import math
from pathlib import Path

import httpx
import pytest

from contracts.causes import Refusal
from contracts.description import RobotDescription
from contracts.topics import ROBOT_DESCRIPTION, ROBOT_STATE
from robot_bridge.settings import Settings
from support import fake_robot
from support.bridge_behaviour import Rig, running
from support.fake_robot import FakeRobot
from support.toy_robot import CAMERA_X_M, CAMERA_Z_M, FX, ToyRobot
from support.waiting import until

from .conftest import serving


async def test_the_body_is_told_as_the_settings_and_the_camera_have_it(tmp_path: Path) -> None:
    toy = ToyRobot()
    async with running(tmp_path, toy, FakeRobot(toy), footprint_radius_m=0.25, speed_m_s_max=0.5) as rig:
        told = RobotDescription.model_validate((await rig.client.get("/description")).json())
        await until(lambda: rig.bus.of(ROBOT_DESCRIPTION) != [])
        assert await rig.bus.last(ROBOT_DESCRIPTION) == told
    assert (told.footprint_radius_m, told.speed_m_s_max) == (0.25, 0.5)
    assert (told.camera.position_in_base.x, told.camera.position_in_base.z) == pytest.approx((CAMERA_X_M, CAMERA_Z_M))
    assert told.camera.hfov_rad == pytest.approx(2.0 * math.atan(125.0 / FX))


async def test_a_robot_whose_camera_is_not_known_is_not_described(tmp_path: Path) -> None:
    async with serving(Settings(state_dir=tmp_path), ToyRobot(silent={"rgb"})) as served, httpx.AsyncClient() as http:
        assert (await http.get(f"http://{served.address}/description")).status_code == 503
        assert served.bus.of(ROBOT_DESCRIPTION) == []


@pytest.mark.parametrize(
    ("path", "asked"),
    [("/drive", {"distance_m": 0.1, "speed_m_s": 0.6}), ("/rotate", {"angle_rad": 0.1, "speed_rad_s": 2.0})],
)
async def test_what_is_faster_than_the_base_can_is_refused(rig: Rig, path: str, asked: dict[str, float]) -> None:
    refused = await rig.client.post(path, json=asked | {"epoch": 0})
    assert (refused.status_code, refused.json()["code"]) == (422, Refusal.TOO_FAST)


async def test_a_faster_base_drives_faster(tmp_path: Path) -> None:
    toy = ToyRobot()
    async with running(tmp_path, toy, FakeRobot(toy), speed_m_s_max=0.5) as rig:
        await rig.client.post("/drive", json={"distance_m": 0.6, "speed_m_s": 0.45, "epoch": 0})
    assert max(linear_x for linear_x, _ in toy.velocities) > 0.4


async def test_a_camera_that_sleeps_is_described_as_it_was_last_known(tmp_path: Path) -> None:
    async with serving(Settings(state_dir=tmp_path), ToyRobot()) as awake:
        await until(lambda: awake.bus.of(ROBOT_DESCRIPTION) != [])
    async with serving(Settings(state_dir=tmp_path), ToyRobot(silent={"rgb"})) as asleep:
        await until(lambda: asleep.bus.of(ROBOT_DESCRIPTION) != [])
        assert asleep.bus.of(ROBOT_DESCRIPTION)[0] == awake.bus.of(ROBOT_DESCRIPTION)[0]


@pytest.mark.parametrize("stored", [b"", b"{", b'{"fx": 1}', b"\xff\x00"])
async def test_a_camera_that_cannot_be_read_is_none(tmp_path: Path, stored: bytes) -> None:
    (tmp_path / "camera.json").write_bytes(stored)
    async with serving(Settings(state_dir=tmp_path), ToyRobot(silent={"rgb"})) as served, httpx.AsyncClient() as http:
        assert (await http.get(f"http://{served.address}/description")).status_code == 503


async def test_a_camera_where_none_can_be_ends_nothing_and_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fake_robot, "CAMERA_Z_M", 244.0)
    async with serving(Settings(state_dir=tmp_path), ToyRobot()) as served, httpx.AsyncClient() as http:
        await until(lambda: served.bus.of(ROBOT_STATE) != [])
        answer = await http.get(f"http://{served.address}/description")
        assert (answer.status_code, served.bus.of(ROBOT_DESCRIPTION)) == (503, [])
        assert "no such camera" in answer.json()["detail"]
