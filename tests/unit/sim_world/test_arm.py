"""An arm on the simulated robot: its weight is the robot's to carry, its servos have a real one's torque."""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from contracts.geometry import Pose2D
from sim.world import Hazard, World
from sim.world.arm.arm import SimulatedArm
from sim.world.arm.controller import Outcome, Tolerances
from sim.world.arm.models import SO101, ArmMissingError
from sim.world.arm.trajectory import Knot, Trajectory
from support.simulated_room import MIDDLE, PERFECT, drive, world_at

WITH_ARM = replace(PERFECT, arm=SO101)
STRETCHED = (0.0, 0.9, -0.9, 0.0, 0.0)
"""Level and straight ahead: as far out as its weight goes."""
TORQUE_NM = 3.35


@pytest.fixture
def world() -> Iterator[World]:
    with world_at(options=WITH_ARM) as world:
        yield world


def arm_of(world: World) -> SimulatedArm:
    assert world.arm is not None
    return world.arm


def positions(world: World) -> tuple[float, ...]:
    return tuple(each.position for each in arm_of(world).readings())


def mass_kg(world: World) -> float:
    body = world._body
    return float(body.model.body_subtreemass[body.root])


def floor_force_n(world: World) -> float:
    """What the floor bears of the robot, N."""
    import mujoco  # after `sim.world`, which chooses how it draws

    model, data, force = world._body.model, world._body.data, np.zeros(6)
    upward = 0.0
    for index in range(data.ncon):
        if "floor" in {model.geom(int(geom)).name for geom in data.contact[index].geom}:
            mujoco.mj_contactForce(model, data, index, force)
            upward += float(force[0])
    return upward


def tilt_rad(world: World) -> float:
    body = world._body
    return math.acos(min(1.0, float(body.data.xmat[body.root][8])))


def go(world: World, to: tuple[float, ...], seconds: float) -> None:
    still = (0.0,) * len(to)
    arm_of(world).follow(Trajectory(SO101.joints, (Knot(seconds, to, still),)), Tolerances())


def test_without_the_setting_there_is_no_arm_and_the_robot_weighs_what_it_did() -> None:
    with world_at() as bare:
        assert bare.arm is None
        assert mass_kg(bare) == pytest.approx(3.7)


def test_the_robot_carries_deck_and_arm(world: World) -> None:
    """MuJoCo's gravity compensation would carry the arm from outside: it is off."""
    assert mass_kg(world) == pytest.approx(3.7 + 0.33 + 0.632, abs=0.01)
    world.advance(1.0)
    assert floor_force_n(world) == pytest.approx(9.81 * mass_kg(world), rel=0.03)


def test_it_holds_its_posture_against_its_own_weight(world: World) -> None:
    world.advance(3.0)
    assert positions(world) == pytest.approx((*SO101.home, SO101.gripper_home), abs=0.03)


def test_it_follows_a_trajectory_within_its_servos_torque(world: World) -> None:
    go(world, STRETCHED, 3.0)
    strongest = 0.0
    for _ in range(100):
        world.advance(0.05)
        strongest = max(strongest, *(abs(each.effort) for each in arm_of(world).readings()))
    assert arm_of(world).trajectory.outcome is Outcome.SUCCEEDED
    assert positions(world)[:5] == pytest.approx(STRETCHED, abs=0.05)
    assert 0.3 < strongest <= TORQUE_NM


def test_a_stretched_arm_does_not_tip_the_robot_over(world: World) -> None:
    go(world, STRETCHED, 2.0)
    world.advance(5.0)
    assert tilt_rad(world) < math.radians(3.0)


def test_held_under_way_it_stands_within_0_3_s_and_stays(world: World) -> None:
    go(world, STRETCHED, 1.0)
    world.advance(0.5)
    assert max(abs(each.velocity) for each in arm_of(world).readings()) > 0.5
    arm_of(world).hold_arm()
    world.advance(0.3)
    stood = positions(world)
    world.advance(3.0)
    assert positions(world) == pytest.approx(stood, abs=0.02)
    assert arm_of(world).trajectory.outcome is Outcome.HELD


def test_the_jaw_opens_and_closes_with_no_more_torque_than_it_is_allowed(world: World) -> None:
    arm = arm_of(world)
    arm.grip(1.0, 0.0)
    world.advance(2.0)
    assert positions(world)[-1] == pytest.approx(1.0, abs=0.03)
    arm.grip(0.0, 0.5)
    strongest = 0.0
    for _ in range(60):
        world.advance(0.05)
        strongest = max(strongest, abs(arm.readings()[-1].effort))
    assert positions(world)[-1] == pytest.approx(0.0, abs=0.03)
    assert strongest <= 0.5


def test_folded_it_is_in_neither_picture_nor_scan(world: World) -> None:
    with world_at(options=PERFECT) as bare:
        assert np.mean(world.rgb() != bare.rgb()) < 0.01
        assert np.allclose(world.scan().ranges_m, bare.scan().ranges_m, atol=0.005)


def test_what_the_arm_touches_is_a_collision_and_no_bump() -> None:
    before_the_table = Pose2D(x=1.5, y=2.72, yaw=math.pi / 2)
    with world_at(before_the_table, options=WITH_ARM) as world:
        go(world, STRETCHED, 1.5)
        world.advance(3.0)
        assert world.truth.touching == ("table",)
        assert Hazard.BUMP not in world.hazards()


def test_it_drives_as_straight_and_as_far_as_without(world: World) -> None:
    drive(world, 0.3, 0.0, 2.0)
    with world_at(options=PERFECT) as bare:
        drive(bare, 0.3, 0.0, 2.0)
        assert world.truth.pose.x == pytest.approx(bare.truth.pose.x, abs=0.02)
        assert world.truth.pose.y == pytest.approx(bare.truth.pose.y, abs=0.01)


def test_put_elsewhere_it_is_folded_again(world: World) -> None:
    go(world, STRETCHED, 1.0)
    world.advance(2.0)
    world.teleport(MIDDLE)
    world.advance(0.5)
    assert positions(world)[:5] == pytest.approx(SO101.home, abs=0.03)
    assert arm_of(world).trajectory.outcome is Outcome.IDLE


def test_a_model_that_is_not_installed_is_told_with_what_to_do() -> None:
    absent = replace(SO101, module="no_such_arm")
    with pytest.raises(ArmMissingError, match="pip install --no-deps"):
        world_at(options=replace(PERFECT, arm=absent))
