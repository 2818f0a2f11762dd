"""Questions by room: what is in the kitchen, where is my cup, how many cups are in the bedroom."""

from collections.abc import Sequence

import pytest

from contracts.asking import About, Answer
from contracts.memory import RememberedObject
from contracts.rooms import NamedBy, NamedRoom
from mesh.errors import UnavailableError
from support.coordinator_mesh import Mesh, OpenMesh
from support.coordinator_world import thing


def room(number: int, name: str, kind: str | None = None, by: NamedBy = NamedBy.CONTENTS) -> NamedRoom:
    return NamedRoom(id=number, name=name, named_by=by, kind=kind, x=0.0, y=0.0, area_m2=9.0)


ROOMS = (
    room(1, "kitchen", "kitchen"),
    room(2, "bedroom", "bedroom"),
    room(3, "bedroom 2", "bedroom"),
    room(4, "unnamed room 4", by=NamedBy.NOBODY),
    room(5, "Anna's room", "living room", NamedBy.PERSON),
    room(6, "den", by=NamedBy.PERSON),
)
THINGS = tuple(
    thing(number, label, 1.0 + number / 10, 1.0, colour).model_copy(update={"room_id": of})
    for number, label, colour, of in (
        (1, "oven", None, 1), (2, "cup", "red", 1), (3, "cup", "blue", 2), (4, "bed", None, 2), (5, "bed", None, 3),
        (6, "book", None, 4), (7, "couch", None, 5), (8, "cup", "white", 5), (9, "tv", None, 6),
        (10, "bottle", None, None),
    )
)  # fmt: skip

BY_ROOM: tuple[tuple[str, set[int]], ...] = (
    ("What is in the kitchen?", {1, 2}),
    ("what's in the kitchen", {1, 2}),
    ("what do you see in the kitchen", {1, 2}),
    ("what things are in the kitchen", {1, 2}),
    ("which things do you know in the kitchen", {1, 2}),
    ("what did you see in the kitchen", {1, 2}),
    ("what have you seen in the kitchen", {1, 2}),
    ("list the things in the kitchen", {1, 2}),
    ("what is in the bedroom?", {3, 4, 5}),
    ("what is in my bedroom", {3, 4, 5}),
    ("what is in bedroom 2", {5}),
    ("what is in the bedroom 2?", {5}),
    ("what did you see in bedroom 2", {5}),
    ("what is in unnamed room 4", {6}),
    ("what is in the unnamed room 4?", {6}),
    ("What is in Anna's room?", {7, 8}),
    ("what is in annas room", {7, 8}),
    ("what do you know of anna's room", {7, 8}),
    ("what is in the living room", {7, 8}),
    ("what is in the lounge?", {7, 8}),
    ("what is in the sitting room", {7, 8}),
    ("what is in the den", {9}),
    ("what do you see in the den?", {9}),
    ("how many cups are in the kitchen", {2}),
    ("how many cups are in Anna's room", {8}),
    ("how many cups are in the bedroom?", {3}),
    ("how many beds are in bedroom 2", {5}),
    ("how many beds are in the bedroom", {4, 5}),
    ("count the cups in the kitchen", {2}),
    ("how many cups are there in the den", set()),
)


async def ask(mesh: Mesh, question: str) -> Answer:
    answer = await mesh.client.post("/ask", json={"question": question})
    assert answer.status_code == 200, answer.text
    return Answer.model_validate_json(answer.content)


def numbers(answer: Answer) -> set[int]:
    return {int(record.id.removeprefix("object ")) for record in answer.records}


