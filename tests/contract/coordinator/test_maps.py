"""Missions on maps as they really come: turned, without free space, changed under way."""

import math

import numpy as np
import pytest

from contracts.geometry import Pose2D
from contracts.mission import MapTrouble, MissionState, Outcome
from coordinator.core.rules import CoverageRule
from geometry.grids import OccupancyGrid, encode
from support.coordinator_mesh import OpenMesh
from support.coordinator_world import Thing

FAR = Thing("bottle", "red", 8.5, 6.8)
RED = Thing("bottle", "red", 3.5, 2.5)
BLUE = Thing("bottle", "blue", 3.0, 3.2)
NARROW = np.full((160, 200), 100, np.int8)
NARROW[:, 40:44] = 0
YAWS = (0.1, 1.56, math.pi, -2.4)


@pytest.mark.parametrize("yaw", YAWS)
async def test_a_turned_map_is_searched_like_the_same_one_unturned(open_mesh: OpenMesh, yaw: float) -> None:
    async with open_mesh(FAR) as mesh:
        mesh.robot.as_map = encode(mesh.world.grid(yaw))
        mission = await mesh.until_over((await mesh.post_mission()).id)
        assert mission.outcome is Outcome.FOUND
        assert mesh.away_m(FAR) <= 0.5


@pytest.mark.parametrize("yaw", YAWS)
async def test_of_a_turned_map_the_share_looked_at_is_as_of_the_same_one_unturned(
    open_mesh: OpenMesh, yaw: float
) -> None:
    async with open_mesh(BLUE) as mesh:
        mesh.robot.as_map = encode(mesh.world.grid(yaw))
        mission = await mesh.until_over((await mesh.post_mission()).id)
        assert mission.outcome is Outcome.NOT_FOUND
        assert mission.report is not None
        assert mission.report.looked_share is not None
        assert mission.report.looked_share > 0.9
        assert mission.report.places_unreachable == 0


@pytest.mark.parametrize(
    ("cells", "trouble", "words"),
    [
        (np.full((160, 200), -1, np.int8), MapTrouble.NO_FREE_SPACE, "the map shows no free space"),
        (np.full((160, 200), 100, np.int8), MapTrouble.NO_FREE_SPACE, "the map shows no free space"),
        (np.full((160, 200), 50, np.int8), MapTrouble.NO_FREE_SPACE, "the map shows no free space"),
        (NARROW, MapTrouble.NO_ROOM, "the map shows no place with room for the robot"),
    ],
    ids=["unknown", "occupied", "neither", "narrow"],
)
@pytest.mark.parametrize("rule", list(CoverageRule))
async def test_a_map_to_search_nothing_on_is_said_to_be_that_and_not_a_search_of_every_place(
    open_mesh: OpenMesh, cells: np.ndarray, trouble: MapTrouble, words: str, rule: CoverageRule
) -> None:
    async with open_mesh(FAR, coverage_rule=rule) as mesh:
        mesh.robot.as_map = encode(OccupancyGrid(cells, 0.05, Pose2D(x=0.0, y=0.0, yaw=0.0)))
        plan = (await mesh.client.get("/coverage")).json()
        assert (plan["points"], plan["map_trouble"]) == ([], trouble.value)
        mission = await mesh.until_over((await mesh.post_mission()).id)
        assert (mission.outcome, mission.reason) == (Outcome.ABORTED, words)
        assert mission.report is not None
        assert mission.report.map_trouble is trouble


async def test_a_map_on_which_all_was_looked_at_is_no_trouble(open_mesh: OpenMesh) -> None:
    async with open_mesh(BLUE) as mesh:
        mission = await mesh.until_over((await mesh.post_mission()).id)
        assert mission.outcome is Outcome.NOT_FOUND
        assert "every place was looked at" in mission.reason
        assert mission.report is not None
        assert mission.report.map_trouble is None


async def test_a_mission_ends_with_its_cause_when_the_map_becomes_that_of_another_place(open_mesh: OpenMesh) -> None:
    async with open_mesh(BLUE) as mesh:
        mesh.world.map_id = "home"
        started = await mesh.post_mission()
        await mesh.until_state(MissionState.SCANNING)
        await mesh.clock.advance(1.0)
        mesh.world.map_id = None  # a bridge that has just been started
        await mesh.clock.advance(1.0)
        assert (await mesh.mission(started.id)).outcome is None
        mesh.world.map_id = "office"
        mission = await mesh.until_over(started.id, within_s=5.0)
        assert (mission.outcome, mission.reason) == (
            Outcome.ABORTED,
            "the map was replaced by that of another place",
        )
        assert mission.report is not None
        assert (mission.report.map_trouble, mission.map_id) == (MapTrouble.ANOTHER_MAP, "home")
        assert (await mesh.post_mission()).outcome is None


async def test_what_is_remembered_in_another_map_is_said_and_not_driven_to(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        mesh.memory.in_other_maps = ("office",)
        mission = await mesh.until_over((await mesh.post_mission()).id)
        assert mission.outcome is Outcome.FOUND
        assert "also remembered on another map" in (await mesh.timeline(mission.id))[0].text
