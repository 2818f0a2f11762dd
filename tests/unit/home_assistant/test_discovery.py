"""What Home Assistant is told, held against the fields that its MQTT integration publishes."""

import json
import re
from typing import Any, Final

import pytest

from contracts.geometry import Pose2D
from contracts.mission import Heard, Mission, MissionState, MissionStatus, Outcome, SearchedRoom
from contracts.reading import Mood
from contracts.robot import Battery, EmergencyStop, RobotState
from contracts.vision import Target
from home_assistant import states
from home_assistant.discovery import COMPONENTS, Entity, Topics, configs
from home_assistant.settings import Settings

COMMON: Final = {
    "availability_topic", "payload_available", "payload_not_available", "device", "origin", "unique_id", "name", "icon",
    "json_attributes_topic", "entity_category", "enabled_by_default", "object_id", "qos", "encoding",
}  # fmt: skip
"""Of any entity: home-assistant/core, components/mqtt, `MQTT_ENTITY_COMMON_SCHEMA`."""
OWN: Final[dict[str, tuple[set[str], set[str]]]] = {
    "sensor": ({"state_topic"}, {"device_class", "options", "unit_of_measurement", "state_class", "expire_after",
                                 "force_update", "value_template", "suggested_display_precision"}),
    "button": ({"command_topic"}, {"payload_press", "device_class", "retain", "command_template"}),
    "text": ({"command_topic"}, {"state_topic", "min", "max", "mode", "pattern", "value_template", "command_template",
                                 "retain"}),
    "camera": ({"topic"}, {"image_encoding"}),
}  # fmt: skip
"""Required and optional fields of each kind: sensor.py, button.py, text.py, camera.py beside it."""
DEVICE: Final = {
    "identifiers", "connections", "manufacturer", "model", "model_id", "name", "hw_version", "serial_number",
    "sw_version", "via_device", "suggested_area", "configuration_url",
}  # fmt: skip
ORIGIN: Final = {"name", "sw_version", "support_url"}
DISCOVERY_TOPIC: Final = re.compile(r"homeassistant/(sensor|button|text|camera)/[a-zA-Z0-9_-]+/[a-zA-Z0-9_-]+/config")
"""`<discovery_prefix>/<component>/[<node_id>/]<object_id>/config`."""

SETTINGS: Final = Settings(camera=True, page_url="http://robot.local:8080")
TOLD: Final = configs(SETTINGS.identity)


@pytest.mark.parametrize("entity", list(Entity))
def test_each_message_has_the_published_fields_and_no_other(entity: Entity) -> None:
    config = TOLD[entity]
    assert config is not None
    required, optional = OWN[COMPONENTS[entity]]
    assert required <= set(config)
    assert set(config) <= required | optional | COMMON
    assert set(config["device"]) <= DEVICE
    assert config["device"]["identifiers"]
    assert {"name"} <= set(config["origin"]) <= ORIGIN
    assert DISCOVERY_TOPIC.fullmatch(Topics.of(SETTINGS.identity).config(entity))
    assert json.loads(json.dumps(config)) == config


def test_no_topic_that_is_published_to_has_a_wildcard_and_ids_are_one_of_a_kind() -> None:
    every: list[Any] = [config for config in TOLD.values() if config is not None]
    topics = [value for config in every for name, value in config.items() if name.endswith("topic")]
    assert topics
    assert not [topic for topic in topics if re.search(r"[#+\x00]", topic)]
    assert len({config["unique_id"] for config in every}) == len(every)


def test_a_text_is_no_longer_than_home_assistant_takes_and_an_enum_names_every_state() -> None:
    find, state = TOLD[Entity.FIND], TOLD[Entity.STATE]
    assert find is not None
    assert 0 < find["min"] < find["max"] <= 255
    assert state is not None
    assert {one.value.lower() for one in MissionState} | {"paused"} == set(state["options"])
    assert state["device_class"] == "enum"
    assert "unit_of_measurement" not in state  # an enum has none


def test_without_a_camera_the_one_that_was_there_is_taken_away() -> None:
    assert configs(Settings().identity)[Entity.CAMERA] is None


@pytest.mark.parametrize("wrong", [{"robot_id": "a b"}, {"topic_prefix": "a/#"}, {"discovery_prefix": "+"}])
def test_what_is_no_topic_is_refused(wrong: dict[str, str]) -> None:
    with pytest.raises(ValueError, match="pattern"):
        Settings.model_validate(wrong)


def robot(*, latched: bool = False, percent: float | None = 41.6) -> RobotState:
    battery = Battery(percentage=percent) if percent is not None else None
    return RobotState(stamp_s=1.0, battery=battery, emergency_stop=EmergencyStop(latched=latched, epoch=1))


def mission(**changes: Any) -> Mission:
    told = {
        "id": "m", "command": "find the red bottle", "target": Target(label="bottle", description="red bottle"),
        "state": MissionState.IDLE, "started_s": 1.0,
    }  # fmt: skip
    return Mission.model_validate(told | changes)


@pytest.mark.parametrize(
    ("status", "of", "text"),
    [
        (MissionStatus(stamp_s=1.0), robot(), "idle"),
        (MissionStatus(stamp_s=1.0, state=MissionState.SCANNING), None, "scanning"),
        (MissionStatus(stamp_s=1.0, state=MissionState.SCANNING, mission=mission(paused=True)), robot(), "paused"),
        (MissionStatus(stamp_s=1.0, state=MissionState.SCANNING), robot(latched=True), "emergency_stop"),
        (None, robot(latched=True), "emergency_stop"),
        (None, robot(), states.UNKNOWN),
    ],
)
def test_the_state_is_the_missions_and_a_stop_comes_first(
    status: MissionStatus | None, of: RobotState | None, text: str
) -> None:
    assert states.state_of(status, of) == text


def test_a_battery_that_nobody_knows_is_unknown() -> None:
    assert states.battery_of(robot()) == "42"
    assert {states.battery_of(robot(percent=None)), states.battery_of(None)} == {states.UNKNOWN}


def test_the_last_found_is_the_newest_find_with_its_place() -> None:
    found = mission(
        outcome=Outcome.FOUND, ended_s=0.0, target_pose=Pose2D(x=1.234, y=2.0, yaw=0.0), measured_distance_m=0.456,
        rooms=(SearchedRoom(id=1, name="kitchen"),),
    )  # fmt: skip
    newest = [mission(), mission(outcome=Outcome.NOT_FOUND), found, mission(outcome=Outcome.FOUND)]
    assert states.last_found(newest) is found
    assert states.found_text(found) == "red bottle"
    assert json.loads(states.found_attributes(found)) == {
        "command": "find the red bottle", "found_at": "1970-01-01T00:00:00+00:00", "x_m": 1.23, "y_m": 2.0,
        "distance_m": 0.46, "rooms": ["kitchen"],
    }  # fmt: skip
    assert (states.found_text(states.last_found([])), states.found_attributes(None)) == (states.UNKNOWN, "{}")


def test_an_answer_is_no_longer_than_a_state_may_be() -> None:
    assert states.answer_to(mission()) == "looking for: red bottle"
    assert states.answer_to(mission(queue_position=1)) == "queued: red bottle"
    assert len(states.answer_to(Heard(mood=Mood.STOP, text="x" * 500))) == 255
