"""The look round of 420 degrees, as stop-look-turn and as one slow turn: how long it takes, and what it sees.

`make bench-scan`. Each step on its own (the policy `viewpoints`) in homes of `bench/search`, through all services and
with the real eyes: a scan where the thing asked for stands in sight within 1.8 m, which counts as seen when the scan
ends with a sighting; and a scan where there is no such thing, whose length counts. Writes out/bench/scan.json. The
simulated camera does not blur, so the slow turn loses nothing to motion here.
"""

import argparse
import json
import math
import sys
from pathlib import Path
from typing import Any

import numpy as np

from bench.results import save
from bench.search.episode import Episode
from bench.search.play import played
from bench.search.running import begin, loaded, prepare_exports
from bench.search.sets import TUNE_HOMES, Site, episode, site
from bench.world.body import DESCRIPTION
from bench.world.mesh import MeshSettings
from contracts.geometry import Pose2D
from contracts.mission import MissionEvent, MissionState
from coordinator.core.plain.searching import sweep_speed_rad_s
from coordinator.core.rules import Policy, Rules, ScanRule
from inference.perception.models import Loaded
from sim.scoring import camera_position, unobstructed
from sim.world import ThingTruth
from sim.world.occupancy import reachable
from sim.world.robot import ROBOT_RADIUS_M

NEARER_M, WITHIN_M = 0.9, 1.8
LIMIT_S = 45.0
"""No longer than a scan and a little takes."""
TOURS = Path("out/bench/search/tours")


def first_scan(timeline: list[dict[str, Any]]) -> tuple[float, MissionState] | None:
    """(seconds, state that followed) of the mission's first look round; none where it never ended."""
    began: float | None = None
    for event in map(MissionEvent.model_validate, timeline):
        if event.state is MissionState.SCANNING and began is None:
            began = event.stamp_s
        elif began is not None and event.data.before is MissionState.SCANNING:
            return event.stamp_s - began, event.state
    return None


def in_sight_of(at: Site, thing: ThingTruth, rng: np.random.Generator) -> Pose2D | None:
    """A pose that could see the thing within range if it looked there, but looks somewhere else."""
    world = at.world
    rows, columns = np.nonzero(reachable(world.grid, world.scene.dock, ROBOT_RADIUS_M))
    places = world.grid.centres(rows, columns)
    away_m = np.hypot(places[:, 0] - thing.x_m, places[:, 1] - thing.y_m)
    for x, y in rng.permutation(places[(away_m > NEARER_M) & (away_m < WITHIN_M)])[:60].tolist():
        facing = math.atan2(thing.y_m - y, thing.x_m - x)
        if unobstructed(world, camera_position(Pose2D(x=x, y=y, yaw=facing)), thing):
            return Pose2D(x=x, y=y, yaw=math.remainder(facing + rng.uniform(1.5, 4.5), math.tau))
    return None


def measured(rule: ScanRule, homes: int, models: Loaded, settings: MeshSettings) -> dict[str, Any]:
    seen, took_to_see, took_whole = 0, list[float](), list[float]()

    def scan_of(one: Episode) -> tuple[float, MissionState] | None:
        changes = f"scan_rule={rule.value}", f"mission_timeout_s={LIMIT_S:g}"
        (row,) = played(
            one.model_copy(update={"policy": "viewpoints", "changes": changes}), models, settings, tours=TOURS
        )["missions"]
        return first_scan(row["timeline"])

    for number in range(homes):
        there = episode("unseen", number, TUNE_HOMES)
        at, (asked,), rng = site(there.home_seed), there.commands[0].asked, np.random.default_rng([number, 9])
        thing = next(one for one in at.world.truth.things if (one.kind, one.colour) == (asked.kind, asked.colour))
        start = in_sight_of(at, thing, rng)
        scan = scan_of(there.model_copy(update={"start": start})) if start is not None else None
        if scan is not None:
            seen += scan[1] is MissionState.CENTERING
            took_to_see.append(scan[0])
        scan = scan_of(episode("absent", number, TUNE_HOMES).model_copy(update={"tour": False}))
        if scan is not None and scan[1] is MissionState.MOVING_TO_SCAN:
            took_whole.append(scan[0])
    return {
        "scans_with_it_in_sight": len(took_to_see),
        "seen": seen,
        "seconds_until_seen_p50": _middle(took_to_see),
        "whole_scans": len(took_whole),
        "seconds_whole_p50": _middle(took_whole),
        "seconds_whole_max": round(max(took_whole), 2) if took_whole else None,
    }


def _middle(took_s: list[float]) -> float | None:
    return round(float(np.median(took_s)), 2) if took_s else None


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--homes", type=int, default=10)
    parser.add_argument("--out", type=Path, default=Path("out/bench/scan.json"))
    parser.add_argument("--quick", action="store_true", help="2 homes")
    options = parser.parse_args()
    begin()
    prepare_exports("sim")
    models, settings = loaded("sim")
    homes = 2 if options.quick else options.homes
    figures = {rule.value: measured(rule, homes, models, settings) for rule in ScanRule}
    save(options.out, figures)
    for rule, row in figures.items():
        sys.stdout.write(f"{rule:14} {json.dumps(row)}\n")
    sys.stdout.write(f"a slow turn goes at {sweep_speed_rad_s(Rules.of(Policy(), DESCRIPTION)):.2f} rad/s\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
