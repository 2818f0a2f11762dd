"""Random requests, priorities, clocks (backwards too) and filters against the arbiter, beside a model of its leases."""

import math
from dataclasses import dataclass

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from contracts.causes import SafetyCause
from contracts.geometry import Twist2D
from contracts.robot import Priority
from robot_bridge.motion.arbiter import Arbiter, ArbiterLimits, Request
from robot_bridge.safety.collision_monitor import Restraint

LIMITS = ArbiterLimits()
ZERO = Twist2D()
ORDINARY = (Priority.NAVIGATION, Priority.EXPLORATION, Priority.MANUAL)
SOURCES = st.sampled_from(["a", "b", "c", "d"])
SPEED = st.one_of(st.floats(-3.0, 3.0), st.floats())


@dataclass
class Modelled:
    """What the arbiter should know of a lease."""

    request: Request
    held_since_s: float
    accepted_s: float


class ArbiterMachine(RuleBasedStateMachine):
    @initialize()
    def begin(self) -> None:
        self.arbiter = Arbiter(LIMITS)
        self.now_s = 1000.0
        self.epoch = 3
        self.leases: dict[str, Modelled] = {}
        self.newest_stamp_s: dict[str, float] = {}
        self.sent, self.sent_s, self.sent_by = ZERO, None, None
        self.factor = 1.0

    def forget_the_dead(self) -> None:
        self.leases = {
            source: lease
            for source, lease in self.leases.items()
            if lease.accepted_s <= self.now_s < lease.accepted_s + lease.request.duration_s
        }

    @rule(
        source=SOURCES,
        x=st.floats(-0.4, 0.4),
        z=st.floats(-2.5, 2.5),
        priority=st.sampled_from(ORDINARY),
        duration_s=st.sampled_from([0.1, 0.3, 2.0]),
        reverse=st.booleans(),
        session=st.sampled_from([None, "s1", "s2"]),
    )
    def ask_soundly(
        self,
        source: str,
        x: float,
        z: float,
        priority: Priority,
        duration_s: float,
        reverse: bool,
        session: str | None,
    ) -> None:
        self.ask_anything(source, x, z, priority, duration_s, 0, None, reverse, session)

    @rule(
        source=SOURCES,
        x=SPEED,
        z=SPEED,
        priority=st.sampled_from(Priority),
        duration_s=st.one_of(st.floats(0.01, 2.0), st.floats()),
        epoch_off=st.sampled_from([0, 0, 0, 0, -1, 1]),
        stamp_off_s=st.one_of(st.none(), st.floats(-0.7, 0.3), st.floats()),
        reverse=st.booleans(),
        session=st.sampled_from([None, "s1", "s2"]),
    )
    def ask_anything(
        self,
        source: str,
        x: float,
        z: float,
        priority: Priority,
        duration_s: float,
        epoch_off: int,
        stamp_off_s: float | None,
        reverse: bool,
        session: str | None,
    ) -> None:
        stamp_s = None if stamp_off_s is None else self.now_s + stamp_off_s
        request = Request(source, priority, x, z, duration_s, self.epoch + epoch_off, reverse, stamp_s, session)
        refusal = self.arbiter.request(request, self.now_s, epoch=self.epoch)
        sound = (
            math.isfinite(x)
            and math.isfinite(z)
            and 0.0 < duration_s <= 2.0
            and epoch_off == 0
            and priority not in {Priority.EMERGENCY, Priority.SAFETY}
            and (stamp_s is None or self.now_s - 0.5 <= stamp_s <= self.now_s + 0.1)
            and (stamp_s is None or stamp_s >= self.newest_stamp_s.get(source, -math.inf))
        )
        assert (refusal is None) == sound
        if sound:
            before = self.leases.get(source)
            alive = (
                before is not None and before.accepted_s <= self.now_s < before.accepted_s + before.request.duration_s
            )
            keeps = before is not None and alive and before.request.priority == priority
            self.leases[source] = Modelled(request, before.held_since_s if keeps else self.now_s, self.now_s)
            if stamp_s is not None:
                self.newest_stamp_s[source] = stamp_s

    @rule(source=SOURCES)
    def drop(self, source: str) -> None:
        self.arbiter.drop(source)
        self.leases.pop(source, None)

    @rule(session=st.sampled_from(["s1", "s2"]))
    def drop_session(self, session: str) -> None:
        self.arbiter.drop_session(session)
        self.leases = {s: lease for s, lease in self.leases.items() if lease.request.session_id != session}

    @rule()
    def stop(self) -> None:
        """As an emergency stop and its reset do it."""
        self.epoch += 1
        self.arbiter.drop_all()
        self.arbiter.record_zero(self.now_s)
        self.leases = {}
        self.sent, self.sent_s = ZERO, self.now_s

    @rule(factor=st.sampled_from([1.0, 1.0, 0.5, 0.3, 0.0]))
    def surroundings_change(self, factor: float) -> None:
        self.factor = factor

    @rule(dt_s=st.one_of(st.just(0.05), st.floats(0.0, 0.6), st.floats(-3.0, 0.0)))
    def tick(self, dt_s: float) -> None:
        self.now_s += dt_s
        ruling = self.ruling()
        choice = self.arbiter.choose(self.now_s, epoch=self.epoch, restrain=self.restrain)
        assert choice.source == (ruling.source if ruling is not None else "none")
        if ruling is None:
            assert choice.twist == ZERO, "no lease is alive"
        else:
            self.check(choice.twist, ruling)
        self.sent, self.sent_s, self.sent_by = choice.twist, self.now_s, ruling

    def ruling(self) -> Request | None:
        """The model's winner."""
        self.forget_the_dead()
        ranked = sorted(self.leases.values(), key=lambda lease: (lease.request.priority, lease.held_since_s))
        return ranked[0].request if ranked else None

    @invariant()
    def the_right_lease_rules(self) -> None:
        lease = self.arbiter.winner(self.now_s)
        assert (lease.request if lease is not None else None) is self.ruling()

    def check(self, twist: Twist2D, request: Request) -> None:
        before, by = self.sent, self.sent_by
        if by is not None and by.source != request.source and before != ZERO and by.priority <= request.priority:
            assert twist == ZERO, "no pause between two sources"
        for now, then, limit, gain_max in (
            (twist.linear_x, before.linear_x, min(LIMITS.speed_m_s_max, abs(request.linear_x)), 0.9),
            (twist.angular_z, before.angular_z, min(LIMITS.turn_rad_s_max, abs(request.angular_z)), 7.7),
        ):
            assert abs(now) <= limit * self.factor + 1e-12, "faster than asked, allowed or safe"
            assert now * then >= 0.0, "turned round without a zero"
            elapsed_s = 0.0 if self.sent_s is None else min(max(self.now_s - self.sent_s, 0.0), 0.1)
            assert abs(now) - abs(then) <= gain_max * elapsed_s + 1e-12, "gathered speed too fast"
        assert twist.linear_x >= 0.0 or request.allow_reverse
        assert twist.linear_x * request.linear_x >= 0.0
        assert twist.angular_z * request.angular_z >= 0.0

    def restrain(self, twist: Twist2D) -> tuple[Twist2D, Restraint | None]:
        slowed = Twist2D(linear_x=twist.linear_x * self.factor, angular_z=twist.angular_z * self.factor)
        return slowed, None if self.factor == 1.0 else Restraint(SafetyCause.SLOWED)


ArbiterMachine.TestCase.settings = settings(max_examples=80, stateful_step_count=40)
TestArbiter = ArbiterMachine.TestCase
