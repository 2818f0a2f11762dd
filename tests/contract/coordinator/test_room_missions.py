"""Commands by room: 'find the red bottle in the kitchen' looks there, nowhere else, and says so."""

from collections.abc import Callable

import pytest

from bench.speech.scoring import Rules
from contracts.geometry import Pose2D
from contracts.intent import Intent, WantedAction
from contracts.mission import CommandRefusal, EndCause, Mission, Outcome, SearchedRoom
from contracts.rooms import NamedBy, NamedRoom
from contracts.vision import ParsedTask, ParseTaskRequest
from coordinator.core.rules import CoverageRule
from geometry import room_grids
from geometry.rooms import rooms_of
from support.coordinator_mesh import Mesh, OpenMesh
from support.coordinator_world import FakeInference, Thing, thing

LEFT, RIGHT = 1, 2
NEAR = Thing("bottle", "red", 3.0, 1.5)
IN_THE_KITCHEN = Thing("bottle", "red", 8.0, 4.0)


@pytest.fixture(autouse=True)
def _eyes_that_read(monkeypatch: pytest.MonkeyPatch) -> None:
    rules = Rules()

    async def parse_task(_: FakeInference, request: ParseTaskRequest) -> ParsedTask:
        return await rules.parse_task(request)

    monkeypatch.setattr(FakeInference, "parse_task", parse_task)


def with_rooms(mesh: Mesh, left: str = "bedroom", right: str = "kitchen") -> None:
    """The world's two rooms, named by what stands there; the robot is in the left one."""
    grid = mesh.world.grid()
    found = rooms_of(grid)
    ids = {one.number: LEFT if one.x_m < 5.0 else RIGHT for one in found.rooms}
    assert sorted(ids.values()) == [LEFT, RIGHT]
    mesh.memory.rooms_lie = room_grids.encode(found, ids, map_id="home")
    mesh.memory.named_rooms = tuple(
        NamedRoom(
            id=ids[one.number], name=name, named_by=NamedBy.CONTENTS, kind=name.rstrip(" 2"), x=one.x_m, y=one.y_m,
            area_m2=one.area_m2,
        )
        for one in found.rooms
        for name in [left if ids[one.number] == LEFT else right]
    )  # fmt: skip
    mesh.memory.things = ()


async def refused(mesh: Mesh, command: str) -> tuple[int, str | None, str]:
    answer = await mesh.client.post("/missions", json={"command": command})
    problem = answer.json()
    return answer.status_code, problem.get("code"), problem.get("detail", "")


def room_of(x: float) -> int:
    return LEFT if x < 5.0 else RIGHT


@pytest.mark.parametrize("rule", [CoverageRule.VIEWPOINTS, CoverageRule.LAWNMOWER, CoverageRule.BELIEF])
async def test_it_is_looked_for_in_the_room_that_was_said_and_found_there(
    open_mesh: OpenMesh, rule: CoverageRule
) -> None:
    async with open_mesh(NEAR, IN_THE_KITCHEN, coverage_rule=rule) as mesh:
        with_rooms(mesh)
        begun = await mesh.post_mission("find the red bottle in the kitchen")
        assert begun.rooms == (SearchedRoom(id=RIGHT, name="kitchen"),)
        over = await mesh.until_over(begun.id)
        assert over.outcome is Outcome.FOUND
        assert over.target_pose is not None
        assert over.target_pose.x == pytest.approx(8.0, abs=0.3)
        assert over.report is not None
        assert over.report.rooms == begun.rooms


async def test_what_is_not_there_is_said_with_the_room_and_with_what_is_known_of_elsewhere(
    open_mesh: OpenMesh,
) -> None:
    async with open_mesh(NEAR) as mesh:
        with_rooms(mesh)
        mesh.memory.things = (thing(4, "bottle", 3.0, 1.5, "red").model_copy(update={"room_id": LEFT}),)
        over = await mesh.until_over((await mesh.post_mission("look for the red bottle in the kitchen")).id)
        assert over.outcome is Outcome.NOT_FOUND
        report = over.report
        assert report is not None
        assert [one.name for one in report.rooms] == ["kitchen"]
        assert [(one.room, one.place.x) for one in report.elsewhere] == [("bedroom", 3.0)]
        assert "I looked in the kitchen only" in report.text
        assert "one was seen in the bedroom" in report.text
        assert report.looked_share == pytest.approx(1.0, abs=0.15)
        status = (await mesh.client.get("/state")).json()
        assert {room_of(pose["x"]) for pose in status["scan_points_done"]} == {RIGHT}


async def test_remembered_views_of_another_room_are_left_out(open_mesh: OpenMesh) -> None:
    in_bedroom, in_kitchen = Pose2D(x=2.0, y=2.0, yaw=0.0), Pose2D(x=7.0, y=4.0, yaw=0.0)
    async with open_mesh(IN_THE_KITCHEN, views=(in_bedroom, in_kitchen)) as mesh:
        with_rooms(mesh)
        begun = await mesh.post_mission("find the red bottle in the kitchen")
        status = (await mesh.client.get("/state")).json()
        assert [(pose["x"], pose["y"]) for pose in status["scan_points"]] == [(7.0, 4.0)]
        assert (await mesh.until_over(begun.id)).outcome is Outcome.FOUND


async def test_a_room_that_nobody_knows_is_refused_with_the_names_there_are(open_mesh: OpenMesh) -> None:
    async with open_mesh(NEAR) as mesh:
        with_rooms(mesh)
        status, code, detail = await refused(mesh, "find the red bottle in the attic")
        assert (status, code) == (422, CommandRefusal.UNKNOWN_ROOM.value)
        assert "attic" in detail
        assert {"bedroom", "kitchen"} <= set(detail.replace(",", " ").split())
        mesh.memory.named_rooms = ()
        status, code, detail = await refused(mesh, "find the red bottle in the kitchen")
        assert (status, code) == (422, CommandRefusal.UNKNOWN_ROOM.value)
        assert "I know no room yet" in detail
        assert mesh.world.moves == []


