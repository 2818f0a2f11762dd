"""`explore` through the coordinator's own routes: begun, told of, held, cancelled, stopped; by the frontiers."""

from contracts.exploration import Discovery, ExplorationMemory, ExplorationMode, ExplorationStatus
from contracts.mission import EndCause, Mission, MissionStatus, Outcome
from support.coordinator_mesh import Mesh, OpenMesh
from support.coordinator_world import Thing

SEEN_M = 2.5
M = ExplorationMode


async def explore(mesh: Mesh, *, mapped_m: float | None = SEEN_M) -> Mission:
    mesh.world.mapped_m = mapped_m
    response = await mesh.client.post("/actions", json={"action": "explore"})
    assert response.status_code == 201, response.text
    return Mission.model_validate(response.json()["mission"])


async def told(mesh: Mesh) -> ExplorationStatus:
    status = MissionStatus.model_validate_json((await mesh.client.get("/state")).content)
    assert status.exploration is not None
    return status.exploration


async def until_it_drives(mesh: Mesh, *, more_than: int = 0) -> None:
    async def drives() -> bool:
        return mesh.world.moves.count("navigate") > more_than

    await mesh.advance_until(drives, within_s=60.0)


async def stands(mesh: Mesh, seconds: float = 10.0) -> bool:
    await mesh.clock.advance(2.0)
    moves, pose = len(mesh.world.moves), mesh.world.pose
    await mesh.clock.advance(seconds)
    return (len(mesh.world.moves), mesh.world.pose) == (moves, pose)


async def test_it_drives_to_the_borders_of_a_growing_map_and_home_again(open_mesh: OpenMesh) -> None:
    async with open_mesh(Thing("bottle", "red", 3.5, 1.5)) as mesh:
        home, mesh.world.map_id = mesh.world.pose, "flat"
        mission = await explore(mesh)
        await until_it_drives(mesh)
        under_way = await told(mesh)
        assert (under_way.mission_id, under_way.mode, under_way.model) == (mission.id, M.FRONTIERS, "")
        assert under_way.frontiers >= 1
        over = await mesh.until_over(mission.id)
        assert over.outcome is Outcome.DONE
        assert "nothing unknown is left that can be reached" in over.reason
        assert abs(mesh.world.pose.x - home.x) + abs(mesh.world.pose.y - home.y) < 0.6
        after = await told(mesh)
        assert (after.mode, after.calls, after.frontiers) == (M.IDLE, 0, 0)
        assert after.goals >= 2
        assert (after.explored_m2 or 0.0) > 40.0
        assert mesh.journal.of["flat"].actions_done == after.actions
        lines = [one.text for one in await mesh.timeline(mission.id)]
        assert "exploring, frontiers: begun" in lines
        assert over.report is not None
        assert over.report.seen_instead[0].label == "bottle"


async def test_where_the_map_is_whole_it_looks_at_all_of_it(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        over = await mesh.until_over((await explore(mesh, mapped_m=None)).id)
        assert over.outcome is Outcome.DONE
        assert over.report is not None
        assert (over.report.looked_share or 0.0) > 0.9


async def test_it_listens_and_goes_on_by_itself(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        mission = await explore(mesh)
        await until_it_drives(mesh)
        await mesh.client.post(f"/missions/{mission.id}/pause?for_s=20")
        assert await stands(mesh)
        assert (await told(mesh)).mode is M.LISTENING
        driven = mesh.world.moves.count("navigate")
        await until_it_drives(mesh, more_than=driven)
        assert (await told(mesh)).mode is M.FRONTIERS


async def test_a_pause_by_a_person_lasts_until_it_is_resumed(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        mission = await explore(mesh)
        await until_it_drives(mesh)
        await mesh.client.post(f"/missions/{mission.id}/pause?for_s=5")
        await mesh.client.post(f"/missions/{mission.id}/pause")
        assert await stands(mesh, 60.0)
        driven = mesh.world.moves.count("navigate")
        assert (await mesh.client.post(f"/missions/{mission.id}/resume")).is_success
        await until_it_drives(mesh, more_than=driven)


async def test_paused_before_it_began_it_moves_nothing_until_it_is_resumed(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        mesh.world.map_id = "flat"
        mesh.journal.held.clear()
        mission = await explore(mesh)
        await mesh.clock.advance(3.0)
        await mesh.client.post(f"/missions/{mission.id}/pause")
        mesh.journal.held.set()
        assert await stands(mesh)
        assert mesh.world.moves == []
        await mesh.client.post(f"/missions/{mission.id}/resume")
        await until_it_drives(mesh)


async def test_cancelled_it_stands_and_the_next_mission_begins(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        mission = await explore(mesh)
        await until_it_drives(mesh)
        await mesh.client.post(f"/missions/{mission.id}/cancel")
        assert await stands(mesh)
        assert (await mesh.mission(mission.id)).outcome is Outcome.CANCELED
        assert (await told(mesh)).mode is M.IDLE
        turned = await mesh.client.post("/actions", json={"action": "rotate", "angle_rad": 1.0})
        assert (await mesh.until_over(turned.json()["mission"]["id"])).outcome is Outcome.DONE
        assert mesh.world.moves[-1] == "rotate"


async def test_the_emergency_stop_ends_it_and_nothing_goes_on_after_the_reset(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        mission = await explore(mesh)
        await until_it_drives(mesh)
        await mesh.robot.emergency_stop("pressed")
        await mesh.clock.advance(1.0)
        await mesh.world.reset()
        assert await stands(mesh, 20.0)
        over = await mesh.mission(mission.id)
        assert over.report is not None
        assert (over.outcome, over.report.ended_by) == (Outcome.ABORTED, EndCause.STOPPED)


async def test_what_was_discovered_in_one_home_is_not_told_in_another(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        safe = Discovery(label="safe", note="behind the mirror", x_m=1.0, y_m=1.0, stamp_s=3.0)
        mesh.journal.of["flat"] = ExplorationMemory(discoveries=(safe,))
        mesh.world.map_id = "flat"
        mission = await explore(mesh)
        await until_it_drives(mesh)
        assert (await told(mesh)).discoveries == (safe,)
        mesh.world.map_id = "garden house"
        over = await mesh.until_over(mission.id)
        assert over.report is not None
        assert over.report.ended_by is EndCause.MAP
        assert (await told(mesh)).discoveries == ()
        answer = await mesh.client.post("/ask", json={"question": "what did you discover?"})
        assert answer.status_code == 200
        assert "safe" not in answer.text
        mesh.world.map_id = "flat"
        await mesh.clock.advance(2.0)
        answer = await mesh.client.post("/ask", json={"question": "what did you discover?"})
        assert "safe" in answer.text


async def test_what_moves_waits_for_the_end_of_it(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        mission = await explore(mesh)
        await until_it_drives(mesh)
        waits = await mesh.client.post("/actions", json={"action": "rotate", "angle_rad": 1.0})
        assert waits.json()["mission"]["queue_position"] == 0
        await mesh.client.post("/actions/stop")
        assert await stands(mesh)
        for one in (mission.id, waits.json()["mission"]["id"]):
            assert (await mesh.mission(one)).outcome is Outcome.CANCELED
