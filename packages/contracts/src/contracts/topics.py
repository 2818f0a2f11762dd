"""Every Redis channel of the mesh: its name, its message, its single publisher, and whether the last value is kept."""

from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from contracts.base import Message
from contracts.description import RobotDescription
from contracts.mission import MissionEvent, MissionStatus, MissionTarget
from contracts.robot import EmergencyStop, Goal, RobotState
from contracts.vision import Detections, ObjectSpotted

M = TypeVar("M", bound=Message)


@dataclass(frozen=True, slots=True)
class Topic(Generic[M]):
    """A pub/sub channel carrying JSON. A kept topic's last value also lies under the key `last:<name>`."""

    name: str
    message: type[M]
    publisher: str
    kept: bool = False

    def encode(self, message: M) -> bytes:
        return message.model_dump_json().encode()

    def decode(self, data: bytes) -> M:
        """Raises `pydantic.ValidationError` on anything that is not exactly this topic's message."""
        return self.message.model_validate_json(data)


ROBOT_STATE = Topic("robot.state", RobotState, "robot_bridge", kept=True)
ROBOT_DESCRIPTION = Topic("robot.description", RobotDescription, "robot_bridge", kept=True)
ROBOT_NAVIGATION = Topic("robot.navigation", Goal, "robot_bridge")
ROBOT_EMERGENCY_STOP = Topic("robot.emergency_stop", EmergencyStop, "robot_bridge", kept=True)
VISION_DETECTIONS = Topic("vision.detections", Detections, "inference")
VISION_OBJECT_SPOTTED = Topic("vision.object_spotted", ObjectSpotted, "inference")
MISSION_TARGET = Topic("mission.target", MissionTarget, "coordinator", kept=True)
MISSION_STATE = Topic("mission.state", MissionStatus, "coordinator", kept=True)
MISSION_EVENTS = Topic("mission.events", MissionEvent, "coordinator")

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
