"""Random requests, clocks, scans, hazards and stops against the arbiter, the filter and the stop together."""

import contextlib
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule
from numpy.typing import NDArray

from contracts.geometry import Pose2D, Twist2D
from contracts.motion import Hazard
from contracts.robot import EmergencyStop, Priority
from mesh.errors import ConflictError
from robot_bridge.motion.arbiter import TICK_S_MAX, Refusal, Request
from robot_bridge.motion.motion_executor import ActiveMotion
from robot_bridge.motion.motions import GAINS, DriveOnHeading, Spin, Tuning
from robot_bridge.motion.sessions import Sessions
from robot_bridge.motion.velocity_mux import STOP_BURST, VelocityLimits, VelocityMux
from robot_bridge.safety.emergency_stop import LatchFile
from robot_bridge.sensing.blindness import NO_ARCS, Arcs
from robot_bridge.sensing.sensor_readings import Odometry, Scan, SensorReadings

LIMITS = VelocityLimits()
ANY = st.floats(allow_nan=True, allow_infinity=True)
SPEED = st.one_of(st.floats(-3.0, 3.0), ANY)


class ManualClock:
    now = 1000.0

    def now_s(self) -> float:
        return self.now

    async def sleep(self, seconds: float) -> None:
        self.now += seconds


def wall_scan(distance_m: float) -> Scan:
    """A wall ahead and one behind, this far from the footprint."""
    y = np.linspace(-2.0, 2.0, 81)
    x = np.full_like(y, distance_m + LIMITS.footprint_radius_m)
    return Scan(0.0, np.concatenate([np.stack([x, y], 1), np.stack([-x, y], 1)]))


def unseen(blind: Arcs) -> NDArray[np.float64]:
    """Where a leg of 6 cm could stand, all of it within an unknown arc."""
    bearing = np.linspace(-math.pi, math.pi, 181)
    at_m = LIMITS.footprint_radius_m + 0.05
    inside = np.zeros(bearing.size, np.bool_)
    for begin, width in blind:
        off = (bearing - begin) % math.tau
        inside |= (off > 0.03 / at_m) & (off < width - 0.03 / at_m)
    return at_m * np.stack([np.cos(bearing[inside]), np.sin(bearing[inside])], axis=1)


def touches(twist: Twist2D, points_m: NDArray[np.float64]) -> bool:
    """Does the footprint meet a point on the next `stop_distance_m` of the twist's arc? Tried out place by place."""
    driven_m = np.linspace(0.0, LIMITS.stop_distance_m, 41)
    half_turned = driven_m * twist.angular_z / max(abs(twist.linear_x), 1e-9) / 2.0
    chord_m = math.copysign(1.0, twist.linear_x) * driven_m * np.sinc(half_turned / math.pi)
    centre = np.stack([chord_m * np.cos(half_turned), chord_m * np.sin(half_turned)], axis=1)
    apart_m = np.linalg.norm(points_m[None] - centre[:, None], axis=2)
    return bool((apart_m < LIMITS.footprint_radius_m - 1e-6).any())