async def test_two_bedrooms_are_both_meant(open_mesh: OpenMesh) -> None:
    async with open_mesh(NEAR) as mesh:
        with_rooms(mesh, "bedroom", "bedroom 2")
        both = await mesh.post_mission("find the red bottle in the bedroom")
        assert [one.name for one in both.rooms] == ["bedroom", "bedroom 2"]
        second = await mesh.post_mission("find the red bottle in bedroom 2")
        assert [one.id for one in second.rooms] == [RIGHT]


async def test_it_is_what_was_asked_for_last(open_mesh: OpenMesh) -> None:
    async with open_mesh(NEAR) as mesh:
        with_rooms(mesh)
        status, code, _ = await refused(mesh, "look for it in the kitchen")
        assert (status, code) == (422, CommandRefusal.WHICH_THING.value)
        first = await mesh.post_mission("find the red bottle")
        again = await mesh.post_mission("now look for it in the kitchen")
        assert again.target == first.target
        assert [one.name for one in again.rooms] == ["kitchen"]


async def test_a_room_said_once_holds_for_each_thing_unless_they_are_asked_for_in_turn(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        with_rooms(mesh)

        async def rooms_of_each(command: str) -> list[list[str]]:
            request = (await mesh.post_mission(command)).request_id
            status = (await mesh.client.get("/state")).json()
            every = [Mission.model_validate(one) for one in (status["mission"], *status["queue"]) if one]
            return [[one.name for one in each.rooms] for each in every if each.request_id == request]

        assert await rooms_of_each("find the cup and the book in the kitchen") == [["kitchen"], ["kitchen"]]
        assert await rooms_of_each("find the cup, then the book in the kitchen") == [[], ["kitchen"]]


async def test_where_memory_is_away_nobody_knows_where_the_room_is(open_mesh: OpenMesh) -> None:
    async with open_mesh(NEAR) as mesh:
        with_rooms(mesh)
        mesh.memory.away = True
        status, _, detail = await refused(mesh, "find the red bottle in the kitchen")
        assert status == 503
        assert "where the kitchen is" in detail


def gone(mesh: Mesh) -> None:
    mesh.memory.rooms_lie = None


def away(mesh: Mesh) -> None:
    mesh.memory.away = True


@pytest.mark.parametrize(("change", "by"), [(gone, EndCause.MAP), (away, EndCause.SERVICE)])
async def test_where_the_room_is_not_known_any_more_when_its_turn_comes_it_looks_nowhere(
    open_mesh: OpenMesh, change: Callable[[Mesh], None], by: EndCause
) -> None:
    async with open_mesh() as mesh:
        with_rooms(mesh)
        first = await mesh.post_mission("find the clock")
        second = await mesh.post_mission("find the red bottle in the kitchen")
        change(mesh)
        await mesh.client.post(f"/missions/{first.id}/cancel")
        over = await mesh.until_over(second.id)
        assert over.outcome is Outcome.ABORTED
        assert over.report is not None
        assert over.report.ended_by is by
        assert "the kitchen" in over.report.text


async def test_the_rooms_of_another_map_than_the_robots_are_not_looked_in(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        with_rooms(mesh)
        mesh.world.map_id = "office"
        first = await mesh.post_mission("find the clock")
        second = await mesh.post_mission("find the red bottle in the kitchen")

        async def told() -> bool:
            return (await mesh.mission(first.id)).map_id == "office"

        await mesh.advance_until(told, within_s=60.0)
        await mesh.client.post(f"/missions/{first.id}/cancel")
        over = await mesh.until_over(second.id)
        assert over.report is not None
        assert (over.outcome, over.report.ended_by) == (Outcome.ABORTED, EndCause.MAP)


async def test_what_is_meant_has_the_room_in_it(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        with_rooms(mesh)

        async def intent(text: str) -> Intent:
            answer = await mesh.client.post("/understand", json={"readings": [text]})
            return Intent.model_validate(answer.json()["intent"])

        meant = await intent("find the red bottle in the kitchen")
        assert (meant.action, meant.room) == (WantedAction.FIND, "kitchen")
        assert (await intent("find the kitchen knife")).room is None


async def test_what_is_held_to_is_not_said_to_be_passed_over(open_mesh: OpenMesh) -> None:
    async with open_mesh(NEAR) as mesh:
        with_rooms(mesh)
        begun = await mesh.post_mission("find the red bottle in the kitchen")
        assert not any("not held to" in event.text for event in await mesh.timeline(begun.id))
        await mesh.client.post(f"/missions/{begun.id}/cancel")
        other = await mesh.post_mission("find the red bottle on the table")
        assert any("not held to" in event.text for event in await mesh.timeline(other.id))


async def test_of_several_rooms_each_is_looked_in_and_what_is_gone_is_told(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        with_rooms(mesh)
        first = await mesh.post_mission("find the clock")
        both = await mesh.post_mission("find the red bottle in the kitchen or the bedroom")
        assert [one.name for one in both.rooms] == ["kitchen", "bedroom"]
        mesh.memory.named_rooms = tuple(one for one in mesh.memory.named_rooms if one.name == "kitchen")
        await mesh.client.post(f"/missions/{first.id}/cancel")
        over = await mesh.until_over(both.id)
        assert over.report is not None
        assert [one.name for one in over.report.rooms] == ["kitchen"]
        assert any("the map shows the bedroom no more" in event.text for event in await mesh.timeline(both.id))
