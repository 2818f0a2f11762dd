"""The battery and the dock (requirement A15), through the front door."""

from contracts.mission import Mission, MissionKind, Outcome
from support.coordinator_mesh import Mesh, OpenMesh
from support.coordinator_world import Thing

RED = Thing("bottle", "red", 3.5, 2.5)


async def newest(mesh: Mesh) -> Mission:
    return Mission.model_validate((await mesh.client.get("/missions")).json()[0])


async def until_docked(mesh: Mesh) -> Mission:
    async def docked() -> bool:
        return (await newest(mesh)).outcome is Outcome.DOCKED

    await mesh.advance_until(docked, within_s=300.0)
    return await newest(mesh)


async def test_a_low_battery_refuses_a_mission_with_the_reason(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        mesh.world.battery_percent, mesh.world.docked = 12.0, True
        await mesh.clock.advance(0.5)
        answer = await mesh.client.post("/missions", json={"command": "find the red bottle"})
        assert answer.status_code == 409
        assert "the battery is at 12 %, below 20 %" in answer.json()["detail"]
        assert (await mesh.client.get("/missions")).json() == []


async def test_it_finishes_the_task_first_and_then_drives_to_the_dock_by_itself(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        mission = await mesh.post_mission()
        mesh.world.battery_percent = 15.0
        assert (await mesh.until_over(mission.id)).outcome is Outcome.FOUND
        docking = await until_docked(mesh)
        assert docking.kind is MissionKind.DOCK
        assert mesh.world.moves[-1] == "dock"
        told = [event.text for event in await mesh.timeline(docking.id)]
        assert "the battery is at 15 %" in told[0]


async def test_what_waits_is_ended_with_the_reason_instead_of_begun_hours_later(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        first, second = await mesh.post_mission(), await mesh.post_mission()
        mesh.world.battery_percent = 15.0
        await mesh.until_over(first.id)
        await until_docked(mesh)
        ended = await mesh.mission(second.id)
        assert ended.outcome is Outcome.ABORTED
        assert "battery" in ended.reason


async def test_a_person_can_send_it_to_the_dock_and_cancel_that(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        mission = await mesh.post_mission("go to the dock")
        assert mission.kind is MissionKind.DOCK
        await mesh.clock.advance(2.0)
        await mesh.client.post(f"/missions/{mission.id}/cancel")
        assert (await mesh.mission(mission.id)).outcome is Outcome.CANCELED
        await mesh.clock.advance(20.0)
        assert mesh.world.docked is False


async def test_a_dock_that_is_not_seen_ends_it_with_the_cause_and_is_not_asked_again_at_once(
    open_mesh: OpenMesh,
) -> None:
    async with open_mesh(RED) as mesh:
        mesh.robot.refuses_dock = True
        mesh.world.battery_percent = 15.0

        async def gave_up() -> bool:
            missions = (await mesh.client.get("/missions")).json()
            return bool(missions) and missions[0]["outcome"] == "aborted"

        await mesh.advance_until(gave_up, within_s=300.0)
        mission = await newest(mesh)
        assert mission.report is not None
        assert "could not dock in 2 tries: the base gave up" in mission.report.cause
        await mesh.clock.advance(120.0)
        assert len((await mesh.client.get("/missions")).json()) == 1


async def test_while_it_charges_a_low_battery_refuses_nothing(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        mesh.world.battery_percent, mesh.world.charging, mesh.world.docked = 15.0, True, True
        await mesh.clock.advance(40.0)
        assert (await mesh.client.get("/missions")).json() == []
        assert (await mesh.post_mission()).outcome is None