class WheelsMachine(RuleBasedStateMachine):
    """Every velocity ever sent is checked where it leaves."""

    @initialize()
    def begin(self) -> None:
        self.clock = ManualClock()
        self.senses = SensorReadings()
        self.sessions = Sessions(timeout_s=0.35)
        self.folder = TemporaryDirectory()
        self.latch = LatchFile(Path(self.folder.name))
        self.sent: list[tuple[float, Twist2D]] = []
        self.refused = 0
        self.hazard_seen_s: dict[Hazard, float] = {}
        self.free_m = math.inf
        self.blind = NO_ARCS
        self.live(EmergencyStop(latched=False, epoch=0))
        self.odometry()
        self.scan(3.0)
        self.wheels.tick()

    def live(self, stop: EmergencyStop) -> None:
        """A process begins."""
        self.wheels = VelocityMux(
            senses=self.senses,
            sessions=self.sessions,
            clock=self.clock,
            stop=stop,
            limits=LIMITS,
        )
        self.wheels._send = self._check
        self.nothing_is_alive()

    def nothing_is_alive(self) -> None:
        self.reverse_allowed_until_s = -math.inf
        self.last_end_s = -math.inf

    def teardown(self) -> None:
        if hasattr(self, "folder"):
            self.folder.cleanup()

    def a_lease_lives_until(self, end_s: float, *, reverse: bool) -> None:
        self.last_end_s = max(self.last_end_s, end_s)
        if reverse:
            self.reverse_allowed_until_s = max(self.reverse_allowed_until_s, end_s)

    def _check(self, twist: Twist2D) -> None:
        """The properties of a single velocity."""
        now_s, zero = self.clock.now, Twist2D()
        if self.wheels.stop_state.latched:
            assert twist == zero, "latched"
        assert abs(twist.linear_x) <= LIMITS.speed_m_s_max
        assert abs(twist.angular_z) <= LIMITS.turn_rad_s_max
        if now_s >= self.last_end_s:
            assert twist == zero, "no lease is alive"
        if twist.linear_x < 0.0:
            assert now_s < self.reverse_allowed_until_s, "reverse"
        held = {hazard for hazard, seen_s in self.hazard_seen_s.items() if now_s - seen_s <= LIMITS.hazard_hold_s}
        assert twist == zero or Hazard.WHEEL_DROP not in held
        assert twist.linear_x <= 0.0 or Hazard.BUMP not in held
        if twist.linear_x != 0.0:
            age_s = self.senses.scan.age_s(now_s)
            assert age_s is not None
            assert age_s <= LIMITS.scan_age_s_max
            assert not touches(twist, wall_scan(self.free_m).points_m), "something stands within the stop distance"
            assert not touches(twist, unseen(self.blind)), "something may stand there unseen"
        if self.sent:
            before_s, before = self.sent[-1]
            elapsed_s = min(now_s - before_s, TICK_S_MAX) + 1e-9
            gain = abs(twist.linear_x) - (abs(before.linear_x) if before.linear_x * twist.linear_x > 0 else 0.0)
            assert gain <= LIMITS.acceleration_m_s2_max * elapsed_s + 1e-9
            turn = abs(twist.angular_z) - (abs(before.angular_z) if before.angular_z * twist.angular_z > 0 else 0.0)
            assert turn <= LIMITS.turn_acceleration_rad_s2_max * elapsed_s + 1e-9
        self.sent.append((now_s, twist))

    @rule(
        x=st.floats(-0.4, 0.4),
        z=st.floats(-2.5, 2.5),
        source=st.sampled_from(["a", "b", "c"]),
        duration_s=st.sampled_from([0.1, 0.5, 2.0]),
        reverse=st.booleans(),
    )
    def ask_soundly(self, x: float, z: float, source: str, duration_s: float, reverse: bool) -> None:
        self.ask_anything(x, z, source, Priority.MANUAL, duration_s, 0, reverse, None)

    @rule(
        x=SPEED,
        z=SPEED,
        source=st.sampled_from(["a", "b", "c"]),
        priority=st.sampled_from(Priority),
        duration_s=st.floats(0.01, 2.0),
        epoch_off=st.sampled_from([0, 0, 0, -1, 1]),
        reverse=st.booleans(),
        stamp_off_s=st.one_of(st.none(), st.floats(-1.0, 1.0), ANY),
    )
    def ask_anything(
        self,
        x: float,
        z: float,
        source: str,
        priority: Priority,
        duration_s: float,
        epoch_off: int,
        reverse: bool,
        stamp_off_s: float | None,
    ) -> None:
        now_s, state = self.clock.now, self.wheels.stop_state
        stamp_s = None if stamp_off_s is None else now_s + stamp_off_s
        request = Request(source, priority, x, z, duration_s, state.epoch + epoch_off, reverse, stamp_s)
        refusal = self.wheels.request(request)
        must_refuse: list[Callable[[], bool]] = [
            lambda: state.latched,
            lambda: epoch_off != 0,
            lambda: priority in {Priority.EMERGENCY, Priority.SAFETY},
            lambda: not (math.isfinite(x) and math.isfinite(z)),
            lambda: stamp_s is not None and not (now_s - 0.5 <= stamp_s <= now_s + 0.1),
        ]
        assert refusal is not None or not any(reason() for reason in must_refuse)
        self.refused += refusal is not None
        if refusal is None:
            self.a_lease_lives_until(now_s + duration_s, reverse=reverse)

    @rule(name=st.sampled_from(["cmd_vel_nav", "rotate", "drive", "emergency_stop", "none"]))
    def ask_under_a_name_of_the_bridge(self, name: str) -> None:
        request = Request(name, Priority.NAVIGATION, 0.3, 0.0, 1.0, self.wheels.stop_state.epoch)
        assert self.wheels.request(request) is Refusal.RESERVED
        self.refused += 1

    @rule(epoch_off=st.sampled_from([0, 0, -1, 1]))
    def navigate(self, epoch_off: int) -> None:
        state = self.wheels.stop_state
        if state.latched or epoch_off or self.wheels.base_is_busy:
            with pytest.raises(ConflictError):
                self.wheels.open_navigation("goal", state.epoch + epoch_off, None)
        else:
            self.wheels.open_navigation("goal", state.epoch, None)

    @rule()
    def arrive(self) -> None:
        self.wheels.close_navigation("goal")

    @rule(x=SPEED, z=SPEED)
    def nav2_says(self, x: float, z: float) -> None:
        counted = sum(self.wheels.refused.values())
        self.wheels.navigation_velocity(x, z)
        refused = sum(self.wheels.refused.values()) - counted
        self.refused += refused
        if not refused and self.wheels._goal is not None:
            self.a_lease_lives_until(self.clock.now + 0.35, reverse=True)

    @rule(distance=st.floats(-2.0, 2.0), reverse=st.booleans(), turn=st.booleans())
    def move(self, distance: float, reverse: bool, turn: bool) -> None:
        tuning = Tuning(GAINS)
        motion = (
            Spin(distance, speed_rad_s=1.0, timeout_s=5.0, tuning=tuning)
            if turn
            else DriveOnHeading(distance, speed_m_s=0.3, timeout_s=5.0, allow_reverse=reverse, tuning=tuning)
        )
        name = "rotate" if turn else "drive"
        with contextlib.suppress(ConflictError):
            self.wheels.begin(ActiveMotion(motion, name, self.wheels.stop_state.epoch, None, lambda _: None))

    @rule(busy=st.sampled_from([True, False, False]))
    def base_drives_itself(self, busy: bool) -> None:
        self.wheels.set_base_busy(busy)

    @rule()
    def killed_and_started_again(self) -> None:
        """SIGKILL: what is on disk is all that is left."""
        before = self.wheels.stop_state
        self.live(self.latch.load(now_s=self.clock.now))
        after = self.wheels.stop_state
        assert (after.latched, after.epoch) == (before.latched, before.epoch)
        self.sent, self.refused = [], 0

    @rule(dt_s=st.one_of(st.just(0.05), st.floats(0.0, 0.5)))
    def tick(self, dt_s: float) -> None:
        self.clock.now += dt_s
        if (running := self.wheels._motions.running) is not None:  # it asks anew at every tick
            self.a_lease_lives_until(self.clock.now + 0.25, reverse=running.motion.allow_reverse)
        self.wheels.tick()
        self.refused = sum(self.wheels.refused.values()) if running is not None else self.refused

    @rule()
    def odometry(self) -> None:
        still = Odometry(0.0, Pose2D(x=0.0, y=0.0, yaw=0.0), Twist2D())
        self.senses.odometry.put(still, self.clock.now)

    @rule(distance_m=st.floats(0.0, 3.0))
    def scan(self, distance_m: float) -> None:
        self.free_m, self.blind = distance_m, NO_ARCS
        self.senses.scan.put(wall_scan(distance_m), self.clock.now)

    @rule(middle_rad=st.floats(-math.pi, math.pi), width_rad=st.floats(0.0, math.tau))
    def half_blind_scan(self, middle_rad: float, width_rad: float) -> None:
        """Nothing is near, and in one arc nothing is known."""
        self.free_m, self.blind = 3.0, np.array([[middle_rad - width_rad / 2, width_rad]])
        self.senses.scan.put(replace(wall_scan(3.0), blind=self.blind), self.clock.now)

    @rule()
    def scan_of_no_sense(self) -> None:
        self.senses.reception.refuse("scan", "its range_max is 0 m", self.clock.now)

    @rule(hazard=st.sampled_from([frozenset(), frozenset({Hazard.WHEEL_DROP}), frozenset({Hazard.BUMP})]))
    def hazard(self, hazard: frozenset[Hazard]) -> None:
        self.senses.hazards.put(hazard, self.clock.now)
        self.hazard_seen_s |= dict.fromkeys(hazard, self.clock.now)

    @rule()
    def stop(self) -> None:
        before, epoch = len(self.sent), self.wheels.stop_state.epoch
        state, _ = self.wheels.stop(reason="test", by="test")
        assert state.latched
        assert state.epoch == epoch + 1
        assert [twist for _, twist in self.sent[before:]] == [Twist2D()] * (STOP_BURST + 1)
        self.latch.store(state)
        self.nothing_is_alive()

    @precondition(lambda self: self.wheels.stop_state.latched)
    @rule()
    def reset(self) -> None:
        epoch = self.wheels.stop_state.epoch
        state = self.wheels.reset(reason="test", by="test")
        assert (state.latched, state.epoch) == (False, epoch)
        self.latch.store(state)
        self.nothing_is_alive()  # nothing asked for before may move it

    @invariant()
    def every_refusal_is_counted(self) -> None:
        assert sum(self.wheels.refused.values()) == self.refused


WheelsMachine.TestCase.settings = settings(max_examples=60, stateful_step_count=40)
TestWheels = WheelsMachine.TestCase