async def test_thirty_questions_by_room_are_answered_with_what_stands_there(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        mesh.memory.things, mesh.memory.named_rooms = THINGS, ROOMS
        answers = {question: numbers(await ask(mesh, question)) for question, _ in BY_ROOM}
    assert len(BY_ROOM) == 30
    assert answers == dict(BY_ROOM)


async def test_where_a_thing_is_is_told_with_its_room(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        mesh.memory.things, mesh.memory.named_rooms = THINGS, ROOMS
        assert "in the kitchen" in (await ask(mesh, "where is the red cup")).answer
        assert "in Anna's room" in (await ask(mesh, "where is the couch")).answer
        assert ", in " not in (await ask(mesh, "where is the bottle")).answer


async def test_a_room_without_things_is_said_to_be_so_and_one_nobody_knows_is_not_made_up(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        mesh.memory.things, mesh.memory.named_rooms = THINGS[:1], ROOMS
        empty = await ask(mesh, "what is in the den")
        assert (empty.records, empty.answer) == ((), "I remember nothing in the den.")
        unknown = await ask(mesh, "what is in the bathroom")
        assert (unknown.about, unknown.records) == (About.CONTENTS, ())
        assert "I do not know where the bathroom is" in unknown.answer


async def test_a_room_is_asked_for_by_itself_however_much_the_home_holds(open_mesh: OpenMesh) -> None:
    """The 200 most believed things of the home are all in another room."""
    crowd = tuple(thing(100 + k, "book", 9.0, 9.0).model_copy(update={"room_id": 6}) for k in range(250))
    async with open_mesh() as mesh:
        mesh.memory.things, mesh.memory.named_rooms = crowd + THINGS, ROOMS
        assert numbers(await ask(mesh, "what is in the kitchen")) == {1, 2}
        assert numbers(await ask(mesh, "what is there to drink from in the kitchen")) == {2}
        assert numbers(await ask(mesh, "what is in the bedroom")) == {3, 4, 5}


@pytest.mark.parametrize("question", ["what are you doing?", "how full is the battery", "have you done it", "hm"])
async def test_what_concerns_no_place_asks_for_no_rooms(open_mesh: OpenMesh, question: str) -> None:
    async with open_mesh() as mesh:
        mesh.memory.rooms_hang = True
        await ask(mesh, question)
        assert mesh.memory.asked_for_rooms == 0


@pytest.mark.parametrize("question", ["where is the red cup", "what is in the kitchen"])
async def test_a_memory_that_does_not_tell_its_rooms_in_time_still_tells_its_things(
    open_mesh: OpenMesh, question: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("coordinator.questions.question_service.ROOMS_S_MAX", 0.0)
    async with open_mesh() as mesh:
        mesh.memory.things, mesh.memory.named_rooms, mesh.memory.rooms_hang = THINGS, ROOMS, True
        answer = await ask(mesh, question)
        assert 2 in numbers(answer)
        assert ", in the kitchen" not in answer.answer
        assert mesh.memory.asked_for_rooms == 1


async def test_a_question_keeps_the_rooms_it_was_asked_among(
    open_mesh: OpenMesh, monkeypatch: pytest.MonkeyPatch
) -> None:
    """While memory is asked for the things of one question another question comes, and rooms have other names."""
    async with open_mesh() as mesh:
        mesh.memory.things, mesh.memory.named_rooms = THINGS, ROOMS
        plain = mesh.memory.objects
        between: list[Answer] = []

        async def meanwhile(label: str | None, limit: int, room_id: int | None = None) -> Sequence[RememberedObject]:
            monkeypatch.setattr(mesh.memory, "objects", plain)
            mesh.memory.named_rooms = (room(1, "pantry", "kitchen", NamedBy.PERSON),)
            between.append(await ask(mesh, "where is the oven"))
            return await plain(label, limit, room_id)

        monkeypatch.setattr(mesh.memory, "objects", meanwhile)
        answer = await ask(mesh, "where is the red cup")
        assert "in the kitchen" in answer.answer
        assert "in the pantry" in between[0].answer


async def test_a_memory_that_cannot_look_into_a_room_is_not_taken_for_an_empty_room(
    open_mesh: OpenMesh, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with open_mesh() as mesh:
        mesh.memory.things, mesh.memory.named_rooms = THINGS, ROOMS

        async def busy(label: str | None, limit: int, room_id: int | None = None) -> Sequence[RememberedObject]:
            raise UnavailableError("memory", "the map is being cut")

        monkeypatch.setattr(mesh.memory, "objects", busy)
        assert "I remember nothing" not in (await ask(mesh, "what is in the kitchen")).answer
