"""What the page says about a situation: words, tones and which buttons make sense. Pure."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Final

from pydantic import TypeAdapter, ValidationError

from contracts.mission import Mission, MissionEvent, MissionState, Outcome
from contracts.robot import NavigationState, RobotState
from contracts.vision import Verdict, Vote
from ui.situation import Situation


class Tone(StrEnum):
    """How a word is coloured."""

    QUIET = "quiet"
    BUSY = "busy"
    GOOD = "good"
    WARN = "warn"
    BAD = "bad"


@dataclass(frozen=True, slots=True)
class Chip:
    """A short fact; `title` is the long form for a pointer or a screen reader."""

    label: str
    value: str
    tone: Tone = Tone.QUIET
    title: str = ""


@dataclass(frozen=True, slots=True)
class View:
    phase: str
    phase_tone: Tone
    headline: str
    reason: str
    stopped: bool
    stop_detail: str
    robot_facts: tuple[Chip, ...]
    mission_facts: tuple[Chip, ...]
    sensors: tuple[Chip, ...]
    services: tuple[Chip, ...]
    away: str
    votes: tuple[Chip, ...]
    can_pause: bool
    can_resume: bool
    can_cancel: bool
    can_dock: bool
    can_undock: bool
    robot_fresh: bool


PHASES: Final[dict[MissionState, tuple[str, Tone]]] = {
    MissionState.IDLE: ("Idle", Tone.QUIET),
    MissionState.MEMORY_NAV: ("Driving to a remembered place", Tone.BUSY),
    MissionState.SCANNING: ("Looking around", Tone.BUSY),
    MissionState.MOVING_TO_SCAN: ("Driving to the next place", Tone.BUSY),
    MissionState.CENTERING: ("Turning to it", Tone.BUSY),
    MissionState.DEPTH_CHECK: ("Making sure", Tone.BUSY),
    MissionState.APPROACHING: ("Driving up to it", Tone.BUSY),
    MissionState.DRIVING_1M: ("Going closer", Tone.BUSY),
    MissionState.DONE: ("Done", Tone.GOOD),
    MissionState.EMERGENCY_STOP: ("Stopped", Tone.BAD),
}
OUTCOMES: Final[dict[Outcome, tuple[str, Tone]]] = {
    Outcome.FOUND: ("Found", Tone.GOOD),
    Outcome.NOT_FOUND: ("Not found", Tone.WARN),
    Outcome.UNSURE: ("Not sure", Tone.WARN),
    Outcome.DOCKED: ("Docked", Tone.GOOD),
    Outcome.CANCELED: ("Cancelled", Tone.QUIET),
    Outcome.INTERRUPTED: ("Interrupted", Tone.BAD),
    Outcome.ABORTED: ("Aborted", Tone.BAD),
}
NAVIGATION: Final = {
    NavigationState.INACTIVE: ("not ready", Tone.WARN),
    NavigationState.IDLE: ("ready", Tone.GOOD),
    NavigationState.NAVIGATING: ("driving", Tone.BUSY),
}
VERDICTS: Final = {Verdict.YES: ("yes", Tone.GOOD), Verdict.NO: ("no", Tone.BAD), Verdict.ABSTAIN: ("–", Tone.QUIET)}
VOTERS: Final = {"detector": "Detector", "clip": "CLIP", "vlm": "VLM"}
VOTES: Final = TypeAdapter(tuple[Vote, ...])
BATTERY_LOW_PERCENT: Final = 20.0


def view(situation: Situation, *, now_s: float, silence_s_max: float) -> View:
    mission = situation.mission.mission if situation.mission is not None else None
    running = mission is not None and mission.outcome is None
    stopped = situation.stop is not None and situation.stop.latched
    robot_fresh = now_s - situation.robot_at_s <= silence_s_max
    robot = situation.robot if robot_fresh else None
    docked = robot.docked if robot is not None else None
    phase, tone = _phase(situation, mission, running=running, stopped=stopped)
    at_rest = robot is not None and not stopped and not running and robot.navigation is not NavigationState.NAVIGATING
    return View(
        phase=phase,
        phase_tone=tone,
        headline=_headline(mission),
        reason=_reason(situation, mission, running=running),
        stopped=stopped,
        stop_detail=_stop_detail(situation) if stopped else "",
        robot_facts=_robot_facts(situation, robot, now_s),
        mission_facts=_mission_facts(situation, mission, now_s, silence_s_max),
        sensors=_sensors(robot),
        services=tuple(
            Chip(
                name_of(s.name),
                "" if s.ok else _short(s.detail),
                Tone.GOOD if s.ok else Tone.BAD,
                f"{s.name}: {s.detail or 'ready'}",
            )
            for s in situation.services
        ),
        away=_away(situation),
        votes=tuple(vote_chip(vote) for vote in mission.votes) if mission is not None else (),
        can_pause=running and mission is not None and not mission.paused and not stopped,
        can_resume=running and mission is not None and mission.paused and not stopped,
        can_cancel=running,
        can_dock=at_rest and docked is False,
        can_undock=at_rest and docked is True,
        robot_fresh=robot_fresh,
    )


def _phase(situation: Situation, mission: Mission | None, *, running: bool, stopped: bool) -> tuple[str, Tone]:
    if stopped:
        return PHASES[MissionState.EMERGENCY_STOP]
    if situation.mission is None:
        return "No news of missions", Tone.WARN
    if running and mission is not None and mission.paused:
        return "Paused", Tone.WARN
    if not running and mission is not None and mission.outcome is not None:
        return OUTCOMES[mission.outcome]
    return PHASES[situation.mission.state]


def _headline(mission: Mission | None) -> str:
    if mission is None:
        return "Waiting for a command"
    return f"“{mission.command}”"


def _reason(situation: Situation, mission: Mission | None, *, running: bool) -> str:
    if mission is None:
        return "Type what to find."
    if running and situation.mission is not None:
        return situation.mission.progress or mission.reason
    return mission.reason


def _stop_detail(situation: Situation) -> str:
    stop = situation.stop
    if stop is None:
        return ""
    parts = [stop.reason or "stopped"]
    if stop.by:
        parts.append(f"by {stop.by}")
    if situation.first_zero_ms is not None:
        parts.append(f"first zero velocity after {situation.first_zero_ms:.1f} ms")
    return " · ".join(parts)


def _robot_facts(situation: Situation, robot: RobotState | None, now_s: float) -> tuple[Chip, ...]:
    if robot is None:
        age = now_s - situation.robot_at_s
        silence = f"no news for {duration(age)}" if math.isfinite(age) else "no news yet"
        return (Chip("Robot", silence, Tone.BAD),)
    facts: list[Chip] = []
    if robot.battery is not None:
        percent = robot.battery.percentage
        low = percent < BATTERY_LOW_PERCENT and not robot.battery.charging
        charging = ", charging" if robot.battery.charging else ""
        facts.append(Chip("Battery", f"{percent:.0f} %{charging}", Tone.WARN if low else Tone.GOOD))
    else:
        facts.append(Chip("Battery", "unknown", Tone.WARN))
    facts.append(Chip("Dock", {True: "docked", False: "undocked", None: "unknown"}[robot.docked]))
    word, tone = NAVIGATION[robot.navigation]
    facts.append(Chip("Navigation", word, tone))
    facts.append(Chip("Speed", f"{abs(robot.twist.linear_x):.2f} m/s"))
    if robot.hazards:
        facts.append(Chip("Bumper", ", ".join(robot.hazards)[:40], Tone.BAD))
    return tuple(facts)


def _mission_facts(
    situation: Situation, mission: Mission | None, now_s: float, silence_s_max: float
) -> tuple[Chip, ...]:
    if mission is None or situation.mission is None:
        return ()
    until_s = mission.ended_s if mission.ended_s is not None else situation.mission.stamp_s
    facts = [
        Chip("Time", duration(max(0.0, until_s - mission.started_s))),
        Chip("Driven", f"{mission.metres_driven_m:.1f} m"),
    ]
    if mission.measured_distance_m is not None:
        facts.append(Chip("Distance", f"{mission.measured_distance_m:.2f} m"))
    if mission.outcome is None and now_s - situation.mission_at_s > silence_s_max:
        facts.append(Chip("Mission", f"no news for {duration(now_s - situation.mission_at_s)}", Tone.WARN))
    return tuple(facts)


def _sensors(robot: RobotState | None) -> tuple[Chip, ...]:
    """A fresh one needs no number; for the others the age says how bad it is."""
    if robot is None:
        return ()
    return tuple(
        Chip(
            name,
            "" if status.valid else "never" if status.age_s is None else f"{status.age_s:.0f} s old",
            Tone.GOOD if status.valid else Tone.BAD,
            f"{name}: {'fresh' if status.valid else 'not fresh'}",
        )
        for name, status in sorted(robot.sensors.items())
    )


def _away(situation: Situation) -> str:
    """Names the missing: 'memory not reachable', 'Redis, inference not available'."""
    missing = [service for service in situation.services if not service.ok]
    if not missing:
        return ""
    details = {_short(service.detail) for service in missing}
    return f"{', '.join(name_of(s.name) for s in missing)} {details.pop() if len(details) == 1 else 'not available'}"


def _short(detail: str) -> str:
    return detail.split(" (", maxsplit=1)[0][:60] or "away"


def name_of(service: str) -> str:
    return {"robot_bridge": "robot bridge", "redis": "Redis"}.get(service, service)


def vote_chip(vote: Vote) -> Chip:
    word, tone = VERDICTS[vote.verdict]
    score = "" if vote.score is None else f" {vote.score:.2f}"
    threshold = "" if vote.score is None or vote.threshold is None else f" / {vote.threshold:.2f}"
    return Chip(VOTERS.get(vote.voter, vote.voter), f"{word}{score}{threshold}", tone, vote.reason)


@dataclass(frozen=True, slots=True)
class Line:
    """One line of the timeline as it is shown."""

    time: str
    phase: str
    text: str
    tone: Tone
    votes: tuple[Chip, ...] = ()


KIND_TONES: Final = {"found": Tone.GOOD, "votes": Tone.BUSY, "failure": Tone.WARN, "end": Tone.WARN}


def line(event: MissionEvent, started_s: float) -> Line:
    tone = KIND_TONES.get(event.kind, Tone.QUIET)
    if event.data.get("outcome") == Outcome.FOUND.value:
        tone = Tone.GOOD
    if event.state is MissionState.EMERGENCY_STOP:
        tone = Tone.BAD
    return Line(
        time=duration(max(0.0, event.stamp_s - started_s)),
        phase=PHASES[event.state][0],
        text=event.text,
        tone=tone,
        votes=_votes_in(event.data),
    )


def _votes_in(data: Mapping[str, Any]) -> tuple[Chip, ...]:
    try:
        return tuple(vote_chip(vote) for vote in VOTES.validate_python(data.get("votes", ())))
    except ValidationError:
        return ()


def duration(seconds: float) -> str:
    """0:07, 12:30, 1:02:03."""
    whole = int(seconds)
    minutes, hours = whole // 60 % 60, whole // 3600
    return f"{hours}:{minutes:02d}:{whole % 60:02d}" if hours else f"{minutes}:{whole % 60:02d}"
