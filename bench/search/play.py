"""Plays one episode from its first command to its last ending, and writes down what happened."""

import asyncio
import contextlib
import hashlib
import json
import math
import platform
import shutil
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import Any, cast

from bench.search.activity import Activity
from bench.search.episode import Asked, Command, Episode
from bench.search.floor import Ways, counts_within_m, floor_s
from bench.search.staging import staged
from bench.world.clock import TOOK_S, NothingLeftError, SpinningError, run_simulated
from bench.world.mesh import Mesh, MeshSettings, open_mesh
from bench.world.tour import TOURED_S
from contracts.mission import EventKind, Mission, MissionEvent, Outcome
from contracts.topics import MISSION_EVENTS
from inference.perception.models import Loaded
from mesh.errors import MeshError
from sim.scoring import NothingToScoreError, score
from sim.world import ThingTruth, World

STARTED_S = TOURED_S + 3600.0
SETTLE_S = 3.0
"""For the mesh to come up before the first command."""
SLACK_S = 60.0
FOUND_WITHIN_M = (0.45, 1.0)
UNTOLD = frozenset({"took_ms", "trace_id"})
"""What the wall clock measured, and what is drawn anew each time."""


@dataclass
class Stage:
    """One episode under way. `judged`: by mission, at its end."""

    episode: Episode
    world: World
    mesh: Mesh
    activity: Activity = field(default_factory=Activity)
    judged: dict[str, dict[str, Any]] = field(default_factory=dict[str, dict[str, Any]])
    ended: asyncio.Event = field(default_factory=asyncio.Event)
    track: list[tuple[float, float, float, float]] = field(default_factory=list[tuple[float, float, float, float]])
    problems: list[str] = field(default_factory=list[str])

    async def hear(self, event: MissionEvent) -> None:
        """A mission is judged where it ends, not where the robot is later."""
        if event.kind in {EventKind.FOUND, EventKind.END} and event.mission_id not in self.judged:
            truth = self.world.truth
            self.judged[event.mission_id] = {
                "pose": truth.pose,
                "metres": truth.path_length_m,
                "stamp_s": event.stamp_s,
            }
            mission = await self.mesh.missions.get(event.mission_id)
            if mission.target is not None and mission.outcome is Outcome.FOUND:
                colour = mission.target.colour.value if mission.target.colour else None
                self.judged[event.mission_id] |= scored(self.world, mission.target.label, colour)
            self.ended.set()

    async def trace(self) -> None:
        while True:
            pose = self.world.truth.pose
            now_s = asyncio.get_running_loop().time() - STARTED_S
            self.track.append((round(now_s, 2), round(pose.x, 3), round(pose.y, 3), round(pose.yaw, 3)))
            await asyncio.sleep(1.0)


def played(
    episode: Episode, models: Loaded, settings: MeshSettings, *, tours: Path, keep: Path | None = None
) -> dict[str, Any]:
    """The record of an episode. `settings.disk` is not used; `keep` keeps the robot's disk, with the recording."""
    began_s, began_cpu_s = time.perf_counter(), time.process_time()
    record: dict[str, Any] = {"episode": episode.model_dump(mode="json"), "on": circumstances(models)}
    with staged(episode, models, settings, tours) as stage:

        async def main() -> dict[str, Any]:
            async with open_mesh(stage.world, stage.recorded, models, stage.settings) as mesh:
                return await _play(Stage(episode, stage.world, mesh))

        try:
            record |= run_simulated(main, start_s=STARTED_S, took_s=TOOK_S)
        except (NothingLeftError, SpinningError) as error:
            record |= {"problems": [f"hang: {error}"], "missions": []}
        if keep is not None:
            shutil.copytree(stage.settings.disk, keep, dirs_exist_ok=True)
    record = without_wall_time(record)
    record["digest"] = digest(record)
    record["wall"] = {
        "seconds": round(time.perf_counter() - began_s, 2),
        "cpu_s": round(time.process_time() - began_cpu_s, 2),
        "tour_cpu_s": round(stage.toured_cpu_s, 2),
        "simulated_s": record.get("simulated_s", 0.0),
    }
    return record


