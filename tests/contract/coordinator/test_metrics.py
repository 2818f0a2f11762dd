"""What the coordinator tells Prometheus of a mission."""

from support.coordinator_mesh import OpenMesh
from support.coordinator_world import Thing
from support.scraped import sample, scraped, untold

RED = Thing("bottle", "red", 3.5, 2.5)


async def test_a_mission_leaves_its_time_and_its_outcome(open_mesh: OpenMesh) -> None:
    found = {"kind": "find", "outcome": "found"}
    async with open_mesh(RED) as mesh:
        before = (await scraped(mesh.client)).get(("coordinator_mission_seconds_count", frozenset(found.items())), 0.0)
        mission = await mesh.until_over((await mesh.post_mission()).id)
        after = await scraped(mesh.client)
    assert mission.ended_s is not None
    assert sample(after, "coordinator_mission_seconds_count", **found) == before + 1
    assert untold(after, "coordinator") == set()


async def test_what_waits_is_counted_and_the_state_is_named(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        await mesh.post_mission()
        await mesh.post_mission("find the blue cup")
        told = await scraped(mesh.client)
        (state,) = [labels for (name, labels), on in told.items() if name == "coordinator_mission_state" and on]
        assert dict(state)["coordinator_mission_state"] == (await mesh.client.get("/state")).json()["state"]
    assert sample(told, "coordinator_queue_missions") == 1
    assert sample(told, "service_ready", service="coordinator") == 1
    assert sample(told, "service_dependency_ready", service="coordinator", dependency="database") == 1
