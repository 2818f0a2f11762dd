"""What is said to `POST /missions` beside askings: orders are obeyed at once, denials start nothing, and it says so."""

import asyncio
import time

import pytest

from bench import people
from contracts.mission import CommandRefusal, Heard, Mission, MissionState, Outcome
from contracts.reading import Mood
from contracts.vision import ParsedTask, ParseTaskRequest
from inference.language.providers import Providers
from inference.parsing.task_parsing import Reader
from mesh.clock import SystemClock
from support.coordinator_mesh import Mesh, opened_mesh
from support.coordinator_world import FakeInference, Thing

BOTTLE = Thing("bottle", "red", 8.0, 6.5)
STOPS = ("stop", "stop!", "halt", "wait, stop", "cancel that", "stop moving", "no, stop it", "freeze", "that's enough",
         "abort", "stop looking for the bottle", "sotp", "STOP STOP", "never mind", "never mind the bottle", "dừng lại",
         "hör auf!", "arrête", "¡alto!", "fermati", "pare agora", "hou op", "dur", "find the cup. no, stop!",
         "I found the bottle, thanks", "I already found my bottle", "not now")  # fmt: skip
STOPPED_WITHIN_S = 0.2
"""Of this process's own time, so that a busy machine does not count."""


class Reading(FakeInference):
    """Reads as the service does by its rules."""

    async def parse_task(self, request: ParseTaskRequest) -> ParsedTask:
        none = Providers.of((), retry_after_s=1.0, clock=SystemClock())
        return await Reader(none, none, 8.0).parse(request)


