"""The wanted action beside the wanted thing (L1), and the question back where a saying was heard two ways."""

import pytest

from bench.speech.scoring import Rules
from contracts.asking import About
from contracts.intent import Intent, Understood, WantedAction
from contracts.mission import CommandRefusal
from contracts.reading import Mood
from contracts.rooms import NamedBy, NamedRoom
from contracts.vision import ParsedTask, ParseTaskRequest
from support.coordinator_mesh import Mesh, OpenMesh
from support.coordinator_world import FakeInference, Thing, thing

BOTTLE = Thing("bottle", "red", 8.0, 6.5)


@pytest.fixture(autouse=True)
def _eyes_that_read(monkeypatch: pytest.MonkeyPatch) -> None:
    rules = Rules()

    async def parse_task(_: FakeInference, request: ParseTaskRequest) -> ParsedTask:
        return await rules.parse_task(request)

    monkeypatch.setattr(FakeInference, "parse_task", parse_task)


def room(number: int, name: str, kind: str | None = None, by: NamedBy = NamedBy.CONTENTS) -> NamedRoom:
    return NamedRoom(id=number, name=name, named_by=by, kind=kind, x=2.0, y=2.0, area_m2=9.0)


async def understand(mesh: Mesh, *readings: str) -> Understood:
    response = await mesh.client.post("/understand", json={"readings": readings})
    assert response.status_code == 200, response.text
    return Understood.model_validate_json(response.content)


async def intent(mesh: Mesh, text: str) -> Intent:
    told = (await understand(mesh, text)).intent
    assert told is not None
    return told


@pytest.mark.parametrize(
    ("said", "action", "thing_asked_for"),
    [
        ("find the red bottle", WantedAction.FIND, "red bottle"),
        ("bring me an apple", WantedAction.BRING, "apple"),
        ("pour the water bottle", WantedAction.POUR, "water bottle"),
        ("pour the medicine", WantedAction.POUR, None),
        ("go to the couch", WantedAction.GO, "couch"),
        ("go to the dock", WantedAction.DOCK, None),
        ("where did you last see my cup?", WantedAction.ASK, "cup"),
        ("how many cups are there", WantedAction.COUNT, "cup"),
        ("stop", WantedAction.STOP, None),
        ("wait", WantedAction.PAUSE, None),
        ("go on", WantedAction.RESUME, None),
        ("emergency stop", WantedAction.EMERGENCY, None),
        ("stop and find the cup", WantedAction.FIND, "cup"),
        ("don't find the cup", WantedAction.NOTHING, None),
        ("such den Ball nicht", WantedAction.NOTHING, None),
        ("asdf qwer", WantedAction.NOTHING, None),
    ],
)
async def test_one_sentence_is_a_wanted_action_and_a_wanted_thing_and_begins_nothing(
    open_mesh: OpenMesh, said: str, action: WantedAction, thing_asked_for: str | None
) -> None:
    async with open_mesh(BOTTLE) as mesh:
        told = await intent(mesh, said)
        things = [one.description for one in told.targets]
        assert (told.action, things) == (action, [thing_asked_for] if thing_asked_for else [])
        assert (told.command, (await mesh.client.get("/missions")).json(), mesh.robot.halts) == (said, [], 0)


