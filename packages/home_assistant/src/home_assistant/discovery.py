"""What Home Assistant is told of the robot by MQTT discovery, and the topics that both sides use. Pure.

The fields are those of Home Assistant's MQTT integration (sensor, button, text and camera), one retained message an
entity, as every version since 2023 reads them.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from contracts.mission import MissionState

ONLINE, OFFLINE = "online", "offline"
PRESS = "PRESS"
PAUSED = "paused"
FIND_MAX = 255
"""Home Assistant's longest text; a state may be no longer either."""

Config = Mapping[str, Any]


class Entity(StrEnum):
    STATE = "state"
    BATTERY = "battery"
    LAST_FOUND = "last_found"
    ANSWER = "answer"
    """What came of the last thing that was asked for here."""
    STOP = "stop"
    DOCK = "dock"
    FIND = "find"
    CAMERA = "camera"


COMPONENTS: Mapping[Entity, str] = {
    Entity.STATE: "sensor",
    Entity.BATTERY: "sensor",
    Entity.LAST_FOUND: "sensor",
    Entity.ANSWER: "sensor",
    Entity.STOP: "button",
    Entity.DOCK: "button",
    Entity.FIND: "text",
    Entity.CAMERA: "camera",
}
"""Of Home Assistant."""


@dataclass(frozen=True, slots=True)
class RobotIdentity:
    """Which robot it is to Home Assistant, and what of it is shown there."""

    robot_id: str
    name: str
    discovery_prefix: str
    topic_prefix: str
    page_url: str | None = None
    camera: bool = False
    version: str = ""


@dataclass(frozen=True, slots=True)
class Topics:
    """Of one robot."""

    discovery_prefix: str
    base: str
    robot_id: str

    @classmethod
    def of(cls, one: RobotIdentity) -> "Topics":
        return cls(one.discovery_prefix, f"{one.topic_prefix}/{one.robot_id}", one.robot_id)

    @property
    def availability(self) -> str:
        return f"{self.base}/availability"

    @property
    def birth(self) -> str:
        """Where Home Assistant says that it has begun, and listens."""
        return f"{self.discovery_prefix}/status"

    def config(self, entity: Entity) -> str:
        return f"{self.discovery_prefix}/{COMPONENTS[entity]}/{self.robot_id}/{entity.value}/config"

    def state(self, entity: Entity) -> str:
        return f"{self.base}/{entity.value}"

    def attributes(self, entity: Entity) -> str:
        return f"{self.base}/{entity.value}/attributes"

    def command(self, entity: Entity) -> str:
        return f"{self.base}/{entity.value}/set"


def configs(one: RobotIdentity) -> dict[Entity, Config | None]:
    """The message for each entity; none: there is no such entity, and one that was there is taken away."""
    topics = Topics.of(one)
    shared = _shared(one, topics)
    own: dict[Entity, Config | None] = {
        Entity.STATE: {
            "name": "State",
            "state_topic": topics.state(Entity.STATE),
            "device_class": "enum",
            "options": [*(state.value.lower() for state in MissionState), PAUSED],
            "icon": "mdi:robot",
        },
        Entity.BATTERY: {
            "name": "Battery",
            "state_topic": topics.state(Entity.BATTERY),
            "device_class": "battery",
            "unit_of_measurement": "%",
            "state_class": "measurement",
        },
        Entity.LAST_FOUND: {
            "name": "Last found",
            "state_topic": topics.state(Entity.LAST_FOUND),
            "json_attributes_topic": topics.attributes(Entity.LAST_FOUND),
            "icon": "mdi:map-marker-check",
        },
        Entity.ANSWER: {
            "name": "Answer",
            "state_topic": topics.state(Entity.ANSWER),
            "icon": "mdi:message-reply-text",
        },
        Entity.STOP: {
            "name": "Stop",
            "command_topic": topics.command(Entity.STOP),
            "payload_press": PRESS,
            "icon": "mdi:stop-circle",
        },
        Entity.DOCK: {
            "name": "Dock",
            "command_topic": topics.command(Entity.DOCK),
            "payload_press": PRESS,
            "icon": "mdi:home-import-outline",
        },
        Entity.FIND: {
            "name": "Find",
            "command_topic": topics.command(Entity.FIND),
            "state_topic": topics.state(Entity.FIND),
            "min": 1,
            "max": FIND_MAX,
            "icon": "mdi:magnify",
        },
        Entity.CAMERA: {"name": "Camera", "topic": topics.state(Entity.CAMERA)} if one.camera else None,
    }
    return {
        entity: None if config is None else {**config, **shared, "unique_id": f"{one.robot_id}_{entity.value}"}
        for entity, config in own.items()
    }


def _shared(one: RobotIdentity, topics: Topics) -> Config:
    device: dict[str, Any] = {
        "identifiers": [f"atom_{one.robot_id}"],
        "name": one.name,
        "manufacturer": "ATOM",
        "model": "Home robot",
        "sw_version": one.version,
    }
    if one.page_url is not None:
        device["configuration_url"] = one.page_url
    return {
        "availability_topic": topics.availability,
        "payload_available": ONLINE,
        "payload_not_available": OFFLINE,
        "device": device,
        "origin": {"name": "ATOM", "sw_version": one.version},
    }
