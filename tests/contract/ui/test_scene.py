"""WS /live/scene: the map's parts that changed, and what the search holds probable only for who shows it."""

import json
from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from starlette.testclient import TestClient, WebSocketTestSession

from contracts.belief import NoBelief
from contracts.mission import MissionStatus, Outcome
from contracts.topics import MISSION_STATE
from support.ui_world import UiWorld, fresh_nicegui, mission, search_belief, status
from ui import belief_layer
from ui.app import create_app
from ui.settings import Settings

ANSWERS_MAX = 200
"""Each comes within two seconds, and the first that holds what is waited for ends the waiting."""


@dataclass
class Scene:
    socket: WebSocketTestSession
    client: TestClient
    world: UiWorld

    def tell(self, told: MissionStatus) -> None:
        assert self.client.portal is not None
        self.client.portal.call(self.world.bus.publish, MISSION_STATE, told)

    def asked(self, words: str) -> dict[str, Any]:
        self.socket.send_text(words)
        changed: dict[str, Any] = json.loads(self.socket.receive_text())
        return changed

    def belief(self, holds: Callable[[Any], bool]) -> Any:
        """The first that is as waited for."""
        for _ in range(ANSWERS_MAX):
            changed = self.asked("next belief")
            if "belief" in changed and holds(changed["belief"]):
                return changed["belief"]
        raise AssertionError("it did not come")


@contextmanager
def scene(world: UiWorld) -> Generator[Scene]:
    fresh_nicegui()
    app = create_app(
        Settings(belief_period_s=0.05, scene_period_s=0.05),
        bus=world.bus,
        robot=world.robot,
        inference=world.inference.client(),
        missions=world.missions,
        memory=world.memory,
    )
    with TestClient(app, base_url="http://127.0.0.1:8080") as client:
        assert client.get("/live/map.png").is_success
        with client.websocket_connect("/live/scene") as socket:
            opened = Scene(socket, client, world)
            opened.tell(status(mission()))
            yield opened


def test_who_does_not_show_it_is_not_sent_it_and_nobody_is_asked(world: UiWorld) -> None:
    world.missions.believed = search_belief()
    with scene(world) as shown:
        parts = {name for _ in range(5) for name in shown.asked("next")}
    assert "map" in parts
    assert "belief" not in parts
    assert world.missions.beliefs_asked == []


def test_who_shows_it_gets_the_belief_of_the_mission_under_way(world: UiWorld) -> None:
    world.missions.believed = search_belief()
    with scene(world) as shown:
        told = shown.belief(lambda one: one["png"] != "")
    assert (told["absent"], told["view"] is not None) == ("Not here: 20 %", True)
    assert set(world.missions.beliefs_asked) == {"m-1"}


def test_a_mission_that_has_none_says_why_and_one_that_is_over_is_not_asked_about(world: UiWorld) -> None:
    with scene(world) as shown:
        shown.belief(lambda one: one["why"] == belief_layer.MISSING[NoBelief.ANOTHER_RULE])
        shown.tell(status(mission(outcome=Outcome.NOT_FOUND)))
        shown.belief(lambda one: one["why"] == belief_layer.MISSING[NoBelief.ENDED])
        asked = len(world.missions.beliefs_asked)
        for _ in range(3):
            shown.asked("next belief")
    assert len(world.missions.beliefs_asked) == asked


def test_while_the_coordinator_is_away_no_old_belief_stays_on_the_map(world: UiWorld) -> None:
    world.missions.believed = search_belief()
    with scene(world) as shown:
        shown.belief(lambda one: one["png"] != "")
        world.missions.away = True
        told = shown.belief(lambda one: one["png"] == "")
    assert told["why"] == belief_layer.UNKNOWN
