"""Seeded episodes of a fetch: which thing stands where, how it went, and what of it is written down."""

import math
import time
from dataclasses import dataclass
from random import Random
from typing import Any

from bench.fetch.arm import reachability
from bench.fetch.scene import KINDS, PLACES, STANCE, Setting, scene_of
from bench.fetch.shell import FetchShell, brought, grasped
from contracts.manipulation import GraspKind
from grasping.candidates import PITCHES_DEG
from grasping.hands import SO101_HAND
from grasping.reachability import distance_scores
from grasping.things import grasp_kind_of
from sim.world import World, WorldOptions
from sim.world.arm.fitting import FOOT_X_M
from sim.world.arm.models import SO101
from sim.world.robot import BODY_RADIUS_M

STOPPED_AT_M = 0.02
"""Standard deviation of where the robot stands by where it wanted to, along and across."""
OFF_SQUARE_RAD = 0.08
"""A box the robot stands before squarely: of all the places round it, one from which the jaw meets its sides."""
CLEAR_M = 0.02


@dataclass(frozen=True, slots=True)
class FetchEpisode:
    seed: int
    setting: Setting


def episodes(count: int, first: int = 1) -> list[FetchEpisode]:
    """Every kind at every place in turn; where exactly is drawn from the seed."""
    cases = [(kind, place) for place in PLACES for kind in KINDS]
    return [drawn(seed, *cases[(seed - first) % len(cases)]) for seed in range(first, first + count)]


def drawn(seed: int, kind: str, place: str) -> FetchEpisode:
    """The robot stands where its map of reach says, as well as a robot stands where it wanted to."""
    chance, one = Random(seed), KINDS[kind]
    ahead_m = best_distance_m(kind, place)
    nearest_m = BODY_RADIUS_M + one.length_m / 2 + CLEAR_M
    setting = Setting(
        kind, place,
        max(nearest_m, ahead_m + chance.gauss(0.0, STOPPED_AT_M)), chance.gauss(0.0, 2 * STOPPED_AT_M),
        chance.gauss(0.0, OFF_SQUARE_RAD) if not one.round else 0.0,
    )  # fmt: skip
    return FetchEpisode(seed, setting)


def best_distance_m(kind: str, place: str) -> float:
    """Of the thing's middle from base_link; where the map knows none, the nearest there is."""
    one = KINDS[kind]
    height_m = PLACES[place] + 0.7 * one.height_m
    how = grasp_kind_of(one.label, one.height_m)
    pitches = tuple(math.radians(each) for each in PITCHES_DEG[how if how is GraspKind.SIDE else GraspKind.TOP])
    nearest_m = BODY_RADIUS_M + one.length_m / 2 + CLEAR_M
    found = distance_scores(reachability(), height_m, pitches, FOOT_X_M + SO101_HAND.pan_from_foot_m, nearest_m)
    return found[0][0] if found else nearest_m


def world_of(setting: Setting) -> World:
    return World(scene_of(setting), start=STANCE, options=WorldOptions(noise_free=True, arm=SO101))


def played(episode: FetchEpisode) -> dict[str, Any]:
    """Plain data, one row of the table."""
    began_s = time.process_time()
    with world_of(episode.setting) as world:
        world.advance(0.5)
        shell = FetchShell(world, episode.setting, episode.seed)
        finish = shell.run()
        truth = shell.truth
        return {
            "seed": episode.seed,
            "kind": episode.setting.kind,
            "place": episode.setting.place,
            "ahead_m": round(episode.setting.ahead_m, 3),
            "left_m": round(episode.setting.left_m, 3),
            "end": finish.end.value,
            "cause": finish.cause.value if finish.cause is not None else "",
            "grasped": grasped(shell),
            "brought": brought(shell),
            "said_held_without_it": truth.said_held and not truth.was_held,
            "lifted_mm": round(1000 * truth.lifted_m),
            "slipped_mm": round(1000 * truth.slipped_m, 2),
            "recoveries": [each.value for each in shell.fetch.used],
            "simulated_s": round(world.time_s, 1),
            "cpu_s": round(time.process_time() - began_s, 1),
        }
