"""The thread that owns the World: work handed in, velocities applied, errors told, nothing left waiting."""

import threading
import time
from concurrent.futures import CancelledError

import pytest

from contracts.geometry import Pose2D, Twist2D
from sim.home import Home
from sim.ros.realtime import SLICE_S, Duty, RealTime
from sim.world import World


def in_the_middle_of_a_home() -> World:
    home = Home.generate(3)
    room = max(home.rooms, key=lambda r: r.area_m2)
    x, y = (room.x_min_m + room.x_max_m) / 2, (room.y_min_m + room.y_max_m) / 2
    return World(home, start=Pose2D(x=x, y=y, yaw=0.0))


def test_time_passes_duties_run_and_velocities_arrive() -> None:
    turned, stamps = threading.Event(), list[int]()

    def look(world: World, stamp_ns: int) -> None:
        stamps.append(stamp_ns)
        realtime.command(Twist2D(angular_z=1.0))
        if world.truth.twist.angular_z > 0.5:
            turned.set()

    realtime = RealTime(in_the_middle_of_a_home, lambda _: [Duty("look", 20.0, look)])
    realtime.start(on_death=lambda: None)
    assert turned.wait(30.0)
    assert realtime.call(lambda world: world.truth.path_length_m).result(5.0) < 0.1
    realtime.stop()
    assert realtime.error is None
    assert realtime.pace.factor > 0.3
    assert stamps == sorted(stamps)


def test_how_far_it_is_behind_grows_with_the_wall_clock_while_the_world_waits() -> None:
    def look(world: World) -> tuple[float, float, float, float]:
        before_s, first_s = time.monotonic(), realtime.behind_s(world)
        second_s = realtime.behind_s(world)
        return first_s, second_s, second_s - first_s, time.monotonic() - before_s

    realtime = RealTime(in_the_middle_of_a_home, lambda _: [])
    realtime.start(on_death=lambda: None)
    first_s, second_s, grown_s, passed_s = realtime.call(look).result(30.0)
    realtime.stop()
    assert SLICE_S <= first_s < second_s
    assert grown_s <= passed_s


def test_an_error_in_a_duty_ends_the_thread_and_is_told() -> None:
    died = threading.Event()

    def fail(_: World, __: int) -> None:
        raise RuntimeError("a wheel came off")

    realtime = RealTime(in_the_middle_of_a_home, lambda _: [Duty("fail", 20.0, fail)])
    realtime.start(on_death=died.set)
    assert died.wait(30.0)
    realtime.stop()
    assert str(realtime.error) == "a wheel came off"


def test_work_handed_in_after_the_end_is_cancelled_and_errors_go_back_to_whoever_asked() -> None:
    realtime = RealTime(in_the_middle_of_a_home, lambda _: [])
    realtime.start(on_death=lambda: None)
    with pytest.raises(KeyError):
        realtime.call(lambda world: world.volumes("no such thing")).result(30.0)
    realtime.stop()
    with pytest.raises(CancelledError):
        realtime.call(lambda world: world.time_s).result(1.0)
    assert realtime.ask(lambda world: world.time_s) is False
    assert realtime.error is None
