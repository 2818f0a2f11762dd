"""What `/ready` says of the senses, of Nav2 and of the base, in words for a person."""

from typing import assert_never

from contracts.problem import Dependency, DependencyState
from contracts.robot import BaseStopState, SensorState, SensorStatus
from robot_bridge.sensing import endpoints
from robot_bridge.sensing.sensor_readings import SensorReadings
from robot_bridge.sensing.snapshot import Snapshot
from robot_bridge.sensing.stamps import TF, apart

DRIVES_S = 3.0
"""So long a velocity that somebody else has sent is told."""
_READY, _WARNING, _NOT_READY = DependencyState.READY, DependencyState.WARNING, DependencyState.NOT_READY

BASE_STOP: dict[BaseStopState, tuple[DependencyState, str]] = {
    BaseStopState.UNKNOWN: (_READY, "not asked for; no wheel_status tells whether the wheels are enabled"),
    BaseStopState.RELEASED: (_READY, "the wheels are enabled"),
    BaseStopState.ASKED: (_READY, "asked for; the wheels have not said so yet"),
    BaseStopState.ENGAGED: (_READY, "the wheels are disabled, as asked"),
    BaseStopState.UNCONFIRMED: (
        _WARNING,
        "asked for, and the wheels never said that they are disabled: the stop holds by zero velocities",
    ),
    BaseStopState.MISSING: (_WARNING, "the base offers no e_stop: the stop holds by zero velocities"),
    BaseStopState.HELD: (
        _NOT_READY,
        "the base has disabled its wheels: it was stopped at the robot, and is let go there (power button)",
    ),
}


HAZARDS = "hazards"
"""Which has a line of its own."""
NOT_NEEDED = frozenset({"battery", "dock", HAZARDS})
"""What a robot may do without and still be ready."""


def dependencies(senses: SensorReadings, known: tuple[str, ...], snapshot: Snapshot) -> list[Dependency]:
    """Is data flowing? One line each. `known` as for `drivers`."""
    found = [
        sensor(name, status)
        for name, status in snapshot.sensors.items()
        if name not in NOT_NEEDED or (status.detail and name != HAZARDS)
    ]
    found += frames_and_clocks(senses, snapshot.taken_s)
    missing = senses.why_no_nav2(snapshot.taken_s)
    found.append(Dependency.of("nav2", ok=not missing, detail=missing or "active"))
    found += [base_stop(senses), hazards(senses), drivers(senses, known, snapshot.taken_s)]
    if (asleep := power_saver(snapshot)) is not None:
        found.append(asleep)
    return [*found, endpoints.dependency(senses.mismatches.value or ())]


def sensor(name: str, status: SensorStatus) -> Dependency:
    """What a robot can do without is a warning, and so is what a person should know of a sensor that is well."""
    fine = _WARNING if status.detail else _READY
    state = fine if status.valid or name in NOT_NEEDED else _NOT_READY
    match status.state:
        case SensorState.NOT_UNDERSTOOD:
            return Dependency(name=name, state=state, detail=f"received, not understood: {status.detail}")
        case SensorState.NEVER | SensorState.FRESH | SensorState.STALE:
            told = f"{age(status.age_s)}; {status.detail}" if status.detail else age(status.age_s)
            return Dependency(name=name, state=state, detail=told)
        case _:
            assert_never(status.state)


def age(age_s: float | None) -> str:
    return "never received" if age_s is None else f"{age_s:.2f} s old"


def frames_and_clocks(senses: SensorReadings, now_s: float) -> list[Dependency]:
    """A person should know what is odd about them; the robot works."""
    odd = [f"{name} is {apart(behind_s)} the others" for name, behind_s in senses.clocks.odd(now_s).items()]
    clocks = _WARNING if odd else _READY
    found = [Dependency(name="clocks", state=clocks, detail="; ".join(odd) or "they agree")]
    if (refused := senses.reception.refused(TF)) is not None:
        found.append(Dependency(name=TF, state=_WARNING, detail=f"not understood: {refused.reason}"))
    return found


def base_stop(senses: SensorReadings) -> Dependency:
    state, detail = BASE_STOP[senses.base_stop.value or BaseStopState.UNKNOWN]
    return Dependency(name="base_stop", state=state, detail=detail)


def hazards(senses: SensorReadings) -> Dependency:
    """A robot drives without them; a person should know that its bumper and cliff sensors stop it by the base alone."""
    if senses.hazards.newest is not None:
        return Dependency(name="hazards", state=_READY, detail="received")
    if senses.hazards_offered.value:
        return Dependency(name="hazards", state=_READY, detail="none since the bridge began: they come on change only")
    return Dependency(
        name="hazards",
        state=_WARNING,
        detail="nobody publishes them: bumps, cliffs and lifted wheels are known to the base alone. On a TurtleBot 4 "
        "uncomment hazard_detection in the robot's republisher.yaml (docs/turtlebot4.md, step 1)",
    )


def power_saver(snapshot: Snapshot) -> Dependency | None:
    """On its dock a TurtleBot 4 turns lidar and camera off: that is no fault. None where it is awake."""
    docked = snapshot.dock is not None and snapshot.dock.is_docked
    if not docked or snapshot.sensors["scan"].valid or snapshot.sensors["rgb"].valid:
        return None
    detail = (
        "docked and asleep: its power saver has turned lidar and camera off, and it is ready for undocking only; "
        "off the dock they come back by themselves"
    )
    return Dependency(name="power_saver", state=_WARNING, detail=detail)


def drivers(senses: SensorReadings, known: tuple[str, ...], now_s: float) -> Dependency:
    """Who can drive the base past this bridge, and so past its stop; `known` are silent by habit."""
    others = senses.other_drivers.value or ()
    strangers = [name for name in others if name not in known]
    age_s, said = senses.foreign_velocity.age_s(now_s), senses.foreign_velocity.value
    if age_s is not None and said is not None and age_s <= DRIVES_S:
        detail = (
            f"somebody else drives the base past this bridge, which stands still meanwhile: {said[0]:.2f} m/s, "
            f"{said[1]:.2f} rad/s from one of {', '.join(others) or 'nobody who is there now'}; only a stop holds it"
        )
        return Dependency(name="drivers", state=_NOT_READY, detail=detail)
    if strangers:
        detail = f"{', '.join(strangers)} can drive the base past this bridge, and has been silent so far"
        return Dependency(name="drivers", state=_WARNING, detail=detail)
    silent = f"; {', '.join(others)} could too, and keeps silent" if others else ""
    return Dependency(name="drivers", state=_READY, detail=f"this bridge drives the base{silent}")
