"""Every Redis channel of the mesh: its name, message, one publisher and listeners, and whether its last value is kept.

Redis holds the services to it by `bus_rules`.
"""

import re
from dataclasses import dataclass
from typing import Any, Final, Generic, TypeVar

from contracts.base import Message
from contracts.description import RobotDescription
from contracts.mission import MissionEvent, MissionStatus, MissionTarget
from contracts.robot import EmergencyStop, Goal, RobotState
from contracts.vision import Detections, ObjectSpotted

M = TypeVar("M", bound=Message)

ENVELOPE: Final = re.compile(rb'^\{"traceparent":"([0-9a-f-]{55})",')
"""What may stand before a message's own fields: the trace it was said in, as W3C writes a `traceparent`."""


RECORDER: Final = "robot_bridge"
"""It listens to every topic, for its recordings."""


@dataclass(frozen=True, slots=True)
class Topic(Generic[M]):
    """A pub/sub channel carrying JSON. A kept topic's last value also lies under the key `last:<name>`."""

    name: str
    message: type[M]
    publisher: str
    listeners: tuple[str, ...]
    kept: bool = False

    @property
    def kept_key(self) -> str:
        return f"last:{self.name}"

    def encode(self, message: M, traceparent: str = "") -> bytes:
        """With the trace it is said in as its first field, where there is one."""
        data = message.model_dump_json().encode()
        return b'{"traceparent":"%s",%s' % (traceparent.encode(), data[1:]) if traceparent else data

    def decode(self, data: bytes) -> M:
        """Raises `pydantic.ValidationError` on anything that is not exactly this topic's message."""
        return self.message.model_validate_json(ENVELOPE.sub(b"{", data, count=1))


def traceparent_of(data: bytes) -> str:
    """Of the trace in which the message was said; '' where it was said in none."""
    found = ENVELOPE.match(data)
    return found[1].decode() if found is not None else ""


ROBOT_STATE = Topic("robot.state", RobotState, "robot_bridge", ("coordinator", "memory", "ui", RECORDER), kept=True)
ROBOT_DESCRIPTION = Topic(
    "robot.description", RobotDescription, "robot_bridge", ("coordinator", "memory", "ui", RECORDER), kept=True
)
ROBOT_NAVIGATION = Topic("robot.navigation", Goal, "robot_bridge", ("coordinator", "ui", RECORDER))
ROBOT_EMERGENCY_STOP = Topic(
    "robot.emergency_stop", EmergencyStop, "robot_bridge", ("coordinator", "ui", RECORDER), kept=True
)
VISION_DETECTIONS = Topic("vision.detections", Detections, "inference", ("coordinator", "memory", "ui", RECORDER))
VISION_OBJECT_SPOTTED = Topic("vision.object_spotted", ObjectSpotted, "inference", (RECORDER,))
MISSION_TARGET = Topic("mission.target", MissionTarget, "coordinator", ("inference", "ui", RECORDER), kept=True)
MISSION_STATE = Topic("mission.state", MissionStatus, "coordinator", ("ui", RECORDER), kept=True)
MISSION_EVENTS = Topic("mission.events", MissionEvent, "coordinator", ("ui", RECORDER))

ALL_TOPICS: tuple[Topic[Any], ...] = (
    ROBOT_STATE,
    ROBOT_DESCRIPTION,
    ROBOT_NAVIGATION,
    ROBOT_EMERGENCY_STOP,
    VISION_DETECTIONS,
    VISION_OBJECT_SPOTTED,
    MISSION_TARGET,
    MISSION_STATE,
    MISSION_EVENTS,
)


def bus_rules(service: str) -> tuple[str, ...]:
    """What a service may at Redis, as an ACL of Redis 6.2 has it: publish its own topics, hear those it listens to.

    A user's channels are one list there, so that a service which does both could publish what it only listens to.
    """
    said = [topic for topic in ALL_TOPICS if topic.publisher == service]
    heard = [topic for topic in ALL_TOPICS if service in topic.listeners]
    channels = sorted({f"&{topic.name}" for topic in (*said, *heard)})
    keys = sorted({f"~{topic.kept_key}" for topic in (*said, *heard) if topic.kept})
    publishing = ("+publish", "+multi", "+exec", "+set") if said else ()
    listening = ("+subscribe", "+unsubscribe", "+get") if heard else ()
    return (*keys, *channels, "+ping", "+hello", "+select", *publishing, *listening)