async def test_a_question_tells_its_topic_and_its_room_and_a_way_its_room(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        asked = await intent(mesh, "what is in the kitchen")
        assert (asked.action, asked.about, asked.room) == (WantedAction.ASK, About.CONTENTS, "kitchen")
        way = await intent(mesh, "go to the living room")
        assert (way.action, way.room, "I know no room" in way.able) == (WantedAction.GO, "living room", True)
        mesh.memory.named_rooms = (room(1, "living room", "living room"), room(2, "Anna's room", by=NamedBy.PERSON))
        for said, name in (("go to the living room", "living room"), ("go to Anna's room", "Anna's room")):
            way = await intent(mesh, said)
            assert (way.action, way.room, way.able) == (WantedAction.GO, name, "")


async def test_what_the_arm_would_do_is_said_and_what_the_wheels_can_is_done(open_mesh: OpenMesh) -> None:
    async with open_mesh(BOTTLE) as mesh:
        mission = await mesh.post_mission("bring me the red bottle")
        assert mission.action is WantedAction.BRING
        begun = next(one.text for one in await mesh.timeline(mission.id) if one.kind == "start")
        assert "I have no arm: I find it and drive up to it" in begun
        plain = await mesh.post_mission("find the red bottle")
        assert plain.action is WantedAction.FIND


@pytest.mark.parametrize(
    ("said", "code", "words"),
    [
        ("pour the water bottle", CommandRefusal.NO_ARM, "say 'find the water bottle'"),
        ("pour the medicine", CommandRefusal.NO_ARM, "I cannot pour"),
        ("bring me the medicine", CommandRefusal.NAMES_NOTHING, "knows no 'medicine'"),
        ("go to the kitchen", CommandRefusal.NO_ROOMS, "Say 'go to the oven'"),
    ],
)
async def test_what_cannot_be_begun_is_asked_back_with_what_can(
    open_mesh: OpenMesh, said: str, code: CommandRefusal, words: str
) -> None:
    async with open_mesh(BOTTLE) as mesh:
        mesh.memory.things = (thing(1, "oven", 8.0, 6.0),)
        response = await mesh.client.post("/missions", json={"command": said})
        assert (response.status_code, response.json()["code"]) == (422, code)
        assert words in response.json()["detail"]
        assert (await mesh.client.get("/missions")).json() == []


async def test_two_readings_of_one_wish_go_on_and_others_are_asked_back(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        same = await understand(mesh, "find my rucksack, find my rucksack,", "Find my rock sack.")
        assert same.intent is not None
        assert (same.intent.command, same.intent.targets[0].label) == ("find my rucksack", "backpack")
        other = await understand(mesh, "bring me the blue cup", "Bring me the blue bowl.")
        assert (other.intent, other.question) == (None, "Did you mean: bring the blue cup, or bring the blue bowl?")
        assert [one.intent.command for one in other.choices] == ["bring me the blue cup", "bring me the blue bowl"]


async def test_a_name_without_a_word_of_asking_that_was_heard_is_asked_back(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        told = await understand(mesh, "and the couch,", "and the couch.")
        assert (told.intent, [one.text for one in told.choices]) == (None, ["find the couch"])


async def test_silence_is_not_understood_and_typed_words_are_left_as_they_are(open_mesh: OpenMesh) -> None:
    async with open_mesh() as mesh:
        assert (await understand(mesh, "", " ")).intent is None
        typed = await intent(mesh, "find my Rock Sack!")
        assert (typed.command, typed.mood) == ("find my Rock Sack!", Mood.FIND)


async def test_a_choice_is_what_missions_and_questions_take(open_mesh: OpenMesh) -> None:
    async with open_mesh(BOTTLE) as mesh:
        told = await understand(mesh, "find the red bottle", "find the red apple")
        begun = await mesh.post_mission(told.choices[0].intent.command)
        assert begun.target == told.choices[0].intent.targets[0]


@pytest.mark.parametrize(
    "readings",
    [("find the cup, stop", "find the cup"), ("find the cup", "find the cup, stop"), ("find the cup.", "Stop.")],
)
async def test_a_stop_in_one_reading_is_enough(open_mesh: OpenMesh, readings: tuple[str, ...]) -> None:
    async with open_mesh(BOTTLE) as mesh:
        told = await understand(mesh, *readings)
        assert told.intent is not None
        assert told.intent.action is WantedAction.STOP


@pytest.mark.parametrize("readings", [(",",), ("find the cup", ","), ("red", "", "\u2068"), ("'", '"')])
async def test_a_reading_without_a_word_is_none(open_mesh: OpenMesh, readings: tuple[str, ...]) -> None:
    async with open_mesh(BOTTLE) as mesh:
        whole = await understand(mesh, *readings)
        worded = [reading for reading in readings if any(letter.isalpha() for letter in reading)]
        assert whole == (await understand(mesh, *worded) if worded else await understand(mesh, " "))
