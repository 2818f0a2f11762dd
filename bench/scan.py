"""The look round of 420 degrees, as stop-look-turn and as one slow turn: how long it takes, and what it sees.

`make bench-scan`. In simulated homes without faults: a scan where the thing asked for stands in sight within 1.8 m,
which counts as seen when the scan ends with a sighting; and a scan where there is no such thing, whose length counts.
Writes out/bench/scan.json. The simulated camera does not blur, so the slow turn loses nothing to motion here.
"""

import argparse
import json
import math
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from bench.campaign import played
from bench.missions.bridge import DESCRIPTION
from bench.missions.place import SimulatedPlace
from bench.missions.run import Run
from bench.missions.scenario import Present, Remembered, Scenario, scenario, wanted_in
from bench.results import quiet, save
from bench.world.faults import Faults
from contracts.geometry import Pose2D
from contracts.mission import MissionState
from coordinator.core.plain.searching import sweep_speed_rad_s
from coordinator.core.rules import Policy, Rules, ScanRule
from sim.world.types import ThingTruth

WITHIN_M = 1.8


def first_scan(run: Run) -> tuple[float, str] | None:
    """(seconds, state that followed) of the mission's first look round; none where it never ended."""
    began: float | None = None
    for event in run.events:
        if event.state is MissionState.SCANNING and began is None:
            began = event.stamp_s
        elif began is not None and event.data.before is MissionState.SCANNING:
            return event.stamp_s - began, event.state.value
    return None


def in_sight_of(place: SimulatedPlace, thing: ThingTruth, rng: np.random.Generator) -> Pose2D | None:
    """A pose that could see the thing within range if it looked there, but looks somewhere else."""
    for view in place.views_of(thing.x_m, thing.y_m, rng, 6):
        shown = [one for one in place.in_picture(view) if one.thing.id == thing.id and one.visible > 0.6]
        if shown and shown[0].distance_m < WITHIN_M:
            return Pose2D(x=view.x, y=view.y, yaw=math.remainder(view.yaw + rng.uniform(1.5, 4.5), math.tau))
    return None


def measured(rule: ScanRule, homes: int) -> dict[str, Any]:
    seen, took_to_see, took_whole = 0, list[float](), list[float]()
    tried = 0
    for home in range(homes):
        place = SimulatedPlace(home, *wanted_in(home))
        rng = np.random.default_rng([home, 9])
        plain = scenario(home, faults=Faults())
        one = replace(plain, rules={"scan_rule": rule.value}, remembered=Remembered.NOTHING, docked=False)
        wanted = [t for t in place.things if t.kind == one.kind and t.colour == one.colour]
        start = in_sight_of(place, wanted[0], rng) if wanted else None
        if start is not None:
            there = replace(one, present=Present.THERE, asked_colour=one.colour, start=start)
            scan = first_scan(scanned(there, place))
            if scan is not None:
                tried += 1
                seen += scan[1] == MissionState.CENTERING.value
                took_to_see.append(scan[0])
        absent = replace(one, present=Present.ABSENT, kind="boat", start=place.random_pose(rng))
        scan = first_scan(scanned(absent, place))
        if scan is not None and scan[1] == MissionState.MOVING_TO_SCAN.value:
            took_whole.append(scan[0])
        place.close()
    return {
        "scans_with_it_in_sight": tried,
        "seen": seen,
        "seconds_until_seen_p50": round(float(np.median(took_to_see)), 2),
        "whole_scans": len(took_whole),
        "seconds_whole_p50": round(float(np.median(took_whole)), 2),
        "seconds_whole_max": round(max(took_whole), 2),
    }


def scanned(one: Scenario, place: SimulatedPlace) -> Run:
    """Played for no longer than a scan and a little takes."""
    return played(replace(one, rules={**one.rules, "mission_timeout_s": 45.0}), place)[0]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--homes", type=int, default=40)
    parser.add_argument("--out", type=Path, default=Path("out/bench/scan.json"))
    parser.add_argument("--quick", action="store_true", help="4 homes")
    options = parser.parse_args()
    quiet()
    figures = {rule.value: measured(rule, 4 if options.quick else options.homes) for rule in ScanRule}
    save(options.out, figures)
    for rule, row in figures.items():
        sys.stdout.write(f"{rule:14} {json.dumps(row)}\n")
    sys.stdout.write(f"a slow turn goes at {sweep_speed_rad_s(Rules.of(Policy(), DESCRIPTION)):.2f} rad/s\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
