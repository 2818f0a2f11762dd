"""Plays one faulted mission from its command to after its ending, and judges it."""

import asyncio
import logging
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from bench.campaigning.episode import FaultedEpisode
from bench.campaigning.verdict import judged
from bench.search.play import STARTED_S, circumstances, digest, scored, without_wall_time
from bench.search.staging import staged
from bench.world.clock import TOOK_S, NothingLeftError, SpinningError, run_simulated
from bench.world.eyes import erring
from bench.world.fate import Fate
from bench.world.line import Line
from bench.world.mesh import Mesh, MeshSettings, open_mesh
from bench.world.troubles import RobotTroubles
from contracts.mission import Mission, MissionState, Outcome
from coordinator.core.recording import read, replay
from inference.perception.models import Loaded
from mesh.errors import MeshError

log = logging.getLogger(__name__)

SETTLE_S = 3.0
POLL_S = 0.25
SLACK_S = 60.0
AFTER_S = 8.0
"""So long after its ending the robot is watched on."""


@dataclass
class Played:
    """What happened."""

    mission: Mission | None = None
    refused: str = ""
    """Why no mission was begun."""
    score: dict[str, Any] = field(default_factory=dict[str, Any])
    """How the robot stood where it ended, to what was asked for."""
    took_s: float = 0.0
    metres: float = 0.0
    problems: list[str] = field(default_factory=list[str])
    timeline: list[dict[str, Any]] = field(default_factory=list[dict[str, Any]])
    recording: tuple[str, ...] = ()


def played(
    one: FaultedEpisode, models: Loaded, settings: MeshSettings, *, tours: Path, recording: Path | None = None
) -> dict[str, Any]:
    """The record of a faulted mission. What the simulation cannot go on with counts as a hang or a crash.

    `recording`: a file for what the coordinator recorded.
    """
    began_s = time.perf_counter()
    run = Played()
    line, troubles = Line(one.faults, one.seed), RobotTroubles(one.faults, one.seed)
    (asked,) = one.episode.commands[0].asked
    eyes = erring(models, one.faults.errors, asked.kind, asked.colour, one.seed)
    with staged(one.episode, models, settings, tours) as stage:

        async def main() -> None:
            async with open_mesh(
                stage.world, stage.recorded, eyes, stage.settings, line=line, troubles=troubles
            ) as mesh:
                await _play(one, mesh, run)

        try:
            run_simulated(main, start_s=STARTED_S, took_s=TOOK_S)
        except (NothingLeftError, SpinningError) as error:
            run.problems.append(f"hang: {error}")
        except Exception as error:
            log.exception("mission %d", one.seed)
            run.problems.append(f"crash: {type(error).__name__}: {error}")
        run.metres = round(stage.world.truth.path_length_m, 2)
    if recording is not None:
        recording.write_text("\n".join(run.recording), encoding="utf-8")
    record = _told(one, run) | {"on": circumstances(models)}
    return record | {"digest": digest(record), "wall": {"seconds": round(time.perf_counter() - began_s, 2)}}


def _told(one: FaultedEpisode, run: Played) -> dict[str, Any]:
    ending = judged(one, run.mission, run.refused, run.score)
    mission = run.mission.model_dump(mode="json") if run.mission is not None else None
    return without_wall_time(
        {
            "faulted": one.model_dump(mode="json"),
            "ending": ending.ending,
            "dishonest": ending.dishonest,
            "correct": ending.correct,
            "problems": run.problems,
            "refused": run.refused,
            "score": run.score,
            "took_s": round(run.took_s, 2),
            "metres": run.metres,
            "mission": mission,
            "timeline": run.timeline,
        }
    )


async def _play(one: FaultedEpisode, mesh: Mesh, run: Played) -> None:
    loop = asyncio.get_running_loop()
    await asyncio.sleep(SETTLE_S)
    begun_s = loop.time()
    mesh.line.begins_s = mesh.robot.troubles.begins_s = begun_s
    try:
        begun = await mesh.missions.start(one.episode.commands[0].text)
    except MeshError as error:
        run.refused = f"{type(error).__name__}: {error.detail}"
        return
    assert isinstance(begun, Mission), "the command starts one"
    fate = Fate(mesh, begun.id, begun_s, one.seed)
    async with fate.at_work():
        limit_s = begun_s + _longest_s(mesh) + SLACK_S
        while not await _is_over(mesh, begun.id):
            await asyncio.sleep(POLL_S)
            if loop.time() > limit_s:
                run.problems.append(f"hang: not over after {loop.time() - begun_s:.0f} s")
                break
        run.took_s = loop.time() - begun_s
        run.score = _score_of(one, mesh)
        await asyncio.sleep(AFTER_S)
        run.mission = await mesh.missions.get(begun.id)
        _rested(mesh, fate, run)
    events = await mesh.missions.log.events(begun.id, after=-1, limit=5000)
    run.timeline = [event.model_dump(mode="json") for event in events]
    run.problems += [*fate.problems, *(f"crash: {name} ended a background task" for name in mesh.died)]
    run.problems += await _replayed(mesh, begun.id, run)


def _longest_s(mesh: Mesh) -> float:
    rules = mesh.missions.runner.mission.rules
    return rules.mission_timeout_s + rules.pause_timeout_s


async def _is_over(mesh: Mesh, mission_id: str) -> bool:
    if not mesh.processes["coordinator"].served.up:
        return False
    return (await mesh.missions.get(mission_id)).outcome is not None


def _score_of(one: FaultedEpisode, mesh: Mesh) -> dict[str, Any]:
    (asked,) = one.episode.commands[0].asked
    return scored(mesh.robot.world, asked.kind, asked.colour)


def _rested(mesh: Mesh, fate: Fate, run: Played) -> None:
    """After its ending a mission leaves the coordinator IDLE, or stopped while the stop is latched."""
    state = mesh.missions.runner.mission.state
    if state is not MissionState.IDLE and not (fate.latched and state is MissionState.EMERGENCY_STOP):
        run.problems.append(f"hang: {state.value} {AFTER_S:.0f} s after the ending")


async def _replayed(mesh: Mesh, mission_id: str, run: Played) -> list[str]:
    """Decided again from its recording, step by step. That of a coordinator that died ends in the middle."""
    recording = run.recording = await mesh.missions.log.recording(mission_id)
    if not recording or (run.mission is not None and run.mission.outcome is Outcome.INTERRUPTED):
        return []
    other = sum(not step.same for step in replay(read(recording)))
    return [f"replay: {other} of its steps are decided otherwise"] if other else []
