"""What the operator does and comes to know, whoever is away."""

import asyncio
from collections.abc import AsyncIterator

import pytest

from contracts.access import Principal, Role
from contracts.actions import ExploreAction
from contracts.mission import Heard, Outcome
from contracts.reading import Mood
from contracts.robot import EmergencyStop
from contracts.topics import MISSION_EVENTS, MISSION_STATE, ROBOT_EMERGENCY_STOP, ROBOT_STATE, VISION_DETECTIONS
from contracts.vision import Detection, Detections
from mesh.access.middleware import ANYBODY
from mesh.tasks import Tasks
from support.fake_clock import FakeClock
from support.ui_world import STARTED_S, UiWorld, event, home_map, mission, robot_state, status, thing
from support.waiting import until
from ui.desk import Desk
from ui.library_actions import LibraryActions
from ui.operator_actions import ActionResult, OperatorActions
from ui.settings import Settings


@pytest.fixture
def world() -> UiWorld:
    return UiWorld()


@pytest.fixture
def clock() -> FakeClock:
    return FakeClock()


@pytest.fixture
async def desk(world: UiWorld, clock: FakeClock) -> AsyncIterator[Desk]:
    opened = Desk(
        settings=Settings(),
        bus=world.bus,
        robot=world.robot,
        inference=world.inference.client(),
        missions=world.missions,
        memory=world.memory,
        clock=clock,
    )
    async with Tasks() as tasks:
        opened.start(tasks)
        await until(lambda: world.bus.listened_to(MISSION_EVENTS))
        yield opened


@pytest.fixture
def actions(desk: Desk) -> OperatorActions:
    return OperatorActions(desk, lambda: ANYBODY)


async def test_a_command_is_passed_on_trimmed(actions: OperatorActions, world: UiWorld) -> None:
    result = await actions.command("  find the red bottle \n")
    assert (result.ok, result.text) == (True, "Looking for: red bottle")
    assert world.missions.commands == ["find the red bottle"]


async def test_a_refusal_is_told_in_the_words_of_the_service(actions: OperatorActions, world: UiWorld) -> None:
    world.missions.refusal = "nothing known in 'find the flux capacitor'"
    result = await actions.command("find the flux capacitor")
    assert (result.ok, result.text) == (False, "nothing known in 'find the flux capacitor'")


@pytest.mark.parametrize("text", ["", "   ", "x" * 501])
async def test_an_empty_or_endless_command_never_leaves_the_page(
    actions: OperatorActions, world: UiWorld, text: str
) -> None:
    assert not (await actions.command(text)).ok
    assert world.missions.commands == []


async def test_a_command_while_the_coordinator_is_away_names_it(actions: OperatorActions, world: UiWorld) -> None:
    world.missions.away = True
    result = await actions.command("find the cup")
    assert (result.ok, result.text) == (False, "coordinator: not reachable")


