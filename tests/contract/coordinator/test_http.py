"""The HTTP face: what is refused, how, and that it changes nothing."""

import pytest

from contracts.mission import CoveragePlan, MissionStatus
from contracts.vision import ParsedTask
from support.coordinator_mesh import OpenMesh
from support.coordinator_world import Thing
from support.memory_log import MemoryLog

RED = Thing("bottle", "red", 3.5, 2.5)


async def test_it_starts_idle_and_says_so(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        status = MissionStatus.model_validate_json((await mesh.client.get("/state")).content)
        assert status.state.value == "IDLE"
        assert status.mission is None


@pytest.mark.parametrize(
    "body", [b"", b"{", b"[]", b'{"command": ""}', b'{"command": 7}', b'{"order": "x"}', b'{"command": "x", "y": 1}']
)
async def test_a_malformed_command_is_422_and_changes_nothing(open_mesh: OpenMesh, body: bytes) -> None:
    async with open_mesh() as mesh:
        answer = await mesh.client.post("/missions", content=body, headers={"content-type": "application/json"})
        assert answer.status_code == 422
        assert answer.headers["content-type"] == "application/problem+json"
        assert (await mesh.client.get("/missions")).json() == []
        assert mesh.world.moves == []


async def test_without_an_opened_history_nothing_is_begun(open_mesh: OpenMesh) -> None:
    log = MemoryLog()
    log.opened = False
    async with open_mesh(log=log) as mesh:
        answer = await mesh.client.post("/missions", json={"command": "find the red bottle"})
        assert (answer.status_code, answer.json()["detail"]) == (
            503,
            "database: the history of missions is not open yet",
        )
        assert mesh.world.moves == []


async def test_blank_words_are_no_command(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        assert (await mesh.client.post("/missions", json={"command": "   "})).status_code == 422


async def test_a_20_mb_body_is_413(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        answer = await mesh.client.post("/missions", content=b"x" * 20_000_000)
        assert answer.status_code == 413
        assert answer.headers["content-type"] == "application/problem+json"


async def test_a_command_that_names_nothing_known_is_422_with_the_reason(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        mesh.inference.parse = ParsedTask()
        answer = await mesh.client.post("/missions", json={"command": "sing a song"})
        assert answer.status_code == 422
        assert "names nothing I know" in answer.json()["detail"]
        assert (await mesh.client.get("/state")).json()["state"] == "IDLE"


@pytest.mark.parametrize("path", ["", "/events"])
async def test_an_unknown_mission_is_404(open_mesh: OpenMesh, path: str) -> None:
    async with open_mesh() as mesh:
        answer = await mesh.client.get(f"/missions/none{path}")
        assert answer.status_code == 404
        assert answer.headers["content-type"] == "application/problem+json"


@pytest.mark.parametrize("verb", ["cancel", "pause", "resume"])
async def test_telling_an_unknown_mission_is_404(open_mesh: OpenMesh, verb: str) -> None:
    async with open_mesh() as mesh:
        assert (await mesh.client.post(f"/missions/none/{verb}")).status_code == 404


async def test_without_a_robot_it_is_503_naming_the_bridge(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        mesh.silence()
        await mesh.clock.advance(5.0)
        answer = await mesh.client.post("/missions", json={"command": "find the red bottle"})
        assert answer.status_code == 503
        assert "robot_bridge" in answer.json()["detail"]


async def test_ready_names_each_dependency(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        ready = await mesh.client.get("/ready")
        assert ready.status_code == 200
        names = {d["name"] for d in ready.json()["dependencies"]}
        assert names == {
            "redis",
            "robot_bridge",
            "inference",
            "memory",
            "database",
            "session",
            "robot.state",
            "robot.description",
        }
        mesh.robot.session_held = False
        unready = await mesh.client.get("/ready")
        assert unready.status_code == 503
        assert [d["name"] for d in unready.json()["dependencies"] if d["state"] != "ready"] == ["session"]


async def test_coverage_is_a_plan_for_the_map(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        plan = CoveragePlan.model_validate_json((await mesh.client.get("/coverage")).content)
        assert len(plan.points) > 5
        assert plan.free_area_m2 > 50.0


async def test_coverage_without_a_map_is_503(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        mesh.robot.fail_next = {"map": 1}
        assert (await mesh.client.get("/coverage")).status_code == 503


async def test_events_after_an_id_are_only_the_newer_ones(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        mission = await mesh.until_over((await mesh.post_mission()).id)
        events = await mesh.timeline(mission.id)
        newer = (await mesh.client.get(f"/missions/{mission.id}/events", params={"after": events[3].id})).json()
        assert [e["id"] for e in newer] == [e.id for e in events[4:]]
        one = (await mesh.client.get(f"/missions/{mission.id}/events", params={"limit": 1})).json()
        assert len(one) == 1


async def test_missions_are_listed_newest_first_and_limited(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        ids = []
        for _ in range(2):
            mission = await mesh.post_mission()
            ids.append(mission.id)
            await mesh.client.post(f"/missions/{mission.id}/cancel")
        assert [m["id"] for m in (await mesh.client.get("/missions")).json()] == ids[::-1]
        assert len((await mesh.client.get("/missions", params={"limit": 1})).json()) == 1
        assert (await mesh.client.get("/missions", params={"limit": 0})).status_code == 422
