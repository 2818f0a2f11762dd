"""GET /missions/{id}/belief: what a search by belief holds probable, and why a mission has none, for the page too."""

from contextlib import aclosing

import pytest

from contracts.belief import NoBelief, SearchBelief
from contracts.mission import EventKind, MissionState
from contracts.problem import Problem
from geometry.probability_grids import decode
from mesh.errors import UpstreamError
from support.coordinator_mesh import Mesh, OpenMesh
from support.coordinator_world import Thing
from support.ui_world import FakeMissions, search_belief
from ui.adapters.coordinator import CoordinatorClient
from ui.ports import Missions
from ui.settings import Settings as PageSettings

RED = Thing("bottle", "red", 3.5, 2.5)


async def refusal(mesh: Mesh, mission_id: str) -> str:
    answer = await mesh.client.get(f"/missions/{mission_id}/belief")
    assert answer.status_code == 404, answer.text
    return Problem.model_validate_json(answer.content).code


async def belief(mesh: Mesh, mission_id: str) -> SearchBelief:
    answer = await mesh.client.get(f"/missions/{mission_id}/belief")
    assert answer.status_code == 200, answer.text
    return SearchBelief.model_validate_json(answer.content)


async def test_while_it_searches_its_belief_sums_to_one_and_tells_the_place_it_drives_to(open_mesh: OpenMesh) -> None:
    async with open_mesh(coverage_rule="belief") as mesh:
        mission = await mesh.post_mission()
        await mesh.until_state(MissionState.SCANNING)
        told = await belief(mesh, mission.id)
        assert told.mission_id == mission.id
        assert told.grid.resolution_m == pytest.approx(0.15)
        assert decode(told.grid).sum() + told.absent == pytest.approx(1.0, abs=0.02)
        chosen = [one for one in await mesh.timeline(mission.id) if one.kind is EventKind.NAVIGATION][-1]
        assert told.view is not None
        assert (told.view.pose, told.why) == (chosen.data.goal, chosen.text)


async def test_with_every_look_in_vain_it_is_surer_that_the_thing_is_not_here(open_mesh: OpenMesh) -> None:
    async with open_mesh(coverage_rule="belief") as mesh:
        mission = await mesh.post_mission()
        await mesh.until_state(MissionState.SCANNING)
        first = await belief(mesh, mission.id)
        await mesh.clock.advance(20.0)
        assert (await belief(mesh, mission.id)).absent > first.absent


async def test_a_mission_that_searches_by_another_rule_has_none(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        mission = await mesh.post_mission()
        await mesh.until_state(MissionState.SCANNING)
        assert await refusal(mesh, mission.id) == NoBelief.ANOTHER_RULE


async def test_one_that_waits_has_not_begun_and_one_that_is_over_has_ended(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED, coverage_rule="belief") as mesh:
        running, waiting = await mesh.post_mission(), await mesh.post_mission("find the blue cup")
        assert await refusal(mesh, waiting.id) == NoBelief.NOT_BEGUN
        await mesh.until_over(running.id)
        assert await refusal(mesh, running.id) == NoBelief.ENDED


async def test_before_its_first_choice_it_says_so(open_mesh: OpenMesh) -> None:
    async with open_mesh(coverage_rule="belief") as mesh:
        mesh.robot.fail_next = {"map": 1000}
        mission = await mesh.post_mission()
        assert await refusal(mesh, mission.id) == NoBelief.NOTHING_CHOSEN


async def test_a_mission_nobody_knows_is_404_without_a_reason_of_its_own(open_mesh: OpenMesh) -> None:
    async with open_mesh(coverage_rule="belief") as mesh:
        assert not await refusal(mesh, "none")


async def told_to_the_page(missions: Missions, mission_id: str) -> SearchBelief:
    told = await missions.belief(mission_id)
    assert isinstance(told, SearchBelief)
    assert told.mission_id == mission_id
    assert decode(told.grid).sum() + told.absent == pytest.approx(1.0, abs=0.02)
    assert told.view is not None
    assert told.view.pose.yaw == pytest.approx(told.view.headings[0])
    return told


async def test_the_pages_client_reads_what_the_coordinator_tells(open_mesh: OpenMesh) -> None:
    async with (
        open_mesh(RED, coverage_rule="belief") as mesh,
        aclosing(CoordinatorClient(PageSettings(), transport=mesh.transport)) as missions,
    ):
        mission = await mesh.post_mission()

        async def has_chosen() -> bool:
            return isinstance(await missions.belief(mission.id), SearchBelief)

        await mesh.advance_until(has_chosen, within_s=20.0)
        await told_to_the_page(missions, mission.id)
        await mesh.until_over(mission.id)
        assert await missions.belief(mission.id) is NoBelief.ENDED
        with pytest.raises(UpstreamError):
            await missions.belief("none")


async def test_the_fake_of_the_page_tells_the_same() -> None:
    missions = FakeMissions(believed=search_belief("m-1"))
    await told_to_the_page(missions, "m-1")
    missions.believed = NoBelief.ENDED
    assert await missions.belief("m-1") is NoBelief.ENDED