async def _play(stage: Stage) -> dict[str, Any]:
    loop, mesh, world = asyncio.get_running_loop(), stage.mesh, stage.world
    await asyncio.sleep(SETTLE_S)
    others = [
        asyncio.ensure_future(stage.activity.watch(mesh.missions, world)),
        asyncio.ensure_future(stage.trace()),
        asyncio.ensure_future(mesh.bus.listen(MISSION_EVENTS, stage.hear)),
    ]
    missions: list[dict[str, Any]] = []
    for number, command in enumerate(stage.episode.commands):
        for change in stage.episode.between:
            if change.before_command == number:
                moved = change.carried
                world.move_thing(moved.thing_id, moved.x_m, moved.y_m, moved.z_m, moved.yaw)
        missions += await _say(stage, command)
    for task in others:
        task.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await task
    stage.problems += [f"crash: {name} ended a background task" for name in mesh.died]
    return {
        "missions": missions,
        "problems": stage.problems,
        "simulated_s": round(loop.time() - STARTED_S, 2),
        "collisions": world.truth.collisions,
        "activity": stage.activity.told(),
        "standing_s": round(stage.activity.standing_s, 1),
        "calls": dict(sorted(mesh.calls.items())),
        "track": stage.track,
    }


async def _say(stage: Stage, command: Command) -> list[dict[str, Any]]:
    """One command to its end; a row for each thing it asks for."""
    loop, mesh, world = asyncio.get_running_loop(), stage.mesh, stage.world
    start, asked_s, metres = world.truth.pose, loop.time(), world.truth.path_length_m
    floors = [_floors(world, Ways(world, start), asked) for asked in command.asked]
    calls = dict(mesh.calls)
    try:
        first = await mesh.missions.start(command.text)
    except MeshError as error:
        return [{"command": command.text, "asked": asked.model_dump(), "outcome": "refused",
                 "reason": error.detail} | floors[part] for part, asked in enumerate(command.asked)]  # fmt: skip
    assert isinstance(first, Mission)
    limit_s = asked_s + len(command.asked) * mesh.missions.runner.mission.rules.mission_timeout_s + SLACK_S
    rows: list[dict[str, Any]] = []
    begun_s, from_m = asked_s, metres
    for part, asked in enumerate(command.asked):
        mission = await _over(stage, first, part, limit_s)
        if mission is None:
            stage.problems.append(f"hang: '{command.text}' is not over after {loop.time() - asked_s:.0f} s")
            break
        judged = stage.judged.get(mission.id, {})
        ended_s = judged.get("stamp_s", loop.time())
        events = await mesh.missions.log.events(mission.id, after=-1, limit=5000)
        rows.append(
            {
                "command": command.text,
                "asked": asked.model_dump(),
                "outcome": mission.outcome.value if mission.outcome is not None else "none",
                "reason": mission.reason,
                "seconds": round(ended_s - begun_s, 2),
                "metres": round(judged.get("metres", from_m) - from_m, 3),
                "pose": judged["pose"].model_dump() if "pose" in judged else None,
                "score": {key: value for key, value in judged.items() if key not in {"pose", "metres", "stamp_s"}},
                "calls": {name: count - calls.get(name, 0) for name, count in sorted(mesh.calls.items())},
                "mission": mission.model_dump(mode="json"),
                "timeline": [event.model_dump(mode="json") for event in events],
            }
            | floors[part]
        )
        begun_s, from_m, calls = ended_s, judged.get("metres", from_m), dict(mesh.calls)
    await _rest(stage)
    return rows


