"""What is typed and told, in words."""

import time

from contracts.reading import Mood
from contracts.robot import RobotState
from vocabulary.moods import read


def robot_lines(state: RobotState) -> list[tuple[str, str]]:
    stop = state.emergency_stop
    pose, battery = state.pose, state.battery
    stale = [name for name, sensor in state.sensors.items() if not sensor.valid]
    return [
        ("robot", f"stopped: {stop.reason} ({stop.by})" if stop.latched else "free to move"),
        ("place", "unknown" if pose is None else f"{pose.x:.2f} / {pose.y:.2f} m"),
        ("battery", "unknown" if battery is None or battery.percentage is None else f"{battery.percentage:.0f} %"),
        ("dock", {True: "docked", False: "undocked", None: "unknown"}[state.docked]),
        ("sensors", f"not fresh: {', '.join(sorted(stale))}" if stale else "fresh"),
    ]


def command_of(what: str) -> str:
    """One or a few words become a command; a whole sentence stays as it is."""
    words = what.lower().split()
    if read(what).mood is not Mood.FIND or len(words) > 3 or words[:1] in (["find"], ["bring"], ["where"], ["get"]):
        return what
    return f"find {what}" if words[:1] in (["the"], ["a"], ["an"], ["my"]) else f"find the {what}"


def ago(stamp_s: float) -> str:
    minutes = max(0.0, time.time() - stamp_s) / 60.0
    return f"{minutes:.0f} min ago" if minutes < 120.0 else f"{minutes / 60.0:.0f} h ago"