@pytest.fixture(autouse=True)
def _eyes_that_read(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(FakeInference, "parse_task", Reading.parse_task)


async def said(mesh: Mesh, text: str) -> Heard:
    response = await mesh.client.post("/missions", json={"command": text})
    assert response.status_code == 200, response.text
    return Heard.model_validate_json(response.content)


async def refused(mesh: Mesh, text: str, status: int = 422) -> tuple[str, str]:
    response = await mesh.client.post("/missions", json={"command": text})
    assert response.status_code == status, response.text
    return response.json()["code"], response.json()["detail"]


async def under_way(mesh: Mesh) -> Mission:
    mission = await mesh.post_mission("find the red bottle")
    await mesh.clock.advance(4.0)
    return mission


@pytest.mark.parametrize("text", STOPS)
async def test_what_a_person_says_to_end_it_ends_it_though_nobody_else_answers(
    text: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with opened_mesh(BOTTLE) as mesh:
        running = await under_way(mesh)
        later = await mesh.post_mission("find the bottle")
        monkeypatch.setattr(FakeInference, "parse_task", lambda *_: asyncio.Event().wait())
        mesh.memory.away = True
        began_s = time.process_time()
        heard = await said(mesh, text)
        took_s = time.process_time() - began_s
        ended = [await mesh.mission(one) for one in (running.id, later.id)]
        standing = mesh.world.pose
        await mesh.clock.advance(1.5)
        assert [one.outcome for one in ended] == [Outcome.CANCELED, Outcome.CANCELED]
        assert (set(heard.ended), mesh.world.pose) == ({running.id, later.id}, standing)
        assert took_s < STOPPED_WITHIN_S


async def test_a_stop_does_not_wait_for_a_command_that_is_being_read_and_that_never_starts(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async with opened_mesh(BOTTLE) as mesh:
        reads = asyncio.Event()
        real = FakeInference.parse_task

        async def slow(self: FakeInference, request: ParseTaskRequest) -> ParsedTask:
            await reads.wait()
            return await real(self, request)

        monkeypatch.setattr(FakeInference, "parse_task", slow)
        asking = asyncio.create_task(mesh.client.post("/missions", json={"command": "find the red bottle"}))
        waiting = asyncio.create_task(mesh.client.post("/missions", json={"command": "find the cup"}))
        await mesh.clock.advance(0.5)
        assert (await said(mesh, "stop")).mood is Mood.STOP
        reads.set()
        answers = [await asking, await waiting]
        await mesh.clock.advance(1.5)
        assert [(one.status_code, one.json()["code"]) for one in answers] == [
            (409, CommandRefusal.STOPPED_MEANWHILE)
        ] * 2
        assert mesh.world.moves == []


async def test_a_stop_reaches_a_mission_that_is_about_to_begin(monkeypatch: pytest.MonkeyPatch) -> None:
    async with opened_mesh(BOTTLE) as mesh:
        recalls = asyncio.Event()
        real = mesh.memory.recall
        monkeypatch.setattr(mesh.memory, "recall", lambda request: _after(recalls, real(request)))
        asking = asyncio.create_task(mesh.client.post("/missions", json={"command": "find the red bottle"}))
        await mesh.clock.advance(0.5)
        heard = await said(mesh, "stop")
        recalls.set()
        mission = await mesh.mission((await asking).json()["id"])
        await mesh.clock.advance(1.5)
        assert (heard.ended, mission.outcome, mesh.world.moves) == ((mission.id,), Outcome.CANCELED, [])


async def _after(event: asyncio.Event, work: "asyncio.Future[object]") -> object:
    await event.wait()
    return await work


async def test_a_stop_ends_what_others_asked_the_robot_for_too() -> None:
    async with opened_mesh(BOTTLE) as mesh:
        heard = await said(mesh, "stop")
        assert (heard.still, heard.ended, mesh.robot.halts) == (True, (), 1)


async def test_a_halt_nobody_answers_becomes_an_emergency_stop_and_then_the_robots_own_button(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("coordinator.commands.orders.STILL_S", 0.02)
    async with opened_mesh(BOTTLE) as mesh:
        mesh.robot.hangs = {"halt"}
        assert "emergency stop is set" in (await said(mesh, "stop")).text
        mesh.robot.hangs = {"halt", "emergency_stop"}
        heard = await said(mesh, "stop")
        assert (heard.still, "own stop button" in heard.text) == (False, True)


@pytest.mark.parametrize("text", ["emergency stop", "EMERGENCY!", "e-stop", "Not-Aus"])
async def test_an_emergency_latches_the_stop(text: str) -> None:
    async with opened_mesh(BOTTLE) as mesh:
        running = await under_way(mesh)
        heard = await said(mesh, text)
        assert (heard.mood, mesh.world.stop.latched) == (Mood.EMERGENCY, True)
        assert (await mesh.mission(running.id)).outcome is not None
        assert (await refused(mesh, "find the bottle", 409))[1].startswith("the emergency stop is latched")
        assert (await refused(mesh, "go on", 409))[0] == Mood.RESUME


@pytest.mark.parametrize(("wait", "go_on"), [("wait", "go on"), ("hold on a second", "continue"), ("espera", "sigue")])
async def test_wait_pauses_and_go_on_resumes(wait: str, go_on: str) -> None:
    async with opened_mesh(BOTTLE) as mesh:
        running = await under_way(mesh)
        assert (await said(mesh, wait)).mood is Mood.PAUSE
        await mesh.clock.advance(1.0)
        standing = mesh.world.pose
        await mesh.clock.advance(1.5)
        paused = await mesh.mission(running.id)
        assert (paused.paused, paused.outcome, mesh.world.pose) == (True, None, standing)
        assert (await said(mesh, go_on)).mood is Mood.RESUME
        assert not (await mesh.mission(running.id)).paused
        assert (await refused(mesh, go_on, 409))[0] == Mood.RESUME


async def test_wait_said_to_a_robot_that_stands_to_listen_holds_it_until_a_person_says() -> None:
    async with opened_mesh(BOTTLE) as mesh:
        running = await under_way(mesh)
        await mesh.client.post(f"/missions/{running.id}/pause", params={"for_s": 2.0})
        assert (await said(mesh, "wait")).mood is Mood.PAUSE
        await mesh.clock.advance(10.0)
        assert (await mesh.mission(running.id)).paused


async def test_a_wait_while_nothing_runs_ends_all_motion() -> None:
    async with opened_mesh(BOTTLE) as mesh:
        assert (await said(mesh, "wait")).still
        assert mesh.robot.halts == 1


async def test_a_stop_with_another_wish_behind_it_stops_first_and_then_looks_for_that() -> None:
    async with opened_mesh(BOTTLE) as mesh:
        running = await under_way(mesh)
        answer = await mesh.client.post("/missions", json={"command": "stop and find the blue bottle"})
        assert (answer.status_code, answer.json()["target"]["description"]) == (201, "blue bottle")
        assert (await mesh.mission(running.id)).outcome is Outcome.CANCELED
        await mesh.clock.advance(4.0)
        assert (await mesh.mission(answer.json()["id"])).outcome is None


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("don't find the cup", Mood.DENIED), ("no need to find the cup", Mood.DENIED), ("never mind", Mood.DENIED),
        ("find the cup, never mind", Mood.DENIED), ("find the bottle... no, never mind, I have it", Mood.DENIED),
        ("I already found the bottle", Mood.STATEMENT), ("I found my phone, thanks", Mood.THANKS),
        ("thank you for finding the bottle", Mood.THANKS), ("she said find the cup", Mood.STATEMENT),
        ("if you see the cup, tell me", Mood.CONDITION), ("find the cup in ten minutes", Mood.LATER),
        ("how many bottles are there", Mood.COUNT), ("what changed?", Mood.QUESTION),
        ("kırmızı şişeyi bul", Mood.UNKNOWN), ("such den Ball nicht", Mood.UNKNOWN),
        ("don't stop", CommandRefusal.NAMES_NOTHING),
        ("find the bike lights", CommandRefusal.NAMES_NOTHING), ("find anything red", CommandRefusal.WHICH_THING),
    ],
)  # fmt: skip
async def test_what_asks_for_nothing_starts_nothing_and_is_told_what_it_was_taken_for(text: str, code: str) -> None:
    async with opened_mesh(BOTTLE) as mesh:
        told, detail = await refused(mesh, text)
        await mesh.clock.advance(1.5)
        assert (told, bool(detail), mesh.world.moves) == (code, True, [])


async def test_nothing_of_the_peoples_table_sets_out_that_did_not_ask_to() -> None:
    async with opened_mesh(BOTTLE, queue_max=50) as mesh:
        others = [row["text"] for row in people.rows() if row["mood"] != Mood.FIND]
        codes = [(await mesh.client.post("/missions", json={"command": text})).status_code for text in others]
        await mesh.clock.advance(2.0)
        assert [text for text, code in zip(others, codes, strict=True) if code == 201] == []
        assert mesh.world.moves == []


async def test_a_model_cannot_turn_a_denial_into_a_search_nor_name_what_was_not_asked(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async def lies(self: FakeInference, request: ParseTaskRequest) -> ParsedTask:
        claim = {"said": "find the cup", "yolo_class": "cup", "description": "cup", "parser": "ollama:lies"}
        return ParsedTask.model_validate({"targets": (claim,)})

    monkeypatch.setattr(FakeInference, "parse_task", lies)
    async with opened_mesh(BOTTLE) as mesh:
        assert (await refused(mesh, "don't find the cup"))[0] == Mood.DENIED
        assert (await said(mesh, "stop")).mood is Mood.STOP
        assert (await refused(mesh, "don't find the cup, find the bottle"))[0] == CommandRefusal.NAMES_NOTHING


async def test_another_wish_goes_on_when_one_is_taken_back() -> None:
    async with opened_mesh(BOTTLE) as mesh:
        running = await under_way(mesh)
        assert (await refused(mesh, "never mind the cup"))[0] == Mood.DENIED
        assert (await mesh.mission(running.id)).outcome is None


async def test_what_was_said_and_is_not_held_to_is_told() -> None:
    async with opened_mesh(BOTTLE) as mesh:
        mission = await mesh.post_mission("find two of my wife's bottles, not the blue one")
        started = (await mesh.timeline(mission.id))[0].text
        assert mission.target is not None
        assert mission.target.not_colours == ("blue",)
        assert ("not held to" in started, "two" in started, "wifes" in started or "wife's" in started) == (
            True,
            True,
            True,
        )


async def test_anything_of_a_colour_asks_back_with_what_memory_knows() -> None:
    async with opened_mesh(BOTTLE) as mesh:
        assert "Which red thing?" in (await refused(mesh, "find anything red"))[1]


async def test_it_says_that_it_stands_while_paused() -> None:
    async with opened_mesh(BOTTLE) as mesh:
        await under_way(mesh)
        await said(mesh, "pause the search")
        await said(mesh, "wait")
        state = (await mesh.client.get("/state")).json()
        assert state["mission"]["paused"]
        assert MissionState(state["state"]) is not MissionState.IDLE