@pytest.mark.parametrize("text", ["stop", "STOP!!", "halt", "wait", "cancel that", "arrête", "emergency stop"])
@pytest.mark.parametrize("trouble", ["away", "hangs", "refusal"])
async def test_a_typed_stop_that_the_coordinator_does_not_confirm_is_the_emergency_stop(
    actions: OperatorActions, world: UiWorld, text: str, trouble: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("ui.operator_actions.OBEYED_S", 0.02)
    setattr(world.missions, trouble, "no" if trouble == "refusal" else True)
    result = await actions.command(text)
    assert (result.ok, [one.by for one in world.robot.stops]) == (True, ["page"])


async def test_a_typed_stop_that_was_obeyed_says_what_it_ended(actions: OperatorActions, world: UiWorld) -> None:
    world.missions.heard = Heard(mood=Mood.STOP, text="Stopped: the mission is over.", still=True)
    result = [await actions.command("stop"), await actions.ask("stop!")]
    assert result == [ActionResult(True, "Stopped: the mission is over.")] * 2
    assert (world.missions.commands, world.robot.stops) == (["stop", "stop!"], [])


async def test_pause_resume_and_cancel_mean_the_mission_that_is_shown(
    desk: Desk, actions: OperatorActions, world: UiWorld
) -> None:
    assert not (await actions.pause()).ok
    await world.bus.publish(MISSION_STATE, status(mission(id="m-7")))
    await until(lambda: desk.facts.mission_id == "m-7")
    for act in (actions.pause, actions.resume, actions.cancel):
        assert (await act()).ok
    assert world.missions.acted == [("pause", "m-7"), ("resume", "m-7"), ("cancel", "m-7")]


async def test_halting_by_hand_never_ends_what_a_mission_drives_to(
    desk: Desk, actions: OperatorActions, world: UiWorld
) -> None:
    await world.bus.publish(MISSION_STATE, status(mission()))
    await until(lambda: desk.facts.mission_id == "m-1")
    result = await actions.halt()
    assert (result.ok, result.text) == (False, "A mission is running. Pause it first.")
    assert world.robot.asked == []
    await world.bus.publish(MISSION_STATE, status(mission(paused=True)))
    await until(lambda: desk.facts.mission is not None and desk.facts.mission.mission == mission(paused=True))
    assert (await actions.halt()).ok
    assert world.robot.asked == ["end motion"]


async def test_what_is_seen_while_somebody_watches_gets_its_picture(desk: Desk, world: UiWorld) -> None:
    stamp_s = STARTED_S + 1.0
    one = Detection(label="bottle", confidence=0.9, bbox_xyxy=(200, 140, 270, 254))
    seen = Detections(stamp_s=stamp_s, image_width_px=480, image_height_px=502, detections=(one,))
    world.memory.things = [thing(1, last_seen_s=stamp_s)]
    await world.bus.publish(VISION_DETECTIONS, seen)
    await until(lambda: desk.facts.detections == seen)
    assert world.robot.frames == 0
    await desk.refresh()
    await world.bus.publish(VISION_DETECTIONS, seen)
    await until(lambda: world.robot.frames >= 1)
    await until(lambda: desk.thumbnails.known("bottle", stamp_s))
    await desk.refresh_memory(now=True)
    assert desk.thumbnails.version(1) == stamp_s


async def test_docking_tells_how_it_went(actions: OperatorActions) -> None:
    assert (await actions.dock()).ok
    result = await actions.undock()
    assert (result.ok, result.text) == (False, "It did not undock: the base gave up")


async def test_reset_is_told_and_shown(desk: Desk, actions: OperatorActions, world: UiWorld) -> None:
    await actions.emergency_stop(reason="a test", by="test")
    assert desk.facts.stop is not None
    assert desk.facts.stop.latched
    assert (await actions.reset(by="test")).ok
    assert not desk.facts.stop.latched
    assert len(world.robot.resets) == 1


async def test_facts_come_from_the_bus(desk: Desk, world: UiWorld) -> None:
    await world.bus.publish(ROBOT_STATE, robot_state())
    await world.bus.publish(MISSION_STATE, status(mission()))
    await world.bus.publish(MISSION_EVENTS, event(1, "begun"))
    await world.bus.publish(ROBOT_EMERGENCY_STOP, EmergencyStop(latched=True, epoch=3))
    await until(lambda: desk.facts.stop is not None and desk.facts.stop.epoch == 3)
    await until(lambda: [one.text for one in desk.facts.events] == ["begun"])
    assert desk.facts.robot is not None
    assert desk.facts.mission_id == "m-1"


async def test_without_redis_the_services_are_asked(desk: Desk, world: UiWorld) -> None:
    world.bus.connected = False
    world.missions.current = status(mission())
    world.missions.timeline = (event(1, "begun"), event(2, "going"))
    await desk.refresh()
    assert [service.name for service in desk.facts.services if not service.ok] == ["redis"]
    assert desk.facts.robot is not None
    assert [one.text for one in desk.facts.events] == ["begun", "going"]


async def test_what_was_told_before_this_process_began_is_fetched_once(desk: Desk, world: UiWorld) -> None:
    world.missions.timeline = (event(1, "begun"),)
    await world.bus.publish(MISSION_STATE, status(mission()))
    await until(lambda: desk.facts.mission_id == "m-1")
    await desk.refresh()
    assert [one.text for one in desk.facts.events] == ["begun"]


async def test_however_many_ask_the_services_are_asked_once_a_period(
    desk: Desk, world: UiWorld, clock: FakeClock
) -> None:
    await asyncio.gather(*(desk.refresh() for _ in range(20)))
    assert world.robot.asked == ["map", "state"]
    await clock.advance(desk.settings.health_period_s + 0.1)
    await asyncio.gather(*(desk.refresh() for _ in range(20)))
    assert world.robot.asked == ["map", "state", "state"]


async def test_everything_away_is_named_and_nothing_raises(desk: Desk, world: UiWorld) -> None:
    world.bus.connected = False
    for service in (world.missions, world.inference, world.memory, world.robot):
        service.away = True
    await desk.refresh()
    assert [service.ok for service in desk.facts.services] == [False] * 5


async def test_a_broken_map_leaves_the_last_one_standing(desk: Desk, world: UiWorld, clock: FakeClock) -> None:
    await desk.refresh()
    before = desk.picture
    world.robot.grid = home_map().model_copy(update={"data_base64": "AAAA"})
    await clock.advance(desk.settings.map_period_s + 0.1)
    await desk.refresh()
    assert before is not None
    assert desk.picture is before


async def test_a_viewer_may_type_a_stop_and_no_mission(desk: Desk, world: UiWorld) -> None:
    actions = OperatorActions(desk, lambda: Principal(name="vera", role=Role.VIEWER))
    assert not (await actions.command("find the red bottle")).ok
    assert (await actions.command("emergency stop")).ok
    assert len(world.robot.stops) == 1


EXPLORING = ExploreAction(duration_s=120.0)


@pytest.fixture
def library(desk: Desk, actions: OperatorActions, world: UiWorld) -> LibraryActions:
    """Nothing runs, and nothing waits."""
    desk.facts.take_mission(status(), 0.0)
    return LibraryActions(desk, actions)


async def test_a_button_begins_its_action_of_the_library(library: LibraryActions, world: UiWorld) -> None:
    assert await library.begin(EXPLORING) == ActionResult(True, "Begun: explore")
    assert world.missions.done == [EXPLORING]


async def test_an_action_is_refused_to_whom_has_not_its_role(desk: Desk, world: UiWorld) -> None:
    vera = OperatorActions(desk, lambda: Principal(name="vera", role=Role.VIEWER))
    refused = await LibraryActions(desk, vera).begin(EXPLORING)
    assert refused == ActionResult(False, "This needs the role operator; yours is viewer.")
    assert world.missions.done == []


async def test_an_action_is_refused_with_the_reason_while_something_else_has_the_robot(
    desk: Desk, library: LibraryActions, world: UiWorld
) -> None:
    desk.driver = object()
    assert "drives the robot by hand" in (await library.begin(EXPLORING)).text
    desk.driver = None
    for busy in (status(mission()), status(mission(paused=True)), status(queue=(mission(queue_position=0),))):
        desk.facts.take_mission(busy, 0.0)
        assert await library.begin(EXPLORING) == ActionResult(
            False, "A mission is running or waits. Cancel it first, or wait for its end."
        )
    desk.facts.take_mission(status(mission(outcome=Outcome.FOUND)), 0.0)
    desk.facts.take_stop(EmergencyStop(latched=True, epoch=1), 0.0)
    assert await library.begin(EXPLORING) == ActionResult(False, "The robot is stopped. Resume first.")
    assert world.missions.done == []


async def test_what_the_coordinator_refuses_is_told_in_its_words(library: LibraryActions, world: UiWorld) -> None:
    world.missions.refusal = "the battery is at 9 %: it has to charge first"
    assert await library.begin(EXPLORING) == ActionResult(False, "the battery is at 9 %: it has to charge first")
