"""What goes wrong in a mission, drawn from its seed: delays, drops, duplicates, crashes, lies, and a person's whims."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

SERVICES = ("robot_bridge", "inference", "memory")


@dataclass(frozen=True)
class Errors:
    """How wrong the eyes are beyond the real models' own errors. `liar` (a voter) always says yes."""

    false_boxes: float = 0.0
    """Boxes of the target's class on nothing, a frame."""
    missed: float = 0.0
    """Of the boxes there are, the share that is left out."""
    wrong_colour: float = 0.0
    """Of the crops that are looked at, the share that is taken for the target in another colour."""
    liar: str = ""
    dark: bool = False
    """A third of the light, and grain."""


@dataclass(frozen=True)
class Outage:
    """A service is down between two times, s after the mission's start; it forgets what it was doing."""

    service: str
    from_s: float
    to_s: float


@dataclass(frozen=True)
class Faults:
    """Probabilities are for each message, call, goal or measurement; times count from the mission's start, in s."""

    names: tuple[str, ...] = ()
    bus_delay_s_max: float = 0.0
    bus_drop: float = 0.0
    bus_duplicate: float = 0.0
    reply_delay_s_max: float = 0.0
    reply_lost: float = 0.0
    reply_senseless: float = 0.0
    outages: tuple[Outage, ...] = ()
    coordinator_dies_s: float | None = None
    depth_lie: float = 0.0
    goal_rejected: float = 0.0
    goal_aborted_104: float = 0.0
    goal_aborted_2xx: float = 0.0
    goal_false_success: float = 0.0
    path_lie: float = 0.0
    motion_cut: float = 0.0
    stop_s: float | None = None
    reset_s: float | None = None
    pause_s: float | None = None
    resume_s: float | None = None
    cancel_s: float | None = None
    errors: Errors = field(default_factory=Errors)

    def down(self, service: str, elapsed_s: float) -> bool:
        return any(o.service == service and o.from_s <= elapsed_s < o.to_s for o in self.outages)


Kinds = Mapping[str, Callable[[Faults, np.random.Generator], Faults]]


def draw(rng: np.random.Generator, count: int, kinds: Kinds | None = None) -> Faults:
    """`count` kinds of fault together; `kinds`: out of these, none = of all."""
    kinds = KINDS if kinds is None else kinds
    chosen = tuple(sorted(rng.choice(len(kinds), size=count, replace=False).tolist()))
    names = tuple(list(kinds)[k] for k in chosen)
    faults = Faults(names=names)
    for name in names:
        faults = kinds[name](faults, rng)
    return faults


def _errors(faults: Faults, **changes: object) -> Faults:
    return replace(faults, errors=replace(faults.errors, **changes))  # type: ignore[arg-type]


def _outage(faults: Faults, rng: np.random.Generator, service: str) -> Faults:
    start, length = float(rng.uniform(2.0, 90.0)), float(rng.choice([3.0, 8.0, 20.0, 2000.0], p=[0.35, 0.3, 0.2, 0.15]))
    return replace(faults, outages=(*faults.outages, Outage(service, start, start + length)))


def _stopped(faults: Faults, rng: np.random.Generator) -> Faults:
    at_s = float(rng.uniform(3.0, 60.0))
    return replace(faults, stop_s=at_s, reset_s=at_s + float(rng.uniform(2.0, 15.0)))


def _paused(faults: Faults, rng: np.random.Generator) -> Faults:
    at_s = float(rng.uniform(3.0, 60.0))
    stays = rng.random() < 0.2
    return replace(faults, pause_s=at_s, resume_s=None if stays else at_s + float(rng.uniform(5.0, 40.0)))


KINDS: Kinds = {
    "bus delay": lambda f, r: replace(f, bus_delay_s_max=float(r.uniform(0.3, 2.0))),
    "bus drop": lambda f, r: replace(f, bus_drop=float(r.uniform(0.1, 0.5))),
    "bus duplicate": lambda f, r: replace(f, bus_duplicate=float(r.uniform(0.1, 0.5))),
    "slow replies": lambda f, r: replace(f, reply_delay_s_max=float(r.uniform(0.5, 6.0))),
    "lost replies": lambda f, r: replace(f, reply_lost=float(r.uniform(0.02, 0.15))),
    "senseless replies": lambda f, r: replace(f, reply_senseless=float(r.uniform(0.02, 0.15))),
    "bridge down": lambda f, r: _outage(f, r, "robot_bridge"),
    "inference down": lambda f, r: _outage(f, r, "inference"),
    "memory down": lambda f, r: replace(f, outages=(*f.outages, Outage("memory", -10.0, 1e9))),
    "coordinator dies": lambda f, r: replace(f, coordinator_dies_s=float(r.uniform(3.0, 60.0))),
    "wrong depth": lambda f, r: replace(f, depth_lie=float(r.uniform(0.1, 0.35))),
    "false boxes": lambda f, r: _errors(f, false_boxes=float(r.uniform(0.05, 0.3))),
    "missed boxes": lambda f, r: _errors(f, missed=float(r.uniform(0.2, 0.6))),
    "wrong colours": lambda f, r: _errors(f, wrong_colour=float(r.uniform(0.1, 0.4))),
    "a lying CLIP": lambda f, r: _errors(f, liar="clip"),
    "a lying detector": lambda f, r: _errors(f, liar="detector"),
    "poor light": lambda f, r: _errors(f, dark=True),
    "Nav2 rejects": lambda f, r: replace(f, goal_rejected=float(r.choice([0.2, 0.5, 1.0], p=[0.5, 0.35, 0.15]))),
    "Nav2 aborts 104": lambda f, r: replace(f, goal_aborted_104=float(r.choice([0.3, 0.6, 1.0], p=[0.5, 0.3, 0.2]))),
    "Nav2 aborts 2xx": lambda f, r: replace(f, goal_aborted_2xx=float(r.choice([0.3, 0.6, 1.0], p=[0.5, 0.3, 0.2]))),
    "Nav2 says done too soon": lambda f, r: replace(f, goal_false_success=float(r.uniform(0.2, 0.5))),
    "paths refused": lambda f, r: replace(f, path_lie=float(r.choice([0.3, 0.7, 1.0], p=[0.5, 0.3, 0.2]))),
    "turns cut off": lambda f, r: replace(f, motion_cut=float(r.uniform(0.05, 0.3))),
    "emergency stop": _stopped,
    "pause": _paused,
    "cancel": lambda f, r: replace(f, cancel_s=float(r.uniform(2.0, 60.0))),
}
"""Every kind of fault by its name; each changes a plan by its own numbers."""
SERVICE_FAULTS = frozenset({
    "bus delay", "bus drop", "bus duplicate", "slow replies", "lost replies", "senseless replies", "bridge down",
    "inference down", "memory down", "Nav2 rejects", "Nav2 aborts 104", "Nav2 aborts 2xx", "Nav2 says done too soon",
    "paths refused", "turns cut off",
})  # fmt: skip
"""Faults that may keep a mission from going on."""
