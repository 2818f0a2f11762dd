"""A robot that is started on its dock: asleep, and not localised."""

from pathlib import Path

import pytest

from contracts.problem import DependencyState, Readiness
from contracts.topics import ROBOT_STATE
from robot_bridge.settings import Settings
from support.toy_robot import DOCK, ToyRobot
from support.waiting import until, until_true

from .conftest import serving
from .test_connections import client

DOCKED = (DOCK.x, DOCK.y)


def docked(*silent: str) -> ToyRobot:
    toy = ToyRobot(silent=set(silent))
    toy.put_on_dock()
    return toy


async def test_a_localiser_without_a_pose_is_told_where_the_dock_is(tmp_path: Path) -> None:
    async with serving(Settings(state_dir=tmp_path, dock_pose=DOCK), docked("pose")) as served:
        await until(lambda: served.toy.initial_poses == [DOCKED])
        await until(lambda: served.bus.of(ROBOT_STATE)[-1].pose is not None)


@pytest.mark.parametrize(
    ("settings", "toy"),
    [
        ({"dock_pose": DOCK}, docked()),
        ({"dock_pose": DOCK}, ToyRobot(silent={"pose"})),
        ({}, docked("pose")),
        ({"dock_pose": DOCK, "initial_pose_from_dock": False}, docked("pose")),
    ],
    ids=["localised", "not docked", "no dock known", "not wanted"],
)
async def test_else_it_is_told_nothing(tmp_path: Path, settings: dict[str, object], toy: ToyRobot) -> None:
    async with serving(Settings(state_dir=tmp_path, **settings), toy) as served:  # type: ignore[arg-type]
        await until(lambda: len(served.bus.of(ROBOT_STATE)) > 12)
        assert served.toy.initial_poses == []


async def test_a_docked_robot_without_lidar_and_camera_is_said_to_be_asleep(tmp_path: Path) -> None:
    async with serving(Settings(state_dir=tmp_path), docked("scan", "rgb", "depth")) as served, client(served) as http:

        async def told() -> dict[str, tuple[DependencyState, str]]:
            ready = Readiness.model_validate_json((await http.get("/ready")).content)
            return {each.name: (each.state, each.detail) for each in ready.dependencies}

        async def asleep() -> bool:
            return "power_saver" in await told()

        await until_true(asleep)
        state, detail = (await told())["power_saver"]
        assert state is DependencyState.WARNING
        assert "docked and asleep" in detail
        assert (await told())["scan"][0] is DependencyState.NOT_READY
        served.toy.silent.clear()

        async def awake() -> bool:
            return not await asleep()

        await until_true(awake)
