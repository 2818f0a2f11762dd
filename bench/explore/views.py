"""How many bits of a view's hash change, where the robot stood still and where it did not: for `AskingRules.view_bits`.

python -m bench.explore.views --homes 3
"""

import argparse
import math
import sys
from collections.abc import Iterator

import numpy as np

from bench.search.running import begin, say
from contracts.geometry import Pose2D
from coordinator.exploration.rules import AskingRules
from coordinator.exploration.views import bits_apart, view_hash
from geometry.poses import compose
from sim.home import Home
from sim.world import World, WorldOptions
from sim.world.occupancy import reachable
from sim.world.robot import ROBOT_RADIUS_M

FIRST = 7200
GRAIN = 4.0
"""Standard deviation of the picture's noise, of 255."""
MOVES: dict[str, tuple[bool, Pose2D]] = {
    "stands": (True, Pose2D(x=0.0, y=0.0, yaw=0.0)),
    "trembles: 1 cm, 0.5 degrees": (True, Pose2D(x=0.01, y=0.0, yaw=math.radians(0.5))),
    "2 cm, 1 degree": (True, Pose2D(x=0.02, y=0.0, yaw=math.radians(1.0))),
    "turned 20 degrees": (False, Pose2D(x=0.0, y=0.0, yaw=math.radians(20.0))),
    "turned 57 degrees (look elsewhere)": (False, Pose2D(x=0.0, y=0.0, yaw=1.0)),
    "0.5 m ahead": (False, Pose2D(x=0.5, y=0.0, yaw=0.0)),
    "1.5 m ahead": (False, Pose2D(x=1.5, y=0.0, yaw=0.0)),
}
"""True where the view counts as unchanged."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--homes", type=int, default=3)
    parser.add_argument("--poses", type=int, default=40)
    options = parser.parse_args()
    begin()
    bits: dict[str, list[int]] = {name: [] for name in MOVES}
    for home in range(FIRST, FIRST + options.homes):
        for name, apart in _measured(home, options.poses):
            bits[name].append(apart)
    limit = AskingRules().view_bits
    say("| move | pairs | bits apart, 5th percentile | median | 95th | judged unchanged at " + str(limit) + " |")
    say("|---|---:|---:|---:|---:|---:|")
    for name, found in bits.items():
        low, middle, high = np.percentile(found, [5, 50, 95])
        same = np.mean(np.array(found) <= limit)
        say(f"| {name} | {len(found)} | {low:.0f} | {middle:.0f} | {high:.0f} | {same:.0%} |")
    say("\n" + _errors(bits))
    return 0


def _measured(home: int, poses: int) -> Iterator[tuple[str, int]]:
    rng = np.random.default_rng(home)
    with World(Home.generate(home), seed=home, options=WorldOptions(rgb_noise_sigma=GRAIN)) as world:
        room = reachable(world.grid, compose(world.scene.dock, Pose2D(x=-0.6, y=0.0, yaw=0.0)), ROBOT_RADIUS_M)
        cells = np.argwhere(room)
        for row, column in rng.choice(cells, poses, replace=False):
            x, y = world.grid.centre(int(row), int(column))
            at = Pose2D(x=x, y=y, yaw=float(rng.uniform(-math.pi, math.pi)))
            world.teleport(at)
            before = view_hash(world.rgb())
            for name, (_, move) in MOVES.items():
                there = compose(at, move)
                cell = world.grid.cell(there.x, there.y)
                if not room[cell]:
                    continue
                world.teleport(there)
                yield name, bits_apart(before, view_hash(world.rgb()))


def _errors(bits: dict[str, list[int]]) -> str:
    """The limit at which as few as may be are judged wrong: unchanged ones asked about, changed ones kept silent."""
    same = np.array([one for name, found in bits.items() if MOVES[name][0] for one in found])
    other = np.array([one for name, found in bits.items() if not MOVES[name][0] for one in found])
    rows = ["| limit, bits | unchanged, asked about | changed, not asked about |", "|---:|---:|---:|"]
    rows += [
        f"| {limit} | {np.mean(same > limit):.1%} | {np.mean(other <= limit):.1%} |"
        for limit in (2, 4, 6, 8, 10, 12, 16)
    ]
    return "\n".join(rows)


if __name__ == "__main__":
    sys.exit(main())
