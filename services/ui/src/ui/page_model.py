"""What the page says about a facts: words, tones and which buttons make sense. Pure."""

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

from contracts.mission import Mission, MissionState, Outcome
from contracts.problem import Dependency, DependencyState
from contracts.robot import NavigationState, RobotState, SensorState, SensorStatus
from ui.i18n import N_, _
from ui.latest_facts import LatestFacts


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
class PageModel:
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
    queue: tuple[tuple[str, str], ...]
    goal_open: bool
    can_pause: bool
    can_resume: bool
    can_cancel: bool
    can_dock: bool
    can_undock: bool
    robot_fresh: bool


PHASES: Final[dict[MissionState, tuple[str, Tone]]] = {
    MissionState.IDLE: (N_("Idle"), Tone.QUIET),
    MissionState.MEMORY_NAV: (N_("Driving to a remembered place"), Tone.BUSY),
    MissionState.SCANNING: (N_("Looking around"), Tone.BUSY),
    MissionState.MOVING_TO_SCAN: (N_("Driving to the next search place"), Tone.BUSY),
    MissionState.CENTERING: (N_("Turning to the object"), Tone.BUSY),
    MissionState.DEPTH_CHECK: (N_("Checking the object"), Tone.BUSY),
    MissionState.APPROACHING: (N_("Approaching the object"), Tone.BUSY),
    MissionState.MOVING: (N_("Moving as asked"), Tone.BUSY),
    MissionState.EXPLORING: (N_("Exploring"), Tone.BUSY),
    MissionState.DRIVING_1M: (N_("Moving closer"), Tone.BUSY),
    MissionState.DONE: (N_("Done"), Tone.GOOD),
    MissionState.EMERGENCY_STOP: (N_("Stopped"), Tone.BAD),
}
OUTCOMES: Final[dict[Outcome, tuple[str, Tone]]] = {
    Outcome.FOUND: (N_("Found"), Tone.GOOD),
    Outcome.NOT_FOUND: (N_("Not found"), Tone.WARN),
    Outcome.UNSURE: (N_("Not sure"), Tone.WARN),
    Outcome.DOCKED: (N_("Docked"), Tone.GOOD),
    Outcome.DONE: (N_("Done"), Tone.GOOD),
    Outcome.CANCELED: (N_("Cancelled"), Tone.QUIET),
    Outcome.INTERRUPTED: (N_("Interrupted"), Tone.BAD),
    Outcome.ABORTED: (N_("Aborted"), Tone.BAD),
}
NAVIGATION: Final = {
    NavigationState.INACTIVE: (N_("not ready"), Tone.WARN),
    NavigationState.IDLE: (N_("ready"), Tone.GOOD),
    NavigationState.NAVIGATING: (N_("driving"), Tone.BUSY),
}
BATTERY_LOW_PERCENT: Final = 20.0


def page_model(facts: LatestFacts, *, now_s: float, silence_s_max: float) -> PageModel:
    mission = facts.mission.mission if facts.mission is not None else None
    running = mission is not None and mission.outcome is None
    stopped = facts.stop is not None and facts.stop.latched
    robot_fresh = now_s - facts.robot_at_s <= silence_s_max
    robot = facts.robot if robot_fresh else None
    docked = robot.docked if robot is not None else None
    phase, tone = _phase(facts, mission, running=running, stopped=stopped)
    at_rest = robot is not None and not stopped and not running and robot.navigation is not NavigationState.NAVIGATING
    return PageModel(
        phase=phase,
        phase_tone=tone,
        headline=_headline(mission),
        reason=_reason(facts, mission, running=running),
        stopped=stopped,
        stop_detail=_stop_detail(facts) if stopped else "",
        robot_facts=_robot_facts(facts, robot, now_s),
        mission_facts=_mission_facts(facts, mission, now_s, silence_s_max),
        sensors=_sensors(robot),
        services=tuple(_service(one) for one in facts.services),
        away=_away(facts),
        queue=tuple((one.id, one.command) for one in facts.mission.queue) if facts.mission is not None else (),
        goal_open=facts.goal is not None and not running,
        can_pause=running and mission is not None and not mission.paused and not stopped,
        can_resume=running and mission is not None and mission.paused and not stopped,
        can_cancel=running,
        can_dock=at_rest and docked is False,
        can_undock=at_rest and docked is True,
        robot_fresh=robot_fresh,
    )


def _phase(facts: LatestFacts, mission: Mission | None, *, running: bool, stopped: bool) -> tuple[str, Tone]:
    if stopped:
        return _said(PHASES[MissionState.EMERGENCY_STOP])
    if facts.mission is None:
        return _("Mission status unknown"), Tone.WARN
    if running and mission is not None and mission.paused:
        return _("Paused"), Tone.WARN
    if not running and mission is not None and mission.outcome is not None:
        return _said(OUTCOMES[mission.outcome])
    return _said(PHASES[facts.mission.state])


def _said(word: tuple[str, Tone]) -> tuple[str, Tone]:
    return _(word[0]), word[1]


def _headline(mission: Mission | None) -> str:
    if mission is None:
        return _("Waiting for a command")
    return f"“{mission.command}”"


def _reason(facts: LatestFacts, mission: Mission | None, *, running: bool) -> str:
    if mission is None:
        return _("Type what to find, or click the map to send the robot there.")
    if running and facts.mission is not None:
        waiting = facts.mission.waiting_for
        if waiting:
            return _("Waiting for {what}", what=waiting)
        return facts.mission.progress or mission.reason
    return mission.reason


