"""How long the coordinator thinks: one step of the mission core, and one coverage plan, by the size of the map.

`make bench-coordinator`. Steps are those of whole episodes of `bench/search`, through all services; coverage is the
viewpoint planner on a generated floor plan with nothing looked at yet. Writes out/bench/coordinator.json, and
coordinator.png with the lawnmower beside.
"""

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from bench.floors import floor_plan
from bench.results import pyplot, save
from bench.search.play import played
from bench.search.running import begin, loaded, prepare_exports
from bench.search.sets import TUNE_HOMES, episode
from contracts.geometry import Pose2D
from coordinator.core.rules import Policy
from coordinator.coverage.lawnmower import lawnmower
from coordinator.coverage.viewpoints import viewpoints
from coordinator.coverage.visibility import VisibilityIndex  # noqa: F401 - loaded before the clock runs
from coordinator.execution import mission_runner
from sim.world.robot import ROBOT_RADIUS_M

TOURS = Path("out/bench/search/tours")
SIZES_M = ((10, 8), (20, 16), (30, 30), (50, 50), (70, 70), (100, 100))
AIM_STEP_P99_MS, AIM_HOME_MS, AIM_HALL_MS = 1.0, 50.0, 2000.0


def step_times_ms(missions: int) -> list[float]:
    """Of every step of that many missions in homes that the robot has not seen."""
    prepare_exports("sim")
    models, settings = loaded("sim")
    took: list[float] = []
    real = mission_runner.step

    def timed(*arguments: Any) -> Any:
        began = time.perf_counter_ns()
        answer = real(*arguments)
        took.append((time.perf_counter_ns() - began) / 1e6)
        return answer

    mission_runner.step = timed
    try:
        for number in range(missions):
            played(episode("unseen", number, TUNE_HOMES), models, settings, tours=TOURS)
    finally:
        mission_runner.step = real
    return took


def best_ms(work: Callable[[], Any], repeats: int) -> float:
    """The median of several runs, after one that does not count."""
    work()
    took: list[float] = []
    for _ in range(repeats):
        began = time.perf_counter()
        work()
        took.append((time.perf_counter() - began) * 1e3)
    return float(np.median(took))


def coverage_times_ms(sizes: tuple[tuple[int, int], ...], repeats: int) -> dict[str, tuple[float, float, int]]:
    """By size: (viewpoints, lawnmower, number of viewpoints)."""
    rules = Policy()
    times: dict[str, tuple[float, float, int]] = {}
    for width, depth in sizes:
        grid = floor_plan(width, depth)
        row, column = np.argwhere(grid.free)[int(grid.free.sum()) // 2]
        x, y = grid.centre(int(row), int(column))

        def plan() -> Any:
            start = Pose2D(x=x, y=y, yaw=0.0)  # noqa: B023 - called within the turn
            return viewpoints(
                grid, radius_m=ROBOT_RADIUS_M, start=start, reach_m=rules.look_range_m, points_max=rules.scan_points_max  # noqa: B023
            )  # fmt: skip

        times[f"{width}x{depth}"] = (
            best_ms(plan, repeats),
            best_ms(lambda: lawnmower(grid, radius_m=ROBOT_RADIUS_M), repeats),  # noqa: B023
            len(plan().points),
        )
    return times


def plot(steps_ms: list[float], coverage: dict[str, tuple[float, float, int]], path: Path) -> None:
    plt = pyplot()
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.2))
    left.hist(np.clip(steps_ms, 1e-3, 10.0), bins=np.logspace(-3, 1, 60), color="#4477aa")
    left.axvline(AIM_STEP_P99_MS, color="#cc3311", linestyle="--", label="aim for the 99th percentile")
    left.set(xscale="log", yscale="log", xlabel="one step, ms", ylabel="steps", title="mission core")
    cells = [np.prod([float(side) / 0.05 for side in name.split("x")]) for name in coverage]
    right.plot(cells, [c[0] for c in coverage.values()], "o-", label="viewpoints")
    right.plot(cells, [c[1] for c in coverage.values()], "s-", label="lawnmower")
    right.plot([cells[0], cells[-1]], [AIM_HOME_MS, AIM_HALL_MS], "x", color="#cc3311", markersize=10, label="aims")
    for x, (name, times) in zip(cells, coverage.items(), strict=True):
        right.annotate(f"{name} m", (x, times[0]), textcoords="offset points", xytext=(4, 8), fontsize=8)
    right.set(xscale="log", yscale="log", xlabel="cells of the map", ylabel="one plan, ms", title="coverage")
    for axes in (left, right):
        axes.legend(fontsize=8)
        axes.grid(alpha=0.3)
    figure.tight_layout()
    figure.savefig(path, dpi=110)
    plt.close(figure)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--missions", type=int, default=3, help="simulated missions whose steps are timed: a minute or two each"
    )
    parser.add_argument("--repeats", type=int, default=7, help="plans for each size; the median counts")
    parser.add_argument("--out", type=Path, default=Path("out/bench"))
    parser.add_argument("--quick", action="store_true", help="one mission and the two smallest maps")
    options = parser.parse_args()
    begin()
    sizes = SIZES_M[:2] if options.quick else SIZES_M
    coverage = coverage_times_ms(sizes, options.repeats)
    steps_ms = step_times_ms(1 if options.quick else options.missions)
    figures = {
        "step_p50_ms": round(float(np.percentile(steps_ms, 50)), 4),
        "step_p99_ms": round(float(np.percentile(steps_ms, 99)), 4),
        "coverage_ms": {name: round(times[0], 2) for name, times in coverage.items()},
    }
    save(options.out / "coordinator.json", figures)
    plot(steps_ms, coverage, options.out / "coordinator.png")
    sys.stdout.write(
        f"step: p50 {figures['step_p50_ms']} ms, p99 {figures['step_p99_ms']} ms of {len(steps_ms)} steps\n"
    )
    for name, (view, lawn, points) in coverage.items():
        sys.stdout.write(f"{name:>8} m: viewpoints {view:8.1f} ms ({points} points), lawnmower {lawn:7.1f} ms\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
