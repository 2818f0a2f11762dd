"""Following one mission: its events as they come, and the robot's track."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import httpx
from pydantic import TypeAdapter

from contracts.geometry import Pose2D
from contracts.mission import Mission, MissionEvent
from contracts.robot import RobotState
from demo.stack import Ports, StackError

EVENTS = TypeAdapter(list[MissionEvent])


@dataclass
class Watched:
    mission: Mission
    track: list[Pose2D] = field(default_factory=list[Pose2D])
    events: list[MissionEvent] = field(default_factory=list[MissionEvent])


def start_mission(ports: Ports, command: str) -> Mission:
    """Raises StackError with the coordinator's own words when the command is refused."""
    with httpx.Client(trust_env=False, timeout=30.0) as client:
        answer = client.post(f"{ports.url('coordinator')}/missions", json={"command": command})
    if answer.is_error:
        raise StackError(f"the coordinator refused the command: {answer.json().get('detail', answer.text)}")
    return Mission.model_validate_json(answer.content)


def watch(ports: Ports, mission: Mission, *, on_event: Callable[[MissionEvent], None], timeout_s: float) -> Watched:
    """Returns when the mission has ended; waits for services that restart. Raises StackError past the time."""
    watched = Watched(mission)
    deadline = time.monotonic() + timeout_s
    with httpx.Client(trust_env=False, timeout=5.0) as client:
        while watched.mission.outcome is None:
            if time.monotonic() > deadline:
                raise StackError(f"the mission did not end within {timeout_s:.0f} s")
            try:
                _look(client, ports, watched, on_event)
            except httpx.TransportError:
                time.sleep(0.5)
            time.sleep(0.3)
    return watched


def _look(client: httpx.Client, ports: Ports, watched: Watched, on_event: Callable[[MissionEvent], None]) -> None:
    coordinator = f"{ports.url('coordinator')}/missions/{watched.mission.id}"
    answer = client.get(coordinator)
    if answer.status_code == 404:
        raise StackError("the coordinator no longer knows the mission: it was restarted and the mission is lost")
    after = watched.events[-1].id if watched.events else -1
    fresh = EVENTS.validate_json(client.get(f"{coordinator}/events", params={"after": after}).content)
    for event in fresh:
        watched.events.append(event)
        on_event(event)
    state = RobotState.model_validate_json(client.get(f"{ports.url('robot_bridge')}/state").content)
    if state.pose is not None:
        watched.track.append(state.pose)
    watched.mission = Mission.model_validate_json(answer.content)
