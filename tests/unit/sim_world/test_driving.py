"""How the simulated base moves: its speeds, its limits, its own timeout, and what stops it."""

import math
from dataclasses import replace

import pytest

from contracts.geometry import Pose2D
from sim.world import Hazard, World
from sim.world.base import BACKUP_LIMIT_M
from support.simulated_room import DOCK, MIDDLE, PERFECT, drive, world_at


def _way(world: World, start: Pose2D) -> float:
    return math.hypot(world.truth.pose.x - start.x, world.truth.pose.y - start.y)


def test_full_speed_is_0_306_m_s_within_2_percent() -> None:
    world = world_at()
    drive(world, 0.306, 0.0, 1.0)
    start = world.truth.pose
    drive(world, 0.306, 0.0, 2.0)
    assert _way(world, start) == pytest.approx(2.0 * 0.306, rel=0.02)
    assert abs(world.truth.pose.yaw) < 0.01


def test_a_faster_command_is_cut_to_the_limit() -> None:
    world = world_at()
    drive(world, 2.0, 0.0, 1.5)
    assert world.truth.twist.linear_x == pytest.approx(0.306, rel=0.02)


@pytest.mark.parametrize("rate", [1.0, -0.3, 0.05])
def test_it_turns_on_the_spot_at_the_rate_asked_for(rate: float) -> None:
    world = world_at()
    drive(world, 0.0, rate, 1.0)
    before = world.truth.pose.yaw
    drive(world, 0.0, rate, 2.0)
    turned = math.remainder(world.truth.pose.yaw - before, 2 * math.pi)
    assert turned == pytest.approx(2.0 * rate, rel=0.05)
    assert _way(world, MIDDLE) < 0.02


def test_it_starts_no_faster_than_0_9_m_s2() -> None:
    world = world_at()
    drive(world, 0.3, 0.0, 0.2)
    assert 0.1 < world.truth.twist.linear_x <= 0.9 * 0.2 + 0.01


@pytest.mark.parametrize(("timeout_s", "way_m"), [(0.15, 0.03), (0.5, 0.1)])
def test_one_command_moves_it_until_the_bases_own_timeout_and_no_longer(timeout_s: float, way_m: float) -> None:
    world = world_at(options=replace(PERFECT, base_timeout_s=timeout_s))
    world.command(0.2, 0.0)
    world.advance(2.0)
    assert _way(world, MIDDLE) == pytest.approx(way_m, rel=0.35)
    assert abs(world.truth.twist.linear_x) < 0.005


@pytest.mark.parametrize("timeout_s", [0.15, 0.5])
def test_it_rests_its_timeout_and_the_ramp_after_the_last_command_and_not_before(timeout_s: float) -> None:
    world = world_at(options=replace(PERFECT, base_timeout_s=timeout_s))
    drive(world, 0.306, 0.0, 1.5)
    world.command(0.306, 0.0)
    world.advance(timeout_s)
    assert world.truth.twist.linear_x > 0.25
    world.advance(0.306 / 0.9 + 0.05)
    assert abs(world.truth.twist.linear_x) < 0.01
    before = world.truth.pose
    world.advance(1.0)
    assert _way(world, before) < 0.005


@pytest.mark.parametrize("command", [(math.nan, 0.0), (0.2, math.inf), (-math.inf, math.nan)])
def test_numbers_that_are_not_finite_are_refused_and_move_nothing(command: tuple[float, float]) -> None:
    world = world_at()
    assert not world.command(*command)
    world.advance(1.0)
    assert _way(world, MIDDLE) < 0.002


def test_the_e_stop_brakes_and_holds_until_it_is_off() -> None:
    world = world_at()
    drive(world, 0.3, 0.0, 1.0)
    world.set_e_stop(True)
    world.advance(0.5)
    halted = world.truth.pose
    assert not world.command(0.3, 0.0)
    drive(world, 0.3, 0.0, 1.0)
    assert _way(world, halted) < 0.005
    world.set_e_stop(False)
    world.advance(0.5)
    assert _way(world, halted) < 0.005
    drive(world, 0.3, 0.0, 1.0)
    assert _way(world, halted) > 0.1


def test_reversing_ends_at_the_backup_limit_with_a_hazard() -> None:
    world = world_at()
    drive(world, -0.1, 0.0, 4.0)
    assert _way(world, MIDDLE) == pytest.approx(BACKUP_LIMIT_M, abs=0.03)
    assert Hazard.BACKUP_LIMIT in world.hazards()
    drive(world, 0.1, 0.0, 1.0)
    assert Hazard.BACKUP_LIMIT not in world.hazards()


def test_the_bases_own_behaviour_backs_off_the_dock() -> None:
    world = world_at(DOCK)
    assert world.dock_status().is_docked
    assert world.battery().charging or world.battery().percentage < 100.0
    drive(world, -0.15, 0.0, 2.5, behaviour=True)
    assert _way(world, DOCK) > 0.3
    assert not world.dock_status().is_docked
    assert world.dock_status().dock_visible


def test_a_wall_stops_it_with_a_bump_and_it_never_passes_through() -> None:
    world = world_at(Pose2D(x=5.2, y=2.0, yaw=0.0))
    drive(world, 0.306, 0.0, 4.0)
    assert Hazard.BUMP in world.hazards()
    assert Hazard.STALL in world.hazards()
    assert world.truth.pose.x < 6.0 - 0.16
    assert world.truth.collisions >= 1
    assert "world" in world.truth.touching


def test_in_the_open_there_is_no_hazard() -> None:
    world = world_at()
    drive(world, 0.2, 0.5, 2.0)
    assert world.hazards() == ()
    assert world.truth.collisions == 0


def test_things_stay_where_they_are_when_pushed() -> None:
    world = world_at(Pose2D(x=4.0, y=3.0, yaw=0.0))
    drive(world, 0.2, 0.0, 3.0)
    assert world.truth.touching == ("bottle_red",)
    assert world.truth.pose.x < 4.5 - 0.04 - 0.15


def test_the_way_driven_is_counted_and_teleports_are_not() -> None:
    world = world_at()
    drive(world, 0.3, 0.0, 3.0)
    driven = world.truth.path_length_m
    assert driven == pytest.approx(_way(world, MIDDLE), abs=0.02)
    world.teleport(Pose2D(x=1.0, y=1.0, yaw=1.0))
    world.advance(1.0)
    assert world.truth.path_length_m == pytest.approx(driven, abs=0.001)
    assert world.truth.pose.x == pytest.approx(1.0, abs=0.005)


def test_the_truth_keeps_when_the_robot_last_moved() -> None:
    world = world_at()
    drive(world, 0.3, 0.0, 1.0)
    told_s = world.time_s
    world.advance(3.0)  # the base times out by itself
    assert told_s < world.truth.moved_at_s < told_s + 0.9
    stood_s = world.truth.moved_at_s
    world.command(0.0, 0.5)
    world.advance(0.1)
    assert world.truth.moved_at_s > stood_s


def test_the_same_seed_and_calls_give_the_same_world_however_time_is_sliced() -> None:
    one, two = world_at(seed=7), world_at(seed=7)
    one.command(0.3, 0.4)
    two.command(0.3, 0.4)
    one.advance(0.13)
    for _ in range(26):
        two.advance(0.005)
    assert one.truth == two.truth
    assert one.time_s == pytest.approx(0.13)


def test_time_does_not_run_backwards() -> None:
    with pytest.raises(ValueError, match="forward"):
        world_at().advance(-0.1)
