"""The three honest endings with what they rest on, and the recording that decides a mission again."""

from contracts.geometry import Pose2D
from contracts.mission import Outcome
from coordinator.core import recording
from support.coordinator_mesh import Mesh, OpenMesh
from support.coordinator_world import Thing
from support.waiting import until_true

RED = Thing("bottle", "red", 3.5, 2.5)
BLUE = Thing("bottle", "blue", 3.0, 3.2)
CUP = Thing("cup", "white", 3.2, 1.2)


async def shown(mesh: Mesh, mission_id: str, number: int) -> bytes:
    """The picture is fetched beside the mission."""

    async def there() -> bool:
        return (await mesh.client.get(f"/missions/{mission_id}/pictures/{number}")).status_code == 200

    await until_true(there, timeout_s=30.0)
    answer = await mesh.client.get(f"/missions/{mission_id}/pictures/{number}")
    assert answer.headers["content-type"] == "image/jpeg"
    return answer.content


async def test_found_says_where_how_far_on_which_votes_and_shows_it(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        mission = await mesh.until_over((await mesh.post_mission()).id)
        assert mission.report is not None
        found = mission.report.found
        assert found is not None
        assert found.place is not None
        assert abs(found.place.x - RED.x) + abs(found.place.y - RED.y) < 0.1
        assert [vote.verdict.value for vote in found.votes] == ["yes", "yes", "abstain"]
        assert found.distance_m == mission.measured_distance_m
        assert found.picture is not None
        assert (
            await shown(mesh, mission.id, found.picture)
            == mesh.inference.pictures[f"validation-{mesh.inference.validations}"]
        )


async def test_not_found_says_how_much_was_looked_at_where_it_was_last_seen_and_what_was_seen_instead(
    open_mesh: OpenMesh,
) -> None:
    async with open_mesh(BLUE, CUP, views=(Pose2D(x=7.5, y=6.0, yaw=0.7),)) as mesh:
        mission = await mesh.until_over((await mesh.post_mission()).id)
        assert mission.outcome is Outcome.NOT_FOUND
        report = mission.report
        assert report is not None
        assert report.looked_share is not None
        assert report.looked_share > 0.9
        assert report.places_looked > 3
        assert report.last_seen is not None
        assert report.last_seen.pose == Pose2D(x=7.5, y=6.0, yaw=0.7)
        assert {(one.label, one.colour) for one in report.seen_instead} == {("bottle", "blue"), ("cup", "white")}
        assert "seen instead" in report.text
        assert "last seen" in report.text


async def test_unsure_names_its_candidates_with_their_votes_and_pictures(open_mesh: OpenMesh) -> None:
    async with open_mesh(BLUE, colours_unknown=True) as mesh:
        mesh.inference.narrow = True
        mission = await mesh.until_over((await mesh.post_mission()).id)
        assert mission.outcome is Outcome.UNSURE
        assert mission.report is not None
        best = mission.report.candidates[0]
        assert best.narrow
        assert not best.confirmed
        assert best.votes
        assert best.place is not None
        assert best.picture is not None
        assert await shown(mesh, mission.id, best.picture) in mesh.inference.pictures.values()


async def test_a_confirmation_with_a_single_yes_is_none(open_mesh: OpenMesh) -> None:
    async with open_mesh(BLUE, colours_unknown=True) as mesh:
        mesh.inference.lies = True
        mission = await mesh.until_over((await mesh.post_mission()).id)
        assert mission.outcome in {Outcome.NOT_FOUND, Outcome.UNSURE}


async def test_what_nobody_could_judge_stays_in_doubt_with_its_place(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        mesh.inference.fail_next = 1000
        mission = await mesh.until_over((await mesh.post_mission()).id)
        assert mission.outcome is Outcome.UNSURE
        assert mission.report is not None
        assert "could not be judged (the model is away)" in mission.report.candidates[0].text
        assert mission.report.candidates[0].place is not None
        assert mission.report.candidates[0].picture is None


async def test_an_abort_names_its_cause(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        mesh.robot.fail_next = {"rotate": 1000}
        mission = await mesh.until_over((await mesh.post_mission()).id)
        assert mission.outcome is Outcome.ABORTED
        assert mission.report is not None
        assert "robot_bridge failed 6 times" in mission.report.cause


async def test_while_it_waits_for_a_service_it_says_for_which(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        mesh.robot.fail_next = {"rotate": 3}
        mission = await mesh.post_mission()

        async def waits() -> bool:
            return (await mesh.client.get("/state")).json()["waiting_for"].startswith("robot_bridge: again in")

        await mesh.advance_until(waits, within_s=30.0, step_s=0.1)
        assert (await mesh.until_over(mission.id)).outcome is Outcome.FOUND


async def test_its_recording_decides_the_mission_again_step_by_step(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED, views=(Pose2D(x=7.5, y=6.0, yaw=0.7),)) as mesh:
        mission = await mesh.until_over((await mesh.post_mission()).id)
        await mesh.clock.advance(5.0)
        answer = await mesh.client.get(f"/missions/{mission.id}/recording")
        assert answer.headers["content-type"].startswith("application/x-ndjson")
        written = recording.read(answer.text.splitlines())
        again = list(recording.replay(written))
        assert all(one.same for one in again)
        assert again[-1].after.report == mission.report
        assert len(again) > 50


async def test_no_such_picture_or_recording_is_404(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        mission = await mesh.post_mission()
        assert (await mesh.client.get(f"/missions/{mission.id}/pictures/99")).status_code == 404
        assert (await mesh.client.get(f"/missions/{mission.id}/pictures/-1")).status_code == 422
        assert (await mesh.client.get("/missions/nobody/recording")).status_code == 404


async def test_each_look_of_a_scan_is_told_to_memory_with_everything_it_saw(open_mesh: OpenMesh) -> None:
    async with open_mesh(BLUE) as mesh:
        mesh.memory.things = ()
        await mesh.until_over((await mesh.post_mission()).id)
        assert len(mesh.memory.looked) > 20
        assert {box.label for look in mesh.memory.looked for box in look.seen} == {"bottle"}
        assert any(look.seen == () for look in mesh.memory.looked)


async def test_a_memory_that_takes_no_looks_does_not_disturb_the_search(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        assert mesh.memory.things is None
        assert (await mesh.until_over((await mesh.post_mission()).id)).outcome is Outcome.FOUND
