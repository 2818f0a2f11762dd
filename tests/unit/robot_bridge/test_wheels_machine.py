"""Random requests, clocks, scans, hazards and stops against the arbiter, the filter and the stop together."""

import math
from collections.abc import Callable

import numpy as np
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from contracts.geometry import Pose2D, Twist2D
from contracts.robot import EmergencyStop, Priority
from robot_bridge.arbiter import Limits, Request
from robot_bridge.safety import SafetyLimits
from robot_bridge.senses import Hazard, Odometry, Scan, Senses
from robot_bridge.sessions import Sessions
from robot_bridge.wheels import STOP_BURST, Wheels

LIMITS, SAFETY = Limits(), SafetyLimits()
ANY = st.floats(allow_nan=True, allow_infinity=True)
SPEED = st.one_of(st.floats(-3.0, 3.0), ANY)
HOLD_S = 1.0


class ManualClock:
    now = 1000.0

    def now_s(self) -> float:
        return self.now

    async def sleep(self, seconds: float) -> None:
        self.now += seconds


def wall_scan(distance_m: float) -> Scan:
    """A wall ahead and one behind, this far from the footprint."""
    y = np.linspace(-2.0, 2.0, 81)
    x = np.full_like(y, distance_m + SAFETY.footprint_radius_m)
    return Scan(0.0, np.concatenate([np.stack([x, y], 1), np.stack([-x, y], 1)]))


class WheelsMachine(RuleBasedStateMachine):
    """Every velocity ever sent is checked where it leaves."""

    @initialize()
    def begin(self) -> None:
        self.clock = ManualClock()
        self.senses = Senses()
        self.sessions = Sessions(timeout_s=0.35)
        self.wheels = Wheels(
            senses=self.senses,
            sessions=self.sessions,
            clock=self.clock,
            stop=EmergencyStop(latched=False, epoch=0),
            limits=LIMITS,
            safety=SAFETY,
            hazard_hold_s=HOLD_S,
        )
        self.sent: list[tuple[float, Twist2D]] = []
        self.reverse_allowed_until_s = -math.inf
        self.last_end_s = -math.inf
        self.reset_at = 0
        self.wheels._send = self._check
        self.free_m = math.inf
        self.odometry()
        self.scan(3.0)
        self.wheels.tick()

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
        hazards = self.senses.hazards.newest
        if hazards is not None and now_s - hazards.received_s <= HOLD_S:
            assert twist == zero or Hazard.WHEEL_DROP not in hazards.value
            assert twist.linear_x <= 0.0 or Hazard.BUMP not in hazards.value
        if twist.linear_x != 0.0:
            age_s = self.senses.scan.age_s(now_s)
            assert age_s is not None
            assert age_s <= SAFETY.scan_age_s_max
            assert self.free_m > SAFETY.stop_distance_m, "translation inside the stop distance"
        if self.sent:
            before_s, before = self.sent[-1]
            elapsed_s = min(now_s - before_s, LIMITS.tick_s_max) + 1e-9
            gain = abs(twist.linear_x) - (abs(before.linear_x) if before.linear_x * twist.linear_x > 0 else 0.0)
            assert gain <= LIMITS.acceleration_m_s2_max * elapsed_s + 1e-9
            turn = abs(twist.angular_z) - (abs(before.angular_z) if before.angular_z * twist.angular_z > 0 else 0.0)
            assert turn <= LIMITS.turn_acceleration_rad_s2_max * elapsed_s + 1e-9
        self.sent.append((now_s, twist))

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
    def ask(
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
        accepted = refusal is None
        self.last_end_s = max(self.last_end_s, now_s + duration_s) if accepted else self.last_end_s
        if accepted and reverse:
            self.reverse_allowed_until_s = max(self.reverse_allowed_until_s, now_s + duration_s)

    @rule(dt_s=st.one_of(st.just(0.05), st.floats(0.0, 0.5)))
    def tick(self, dt_s: float) -> None:
        self.clock.now += dt_s
        self.wheels.tick()

    @rule()
    def odometry(self) -> None:
        still = Odometry(0.0, Pose2D(x=0.0, y=0.0, yaw=0.0), Twist2D())
        self.senses.odometry.put(still, self.clock.now)

    @rule(distance_m=st.floats(0.0, 3.0))
    def scan(self, distance_m: float) -> None:
        self.free_m = distance_m
        self.senses.scan.put(wall_scan(distance_m), self.clock.now)

    @rule(hazard=st.sampled_from([frozenset(), frozenset({Hazard.WHEEL_DROP}), frozenset({Hazard.BUMP})]))
    def hazard(self, hazard: frozenset[Hazard]) -> None:
        self.senses.hazards.put(hazard, self.clock.now)

    @rule()
    def stop(self) -> None:
        before, epoch = len(self.sent), self.wheels.stop_state.epoch
        state, _ = self.wheels.stop(reason="test", by="test")
        assert state.latched
        assert state.epoch == epoch + 1
        assert [twist for _, twist in self.sent[before:]] == [Twist2D()] * STOP_BURST

    @precondition(lambda self: self.wheels.stop_state.latched)
    @rule()
    def reset(self) -> None:
        epoch = self.wheels.stop_state.epoch
        assert self.wheels.reset(reason="test", by="test").epoch == epoch
        self.last_end_s = -math.inf  # nothing asked for before may move it
        self.reverse_allowed_until_s = -math.inf

    @invariant()
    def every_refusal_is_counted(self) -> None:
        assert all(count >= 0 for count in self.wheels.arbiter.refused.values())


WheelsMachine.TestCase.settings = settings(max_examples=60, stateful_step_count=40, deadline=None)
TestWheels = WheelsMachine.TestCase
