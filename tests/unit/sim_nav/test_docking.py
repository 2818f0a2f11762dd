"""The base's own behaviours, in the real World on its simulated clock."""

import math

import pytest

from contracts.geometry import Pose2D
from geometry.poses import compose
from sim.home import Home
from sim.ros.behaviour import BaseBehaviours, Behaviour, Ending
from sim.world import World


def world_at(relative_to_dock: Pose2D | None) -> World:
    home = Home.generate(3)
    dock = Pose2D(x=home.dock.x_m, y=home.dock.y_m, yaw=home.dock.yaw)
    return World(home, start=None if relative_to_dock is None else compose(dock, relative_to_dock))


def run(world: World, behaviour: Behaviour) -> Behaviour:
    behaviours = BaseBehaviours()
    behaviours.take(behaviour)
    while behaviours.step(world):
        world.advance(0.05)
    return behaviour


def never() -> bool:
    return False


@pytest.mark.parametrize("start", [(-0.5, 0.0, 0.0), (-0.9, 0.25, -0.2), (-0.7, -0.2, 0.4), (-1.5, 0.1, 0.1)])
def test_a_robot_that_sees_the_dock_drives_in(start: tuple[float, float, float]) -> None:
    with world_at(Pose2D(x=start[0], y=start[1], yaw=start[2])) as world:
        assert run(world, Behaviour.docking(never)).ending is Ending.DONE
        assert world.dock_status().is_docked
        assert world.time_s < 40.0


def test_a_docked_robot_backs_off_and_turns_round() -> None:
    with world_at(None) as world:
        done = run(world, Behaviour.undocking(never))
        assert (done.ending, world.dock_status().is_docked) == (Ending.DONE, False)
        turned = world.truth.pose.yaw - world.scene.dock.yaw
        assert abs(math.remainder(turned - math.pi, math.tau)) < 0.15


def test_a_dock_behind_the_robot_is_not_seen_and_not_driven_to() -> None:
    with world_at(Pose2D(x=-0.5, y=0.0, yaw=math.pi)) as world:
        assert run(world, Behaviour.docking(never)).ending is Ending.FAILED
        assert world.truth.path_length_m == pytest.approx(0.0, abs=0.01)


def test_the_e_stop_and_a_cancel_end_a_behaviour_and_a_second_one_has_to_wait() -> None:
    with world_at(None) as world:
        behaviours, first, second = BaseBehaviours(), Behaviour.undocking(never), Behaviour.undocking(never)
        behaviours.take(first)
        behaviours.take(second)
        assert second.ending is Ending.FAILED
        behaviours.step(world)
        world.set_e_stop(True)
        behaviours.step(world)
        assert first.ending is Ending.FAILED
        world.set_e_stop(False)
        assert run(world, Behaviour.undocking(lambda: True)).ending is Ending.CANCELED