def _stop_detail(facts: LatestFacts) -> str:
    stop = facts.stop
    if stop is None:
        return ""
    parts = [stop.reason or _("stopped")]
    if stop.by:
        parts.append(_("by {who}", who=stop.by))
    if facts.first_zero_ms is not None:
        parts.append(_("first zero velocity after {ms:.1f} ms", ms=facts.first_zero_ms))
    if facts.rest_after_s is not None:
        parts.append(_("at rest after {s:.1f} s", s=facts.rest_after_s))
    return " · ".join(parts)


def _robot_facts(facts: LatestFacts, robot: RobotState | None, now_s: float) -> tuple[Chip, ...]:
    if robot is None:
        age = now_s - facts.robot_at_s
        silence = _("no data for {time}", time=duration(age)) if math.isfinite(age) else _("no data yet")
        return (Chip(_("Robot"), silence, Tone.BAD),)
    chips: list[Chip] = []
    if robot.battery is not None and (percent := robot.battery.percentage) is not None:
        low = percent < BATTERY_LOW_PERCENT and not robot.battery.charging
        charging = _(", charging") if robot.battery.charging else ""
        chips.append(Chip(_("Battery"), f"{percent:.0f} %{charging}", Tone.WARN if low else Tone.GOOD))
    else:
        charging = _(", charging") if robot.battery is not None and robot.battery.charging else ""
        chips.append(Chip(_("Battery"), f"{_('unknown')}{charging}", Tone.WARN))
    chips.append(Chip(_("Dock"), {True: _("docked"), False: _("undocked"), None: _("unknown")}[robot.docked]))
    word, tone = NAVIGATION[robot.navigation]
    chips.append(Chip(_("Navigation"), _(word), tone))
    chips.append(Chip(_("Speed"), f"{abs(robot.twist.linear_x):.2f} m/s"))
    if robot.hazards:
        chips.append(Chip(_("Bumper"), ", ".join(robot.hazards)[:40], Tone.BAD))
    return tuple(chips)


def _mission_facts(facts: LatestFacts, mission: Mission | None, now_s: float, silence_s_max: float) -> tuple[Chip, ...]:
    if mission is None or facts.mission is None:
        return ()
    until_s = mission.ended_s if mission.ended_s is not None else facts.mission.stamp_s
    chips = [
        Chip(_("Time"), duration(max(0.0, until_s - mission.started_s))),
        Chip(_("Driven"), f"{mission.metres_driven_m:.1f} m"),
    ]
    if mission.measured_distance_m is not None:
        chips.append(Chip(_("Distance"), f"{mission.measured_distance_m:.2f} m"))
    if mission.outcome is None and now_s - facts.mission_at_s > silence_s_max:
        chips.append(Chip(_("Mission"), _("no data for {time}", time=duration(now_s - facts.mission_at_s)), Tone.WARN))
    return tuple(chips)


def _sensors(robot: RobotState | None) -> tuple[Chip, ...]:
    """A fresh one needs no number; for the others the age says how bad it is, or a word that it is not understood."""
    if robot is None:
        return ()
    return tuple(_sensor(name, status) for name, status in sorted(robot.sensors.items()))


def _sensor(name: str, status: SensorStatus) -> Chip:
    value, tone, word = {
        SensorState.FRESH: ("", Tone.WARN if status.detail else Tone.GOOD, _("fresh")),
        SensorState.STALE: (_("{n:.0f} s old", n=status.age_s or 0.0), Tone.BAD, _("not fresh")),
        SensorState.NEVER: (_("never"), Tone.BAD, _("not fresh")),
        SensorState.NOT_UNDERSTOOD: (_("not understood"), Tone.BAD, _("not understood")),
    }[status.state]
    return Chip(name, value, tone, f"{name}: {word}{f', {status.detail}' if status.detail else ''}")


SERVICE_TONES = {DependencyState.READY: Tone.GOOD, DependencyState.WARNING: Tone.WARN}


def _service(one: Dependency) -> Chip:
    value = "" if one.state is DependencyState.READY else _state_in_words(one)
    return Chip(
        name_of(one.name), value, SERVICE_TONES.get(one.state, Tone.BAD), f"{one.name}: {one.detail or _('ready')}"
    )


def _away(facts: LatestFacts) -> str:
    """Names the missing: 'memory not reachable'. Who only lacks one of those is not named beside them."""
    lacking = [service for service in facts.services if not service.ok]
    missing = [service for service in lacking if service.state is DependencyState.UNREACHABLE] or lacking
    if not missing:
        return ""
    details = {_state_in_words(service) for service in missing}
    return f"{', '.join(name_of(s.name) for s in missing)} {details.pop() if len(details) == 1 else _('not available')}"


def _state_in_words(one: Dependency) -> str:
    """What it is, from its type; its whole detail is told where there is room."""
    match one.state:
        case DependencyState.UNREACHABLE:
            return _("not reachable")
        case DependencyState.NOT_READY:
            return _("not ready")
        case DependencyState.READY | DependencyState.WARNING:
            return one.detail[:60]


def name_of(service: str) -> str:
    return {"robot_bridge": _("robot bridge"), "redis": "Redis"}.get(service, service)


def duration(seconds: float) -> str:
    """0:07, 12:30, 1:02:03."""
    whole = int(seconds)
    minutes, hours = whole // 60 % 60, whole // 3600
    return f"{hours}:{minutes:02d}:{whole % 60:02d}" if hours else f"{minutes}:{whole % 60:02d}"


def ago(seconds: float) -> str:
    """In the largest unit that says enough: 12 s ago, 5 min ago, 3 h ago, 2 days ago."""
    past = max(0.0, seconds)
    if past < 60.0:
        return _("{n:.0f} s ago", n=past)
    if past < 3600.0:
        return _("{n:.0f} min ago", n=past / 60.0)
    if past < 48 * 3600.0:
        return _("{n:.0f} h ago", n=past / 3600.0)
    return _("{n:.0f} days ago", n=past / 86400.0)
