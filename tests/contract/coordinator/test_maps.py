"""Missions on maps as they really come: turned, without free space, changed under way."""

import math

import pytest

from contracts.mission import Outcome
from geometry.grids import encode
from support.coordinator_mesh import OpenMesh
from support.coordinator_world import Thing

FAR = Thing("bottle", "red", 8.5, 6.8)
BLUE = Thing("bottle", "blue", 3.0, 3.2)
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