async def _over(stage: Stage, first: Mission, part: int, limit_s: float) -> Mission | None:
    """The mission of that part of a command, once it is over."""
    loop, missions = asyncio.get_running_loop(), stage.mesh.missions
    while loop.time() < limit_s:
        newest = await missions.log.newest(20)
        mission = next((one for one in newest if one.request_id == first.request_id and one.part == part + 1), None)
        if mission is not None and mission.outcome is not None and mission.id in stage.judged:
            return mission
        stage.ended.clear()
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(stage.ended.wait(), 5.0)
    return None


async def _rest(stage: Stage) -> None:
    """Until the robot takes another command."""
    for _ in range(60):
        if not stage.mesh.missions.runner.mission.running:
            break
        await asyncio.sleep(0.5)
    await asyncio.sleep(3.0)


def _things(world: World, asked: Asked) -> list[ThingTruth]:
    return [
        thing
        for thing in world.truth.things
        if thing.kind == asked.kind and (asked.colour is None or thing.colour == asked.colour)
    ]


def _floors(world: World, ways: Ways, asked: Asked) -> dict[str, Any]:
    """The shortest ways to where it counts as found; none where it is not there."""
    things = _things(world, asked)
    lengths = {within_m: min((ways.to_find_m(t, within_m) for t in things), default=math.inf)
               for within_m in FOUND_WITHIN_M}  # fmt: skip
    return {
        "there": bool(things),
        "shortest_m": {str(k): round(v, 3) if math.isfinite(v) else None for k, v in lengths.items()},
        "floor_s": {str(k): round(floor_s(v), 2) if math.isfinite(v) else None for k, v in lengths.items()},
    }


def scored(world: World, kind: str, colour: str | None) -> dict[str, Any]:
    """How the robot stands to what was asked for; `false_find` where it stands before no such thing."""
    try:
        seen = score(world, kind, colour)
    except NothingToScoreError:
        return {"false_find": True, "within": {str(within_m): False for within_m in FOUND_WITHIN_M}}
    thing = next(one for one in world.truth.things if one.id == seen.thing_id)
    before_it = seen.facing and seen.unobstructed
    within = {
        str(within_m): before_it and seen.true_distance_m <= counts_within_m(world, thing, within_m)
        for within_m in FOUND_WITHIN_M
    }
    return {
        "thing": seen.thing_id,
        "true_distance_m": round(seen.true_distance_m, 3),
        "horizontal_distance_m": round(seen.horizontal_distance_m, 3),
        "facing": seen.facing,
        "unobstructed": seen.unobstructed,
        "correct": seen.correct,
        "within": within,
        "false_find": not before_it and seen.true_distance_m > 1.5,
        "in_front": [f"{one.colour} {one.kind}".strip() for one in seen.in_front[:3]],
    }


def circumstances(models: Loaded) -> dict[str, str]:
    """On what the digest rests."""
    detector, clip = models.detector, models.clip
    assert detector is not None
    assert clip is not None
    packages = ("mujoco", "numpy", "onnxruntime", "openvino", "torch", "opencv-python-headless")
    return {"machine": platform.machine(), "python": platform.python_version(),
            "detector": f"{detector.name} on {detector.backend}", "clip": f"{clip.name} on {clip.backend}",
            } | {name: found for name in packages if (found := _version(name))}  # fmt: skip


def _version(package: str) -> str:
    with contextlib.suppress(ImportError):
        return version(package)
    return ""


def without_wall_time(value: Any) -> Any:
    if isinstance(value, dict):
        fields = cast("dict[str, Any]", value)
        return {key: without_wall_time(one) for key, one in fields.items() if key not in UNTOLD}
    if isinstance(value, list | tuple):
        return [without_wall_time(one) for one in cast("list[Any]", value)]
    return value


def digest(record: Mapping[str, Any]) -> str:
    """Of everything but the wall clock's figures."""
    told = {key: value for key, value in record.items() if key not in {"wall", "digest"}}
    return hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()
