"""Which home the robot is in, told to everybody; and what it learned in another one."""

from pathlib import Path

from contracts.robot import KnownMap, Map, RobotState
from contracts.topics import ROBOT_STATE
from geometry.grids import decode
from robot_bridge.sensing.sensor_readings import Grid
from support.bridge_behaviour import running
from support.fake_robot import FakeRobot
from support.homes import home
from support.toy_robot import ToyRobot
from support.waiting import until


def grid_of(seed: int) -> Grid:
    grid = home(seed)
    return Grid(grid.cells, grid.resolution_m, grid.origin)


async def test_the_map_says_which_home_it_is_of_and_so_does_every_state(tmp_path: Path) -> None:
    robot = FakeRobot(toy := ToyRobot())
    async with running(tmp_path, toy, robot) as rig:
        await until(lambda: rig.bus.of(ROBOT_STATE)[-1].map_id is not None)
        first = Map.model_validate_json((await rig.client.get("/map")).content).home
        assert first is not None
        assert rig.bus.of(ROBOT_STATE)[-1].map_id == first.id
        robot.senses.map.put(grid_of(0), 0.0)
        await until(lambda: rig.bus.of(ROBOT_STATE)[-1].map_id not in {None, first.id})
        told = Map.model_validate_json((await rig.client.get("/map")).content)
        assert (decode(told).cells == grid_of(0).cells).all()
        maps = [KnownMap.model_validate(one) for one in (await rig.client.get("/maps")).json()]
        assert told.home is not None
        assert [one.id for one in maps] == [told.home.id, first.id]


async def test_a_dock_of_another_map_is_not_driven_to_and_that_is_said(tmp_path: Path) -> None:
    robot = FakeRobot(toy := ToyRobot())
    async with running(tmp_path, toy, robot) as rig:
        toy.put_on_dock()
        await until(lambda: rig.bus.of(ROBOT_STATE)[-1].dock is not None)
        await rig.post("/undock")
        toy.dock_visible = False
        await until(lambda: rig.bus.of(ROBOT_STATE)[-1].docked is False)
        robot.senses.map.put(grid_of(0), 0.0)
        await until(lambda: rig.bus.of(ROBOT_STATE)[-1].dock is None)
        refused = await rig.post("/dock")
        assert refused.status_code == 409
        assert "not known in this map (it was learned in another one)" in refused.json()["detail"]


async def test_two_homes_are_not_made_one_by_mistake(tmp_path: Path) -> None:
    robot = FakeRobot(toy := ToyRobot())
    async with running(tmp_path, toy, robot) as rig:
        robot.senses.map.put(grid_of(0), 0.0)
        home_id = (await rig.client.get("/map")).json()["home"]["id"]
        robot.senses.map.put(grid_of(1), 0.0)
        await rig.client.get("/map")
        refused = await rig.post("/map/same-home", {"id": home_id})
        assert (refused.status_code, "walls" in refused.json()["detail"]) == (409, True)
        assert (await rig.post("/map/same-home", {"id": "never"})).status_code == 404
        cells = grid_of(0).cells.copy()
        cells[3:-3, 30:190] = 0
        robot.senses.map.put(Grid(cells, 0.05, grid_of(0).origin), 0.0)
        emptied = (await rig.client.get("/map")).json()["home"]["id"]
        said = KnownMap.model_validate((await rig.post("/map/same-home", {"id": home_id})).json())
        assert (said.id, said.was) == (home_id, (emptied,))
        assert RobotState.model_validate((await rig.client.get("/state")).json()).map_id == home_id
