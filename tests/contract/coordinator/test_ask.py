"""Questions: answers name the records they rest on, a model may phrase them, and nothing it says moves the robot."""

import pytest

from contracts.asking import About, Answer
from contracts.exploration import Discovery, ExplorationMemory
from contracts.geometry import Pose2D
from contracts.memory import ObjectState
from contracts.mission import Outcome
from support.coordinator_mesh import Mesh, OpenMesh
from support.coordinator_world import Thing, thing

RED = Thing("bottle", "red", 3.5, 2.5)


KITCHEN = (
    thing(1, "oven", 8.0, 6.0),
    thing(2, "bottle", 8.5, 6.5, "red"),
    thing(3, "bottle", 1.0, 1.0, "blue", seen_s=700.0),
    thing(4, "cup", 7.2, 5.5, "white"),
)


async def ask(mesh: Mesh, question: str) -> Answer:
    answer = await mesh.client.post("/ask", json={"question": question})
    assert answer.status_code == 200, answer.text
    return Answer.model_validate_json(answer.content)


async def test_where_a_thing_was_last_seen_comes_from_memory_with_its_record(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        mesh.memory.things = KITCHEN
        answer = await ask(mesh, "Where did you last see my red bottle?")
        assert (answer.about, answer.label, answer.phrased_by) == (About.LAST_SEEN, "bottle", "template")
        assert [record.id for record in answer.records] == ["object 2"]
        assert "10 minutes ago" in answer.answer
        newest_first = await ask(mesh, "where is my bottle")
        assert [record.id for record in newest_first.records] == ["object 3", "object 2"]


async def test_what_is_in_a_room_is_what_lies_near_the_things_that_make_it_one(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        mesh.memory.things = KITCHEN
        answer = await ask(mesh, "What is in the kitchen?")
        assert answer.about is About.CONTENTS
        assert {record.id for record in answer.records} == {"object 1", "object 2", "object 4"}
        assert "Within 3 m of the oven" in answer.answer
        unknown = await ask(mesh, "what is in the bedroom")
        assert unknown.records == ()
        assert "I do not know where the bedroom is" in unknown.answer


async def test_what_it_is_doing_and_what_it_did_come_from_its_missions(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        idle = await ask(mesh, "what are you doing?")
        assert "wait for a command" in idle.answer
        mission = await mesh.post_mission()
        busy = await ask(mesh, "What are you doing?")
        assert busy.records[0].id == mission.id
        assert "find the red bottle" in busy.answer
        pause = f"/missions/{mission.id}/pause"
        await mesh.client.post(pause, params={"for_s": 20.0})
        assert "paused" not in (await ask(mesh, "what are you doing?")).answer, "it stands to hear the question"
        await mesh.client.post(pause, params={"for_s": 0.0})
        assert (await mesh.until_over(mission.id)).outcome is Outcome.FOUND
        done = await ask(mesh, "did you find the bottle?")
        assert done.about is About.HISTORY
        assert [record.id for record in done.records] == [mission.id]
        assert (await ask(mesh, "did you find the cup?")).records == ()


async def test_the_battery_is_told_only_where_it_is_known(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        assert "do not know" in (await ask(mesh, "how full is the battery?")).answer
        mesh.world.battery_percent = 64.0
        await mesh.clock.advance(0.5)
        assert "64 %" in (await ask(mesh, "how full is the battery?")).answer


async def test_a_memory_of_views_only_answers_too(open_mesh: OpenMesh) -> None:
    async with open_mesh(views=(Pose2D(x=7.5, y=6.0, yaw=0.7),)) as mesh:
        answer = await ask(mesh, "have you seen a bottle?")
        assert answer.records[0].pose == Pose2D(x=7.5, y=6.0, yaw=0.7)
        assert "I have not seen a cup" in (await ask(mesh, "where is my cup")).answer


async def test_a_memory_that_is_away_is_said_to_be(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        mesh.memory.away = True
        answer = await ask(mesh, "where is my cup")
        assert answer.records == ()
        assert "memory" in answer.notes


async def test_a_model_phrases_the_facts_and_is_named(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        mesh.memory.things = KITCHEN
        mesh.inference.words = "Your red bottle was at x 8.5 m, y 6.5 m, 10 minutes ago."
        answer = await ask(mesh, "where is my red bottle?")
        assert (answer.answer, answer.phrased_by) == (mesh.inference.words, "openai:test")
        assert mesh.inference.reasoned[0].facts == tuple(record.text for record in answer.records)


async def test_no_question_moves_the_robot(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        mesh.memory.things = KITCHEN
        mesh.inference.words = "DRIVE forward 2 m; call /velocity; navigate to 1 1"
        for question in ("drive to the kitchen", "find the red bottle", "POST /velocity", "go to the dock", "stop"):
            await ask(mesh, question)
        await mesh.clock.advance(10.0)
        assert mesh.world.moves == []
        assert (await mesh.client.get("/missions")).json() == []


@pytest.mark.parametrize("body", [b"", b"{}", b'{"question": ""}', b'{"question": "a\\u0000b"}', b'{"question": 7}'])
async def test_a_malformed_question_is_422(open_mesh: OpenMesh, body: bytes) -> None:
    async with open_mesh() as mesh:
        answer = await mesh.client.post("/ask", content=body, headers={"content-type": "application/json"})
        assert answer.status_code == 422


async def test_things_are_counted_honestly(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        lost = thing(9, "bottle", 4.0, 4.0).model_copy(update={"state": ObjectState.LOST})
        mesh.memory.things = (*KITCHEN, thing(5, "bottle", 1.4, 1.0), lost)
        answer = await ask(mesh, "how many bottles have you seen?")
        assert (answer.about, answer.label, answer.phrased_by) == (About.COUNT, "bottle", "template")
        assert answer.answer.startswith(
            "I remember 3 (bottle), at 2 places; 1 more I looked for and did not see again."
        )
        assert {record.id for record in answer.records} == {"object 2", "object 3", "object 5"}
        red = await ask(mesh, "count the red bottles please")
        assert red.answer.startswith("I remember 1 (red bottle), at one place; 1 more of a colour I do not know")
        assert (await ask(mesh, "how many vases are there")).answer == "I remember none (vase)."
        assert (await ask(mesh, "how many bottles are in the kitchen")).answer.startswith("I remember 1 (bottle)")


async def test_a_memory_of_views_cannot_count_and_says_so(open_mesh: OpenMesh) -> None:
    async with open_mesh(views=(Pose2D(x=2.0, y=2.0, yaw=0.0),)) as mesh:
        answer = await ask(mesh, "how many bottles are there?")
        assert answer.answer == "I cannot count them (bottle). bottle: seen from 1 places."


@pytest.mark.parametrize(
    ("question", "ids"),
    [
        ("anything to drink?", {"object 2", "object 3", "object 4"}),
        ("is there something to drink in the kitchen", {"object 2", "object 4"}),
        ("do we have any fruit", set[str]()),
    ],
)
async def test_a_group_of_things_can_be_asked_for(open_mesh: OpenMesh, question: str, ids: set[str]) -> None:
    async with open_mesh() as mesh:
        mesh.memory.things = KITCHEN
        answer = await ask(mesh, question)
        assert (answer.about, {record.id for record in answer.records}) == (About.CONTENTS, ids)
        assert answer.answer.startswith("I remember")


async def test_what_changed_is_what_is_new_moved_or_gone(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        now_s = mesh.clock.now_s()
        changed = {"first_seen_s": now_s - 60.0, "last_seen_s": now_s - 60.0}
        new, moved = (thing(n, "cup", 2.0 * n, 1.0).model_copy(update=changed) for n in (5, 6))
        gone = {"state": ObjectState.LOST, "last_missed_s": now_s - 30.0}
        mesh.memory.things = (
            new, moved.model_copy(update={"moved_from": 7}), thing(8, "vase", 1.0, 1.0).model_copy(update=gone),
        )  # fmt: skip
        answer = await ask(mesh, "what changed?")
        assert answer.about is About.CHANGES
        assert [record.text.split(":")[0] for record in answer.records] == ["gone", "new", "moved"]
        mesh.memory.things = ()
        none = await ask(mesh, "has anything moved since yesterday")
        assert none.answer == "In the last 2 days I noticed no change."


async def test_a_stop_in_the_box_for_questions_stops(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        mission = await mesh.post_mission()
        assert (await ask(mesh, "stop!")).answer.startswith("Stopped: the mission is over")
        assert (await mesh.mission(mission.id)).outcome is Outcome.CANCELED


@pytest.mark.parametrize("said", ["thanks", "never mind the cup", "I have a cup", "find the cup later"])
async def test_what_is_no_question_is_told_so(open_mesh: OpenMesh, said: str) -> None:
    async with open_mesh() as mesh:
        mesh.memory.things = KITCHEN
        answer = await ask(mesh, said)
        assert (answer.about, answer.records) == (About.UNKNOWN, ())


async def test_what_was_discovered_comes_from_the_explorations_of_this_home(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        asked = "What did you discover?"
        assert (await ask(mesh, asked)).answer == "I have discovered nothing in this home yet."
        found = (
            Discovery(label="kitchen", note="a fridge", x_m=2.0, y_m=1.0, stamp_s=mesh.clock.now_s() - 600.0),
            Discovery(label="stairs", x_m=4.0, y_m=1.0, stamp_s=mesh.clock.now_s()),
        )
        mesh.journal.of["flat"] = ExplorationMemory(discoveries=found)
        mesh.world.map_id = "flat"
        await mesh.clock.advance(0.5)
        answer = await ask(mesh, asked)
        assert (answer.about, [one.source for one in answer.records]) == (About.DISCOVERIES, ["exploration"] * 2)
        assert answer.answer == (
            "I discovered: stairs at x 4.0 m, y 1.0 m, just now. "
            "kitchen (a fridge) at x 2.0 m, y 1.0 m, 10 minutes ago."
        )
        mesh.world.map_id = "garden house"
        await mesh.clock.advance(0.5)
        assert (await ask(mesh, asked)).records == ()
