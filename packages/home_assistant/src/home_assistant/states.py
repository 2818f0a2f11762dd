"""What Home Assistant shows of the robot: from the services' answers to the text of a topic. Pure."""

import json
from collections.abc import Sequence
from datetime import UTC, datetime

from contracts.mission import Heard, Mission, MissionState, MissionStatus, Outcome
from contracts.robot import RobotState
from home_assistant.discovery import FIND_MAX, PAUSED

UNKNOWN = "None"
"""What Home Assistant takes for a state that nobody knows."""


def state_of(status: MissionStatus | None, robot: RobotState | None) -> str:
    """The stop comes first, whoever else is away."""
    if robot is not None and robot.emergency_stop.latched:
        return MissionState.EMERGENCY_STOP.value.lower()
    if status is None:
        return UNKNOWN
    paused = status.mission is not None and status.mission.outcome is None and status.mission.paused
    return PAUSED if paused else status.state.value.lower()


def battery_of(robot: RobotState | None) -> str:
    if robot is None or robot.battery is None or robot.battery.percentage is None:
        return UNKNOWN
    return str(round(robot.battery.percentage))


def last_found(missions: Sequence[Mission]) -> Mission | None:
    """Of missions, newest first."""
    return next((one for one in missions if one.outcome is Outcome.FOUND and one.target is not None), None)


def found_text(mission: Mission | None) -> str:
    return UNKNOWN if mission is None or mission.target is None else mission.target.description[:FIND_MAX]


def found_attributes(mission: Mission | None) -> str:
    """As JSON; times in ISO 8601, places in m of the map."""
    if mission is None:
        return "{}"
    place = mission.target_pose
    told = {
        "command": mission.command,
        "found_at": None if mission.ended_s is None else datetime.fromtimestamp(mission.ended_s, UTC).isoformat(),
        "x_m": None if place is None else round(place.x, 2),
        "y_m": None if place is None else round(place.y, 2),
        "distance_m": None if mission.measured_distance_m is None else round(mission.measured_distance_m, 2),
        "rooms": [one.name for one in mission.rooms],
    }
    return json.dumps(told)


def answer_to(started: Mission | Heard) -> str:
    """What came of a command."""
    if isinstance(started, Heard):
        return started.text[:FIND_MAX]
    what = started.target.description if started.target is not None else started.command
    return f"{'looking for' if started.queue_position is None else 'queued'}: {what}"[:FIND_MAX]
