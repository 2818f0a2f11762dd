"""Restarts as an update makes them, while a mission drives: SIGTERM, the service's own end, a new process."""

from collections.abc import Callable
from typing import Final

from bench.faulting.campaign import LONG_S, Campaign, Observed
from contracts.mission import Outcome

ROLLING: Final = ("ui", "speech", "memory", "inference", "robot_bridge", "coordinator")
"""Whoever only asks before whoever is asked; the coordinator last, so that its mission meets every other restart."""

HONEST: Final = frozenset({Outcome.FOUND.value, Outcome.INTERRUPTED.value, Outcome.ABORTED.value})
"""Aborted: nothing was heard of the robot for 15 s, which a start of the bridge can take on a busy machine."""


def updated(name: str) -> Callable[[Campaign], Observed]:
    """Of a service that a mission can wait for, or does without."""

    def happen(on: Campaign) -> Observed:
        on.before_the_dock()
        mission = on.mesh.driving()
        seen = on.end(name) | on.start(name) | on.end_of(mission)
        assert seen["mission"] == Outcome.FOUND.value, seen
        on.mesh.stays_at_rest_for(2.0)
        return seen

    return happen


def speech_updated(on: Campaign) -> Observed:
    on.before_the_dock()
    mission = on.mesh.driving()
    seen = on.end("speech")
    others = set(on.stack.calls) - {"speech"}
    assert not (away := {name for name in others if on.lacks(name)}), f"{away} are not ready without speech"
    seen |= on.start("speech") | on.end_of(mission)
    assert seen["mission"] == Outcome.FOUND.value, seen
    return seen


def bridge_updated(on: Campaign) -> Observed:
    on.before_the_dock()
    mission = on.mesh.driving()
    at_s = on.mesh.simulated_s()
    seen = on.end("robot_bridge")
    seen["rest_after_s"] = on.rest_after(at_s)
    on.mesh.stays_at_rest_for(2.0)
    seen |= on.start("robot_bridge") | on.end_of(mission)
    assert seen["mission"] in HONEST, seen
    on.mesh.stays_at_rest_for(2.0)
    return seen


def coordinator_updated(on: Campaign) -> Observed:
    on.before_the_dock()
    mission = on.mesh.driving()
    at_s = on.mesh.simulated_s()
    seen = on.end("coordinator")
    seen["rest_after_s"] = on.rest_after(at_s)
    seen |= on.start("coordinator") | on.end_of(mission)
    assert seen["mission"] == Outcome.INTERRUPTED.value, seen
    on.mesh.stays_at_rest_for(2.0)
    return seen


def rolling_update(on: Campaign) -> Observed:
    """Each is ready again before the next is ended, as `docker compose up -d --wait` for one service after another."""
    on.before_the_dock()
    mission = on.mesh.driving()
    seen: Observed = {}
    for name in ROLLING:
        told = on.end(name) | on.start(name)
        seen[name] = f"{told['ended_after_s']} s to its end, {told['ready_after_s']} s to ready"
    on.mesh.until(on.ready, timeout_s=LONG_S * 2, what="the mesh ready again")
    seen |= on.end_of(mission)
    assert seen["mission"] in HONEST, seen
    on.mesh.stays_at_rest_for(2.0)
    return seen
