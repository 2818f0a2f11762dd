"""Who may move the wheels: leases with a priority and an end, limits of speed and acceleration. Pure."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from pydantic import Field

from contracts.causes import LimitCause, Refusal, SafetyCause
from contracts.geometry import Twist2D
from contracts.robot import Priority
from robot_bridge.body import BodyLimits
from robot_bridge.safety.collision_monitor import Restraint

ZERO = Twist2D()
LEASES_MAX = 32
SOURCES_REMEMBERED_MAX = 256
LEASE_S_MAX = 2.0
TICK_S_MAX = 0.1


class ArbiterLimits(BodyLimits):
    """What the base can do, or is wanted to do. Slowing down is never limited here: the base brakes as it can."""

    acceleration_m_s2_max: float = Field(default=0.9, gt=0.0, le=5.0, description="of speeding up")
    turn_acceleration_rad_s2_max: float = Field(default=7.7, gt=0.0, le=50.0, description="of turning faster")
    request_age_s_max: float = Field(default=0.5, gt=0.0, description="a request stamped earlier is refused")
    request_ahead_s_max: float = Field(default=0.1, ge=0.0, description="a request stamped further ahead is refused")


@dataclass(frozen=True, slots=True)
class Request:
    """A wish to move. `stamp_s` is when it was decided, none where the source does not say."""

    source: str
    priority: Priority
    linear_x: float
    angular_z: float
    duration_s: float
    epoch: int
    allow_reverse: bool = False
    stamp_s: float | None = None
    session_id: str | None = None


@dataclass(frozen=True, slots=True)
class Lease:
    """An accepted request. Among equal priorities the source that has held its lease longest keeps the wheels."""

    request: Request
    held_since_s: float
    accepted_s: float
    expires_s: float

    def alive(self, now_s: float) -> bool:
        """False too when the clock has gone back behind its beginning: nobody knows how old it is then."""
        return self.accepted_s <= now_s < self.expires_s


@dataclass(frozen=True, slots=True)
class ArbitratedCommand:
    """The winning lease's twist within all limits; zero when there is none. `causes` tell what changed it, in order."""

    twist: Twist2D
    source: str
    wanted: Twist2D
    causes: tuple[Restraint | LimitCause, ...] = ()

    @property
    def kinds(self) -> tuple[SafetyCause | LimitCause, ...]:
        """The causes without their numbers."""
        return tuple(cause.cause if isinstance(cause, Restraint) else cause for cause in self.causes)

    @property
    def stopping(self) -> Restraint | None:
        """What keeps it from moving, where something does."""
        restraints = (cause for cause in self.causes if isinstance(cause, Restraint))
        return next((one for one in restraints if one.cause.ends_as is not None), None)


NO_COMMAND = ArbitratedCommand(ZERO, "none", ZERO)
"""Nobody wants to move."""

STOPPED = ArbitratedCommand(ZERO, "emergency_stop", ZERO)
"""The emergency stop is latched."""

Restrain = Callable[[Twist2D], tuple[Twist2D, Restraint | None]]
"""The safety filter as the arbiter sees it: a twist in, a twist no faster out, and why."""


class Arbiter:
    """Holds the leases. `choose` is asked at every tick; everything it answers is within `ArbiterLimits`.

    A more urgent source takes over at once. When a lease ends and a less urgent one would go on, a zero comes between:
    nobody's end makes the robot do something else without a pause.
    """

    def __init__(self, limits: ArbiterLimits) -> None:
        self.limits = limits
        self._leases: dict[str, Lease] = {}
        self._newest_stamp_s: dict[str, float] = {}
        self._sent = ZERO
        self._sent_s: float | None = None
        self._sent_for: Request | None = None

    def request(self, request: Request, now_s: float, *, epoch: int) -> Refusal | None:
        """Makes it a lease, replacing the source's last; or says why not. `epoch` is the emergency stop's own."""
        refusal = self._refusal(request, now_s, epoch)
        if refusal is not None:
            return refusal
        if request.stamp_s is not None:
            self._remember_stamp(request.source, request.stamp_s)
        before = self._live(request.source, now_s)
        held_since_s = before.held_since_s if before and before.request.priority == request.priority else now_s
        self._leases[request.source] = Lease(request, held_since_s, now_s, now_s + request.duration_s)
        return None

    def drop(self, source: str) -> None:
        self._leases.pop(source, None)

    def drop_session(self, session_id: str) -> None:
        for source in [s for s, lease in self._leases.items() if lease.request.session_id == session_id]:
            del self._leases[source]

    def drop_all(self) -> None:
        self._leases.clear()
        self._sent = ZERO

    def winner(self, now_s: float) -> Lease | None:
        """The lease that rules now; expired ones are gone."""
        for source in [s for s, lease in self._leases.items() if not lease.alive(now_s)]:
            del self._leases[source]
        ranked = sorted(self._leases.values(), key=lambda lease: (lease.request.priority, lease.held_since_s))
        return ranked[0] if ranked else None

    def choose(self, now_s: float, *, epoch: int, restrain: Restrain) -> ArbitratedCommand:
        """What to send now. Call once a tick: the acceleration limit counts from what was chosen last."""
        elapsed_s = 0.0 if self._sent_s is None else min(max(0.0, now_s - self._sent_s), TICK_S_MAX)
        lease = self.winner(now_s)
        if lease is None or lease.request.epoch != epoch:
            choice = NO_COMMAND
        elif self._needs_pause(lease.request):
            choice = ArbitratedCommand(ZERO, lease.request.source, _as_asked(lease.request), (LimitCause.HANDOVER,))
        else:
            choice = self._limited(lease.request, elapsed_s, restrain)
        self._sent, self._sent_s = choice.twist, now_s
        self._sent_for = lease.request if lease is not None else None
        return choice

    def record_zero(self, now_s: float) -> None:
        """Something else (the emergency stop) has sent zero: acceleration counts from there."""
        self._sent, self._sent_s = ZERO, now_s

    def _needs_pause(self, request: Request) -> bool:
        """The robot moves for another source that was as urgent, or more."""
        before = self._sent_for
        return (
            before is not None
            and self._sent != ZERO
            and before.source != request.source
            and before.priority <= request.priority
        )

    def _limited(self, request: Request, elapsed_s: float, restrain: Restrain) -> ArbitratedCommand:
        limits, causes = self.limits, list[Restraint | LimitCause]()
        linear_x = _clip(request.linear_x, limits.speed_m_s_max)
        angular_z = _clip(request.angular_z, limits.turn_rad_s_max)
        if (linear_x, angular_z) != (request.linear_x, request.angular_z):
            causes.append(LimitCause.SPEED)
        if linear_x < 0.0 and not request.allow_reverse:
            linear_x = 0.0
            causes.append(LimitCause.NO_REVERSE)
        target, safety = restrain(Twist2D(linear_x=linear_x, angular_z=angular_z))
        if safety is not None:
            causes.append(safety)
        twist = Twist2D(
            linear_x=_approach(self._sent.linear_x, target.linear_x, limits.acceleration_m_s2_max * elapsed_s),
            angular_z=_approach(
                self._sent.angular_z, target.angular_z, limits.turn_acceleration_rad_s2_max * elapsed_s
            ),
        )
        if twist != target:
            causes.append(LimitCause.ACCELERATION)
            # the two axes gather speed differently, so this is another arc: where it must not be driven, it is not
            checked, why = restrain(twist)
            if why is not None and twist.linear_x != 0.0 and checked.linear_x == 0.0:
                twist = checked
                causes.append(why)
        return ArbitratedCommand(twist, request.source, _as_asked(request), tuple(causes))

    def _refusal(self, request: Request, now_s: float, epoch: int) -> Refusal | None:
        if not all(map(math.isfinite, (request.linear_x, request.angular_z, request.stamp_s or 0.0))):
            return Refusal.NOT_FINITE
        if not 0.0 < request.duration_s <= LEASE_S_MAX:  # NaN is neither
            return Refusal.BAD_DURATION
        if request.priority in {Priority.EMERGENCY, Priority.SAFETY}:
            return Refusal.RESERVED
        if request.epoch != epoch:
            return Refusal.OLD_EPOCH
        if request.source not in self._leases and len(self._leases) >= LEASES_MAX:
            return Refusal.TOO_MANY
        return None if request.stamp_s is None else self._untimely(request.source, request.stamp_s, now_s)

    def _untimely(self, source: str, stamp_s: float, now_s: float) -> Refusal | None:
        if stamp_s > now_s + self.limits.request_ahead_s_max:
            return Refusal.FROM_THE_FUTURE
        if stamp_s < now_s - self.limits.request_age_s_max:
            return Refusal.STALE
        return Refusal.OUT_OF_ORDER if stamp_s < self._newest_stamp_s.get(source, -math.inf) else None

    def _live(self, source: str, now_s: float) -> Lease | None:
        lease = self._leases.get(source)
        return lease if lease is not None and lease.alive(now_s) else None

    def _remember_stamp(self, source: str, stamp_s: float) -> None:
        self._newest_stamp_s.pop(source, None)
        self._newest_stamp_s[source] = stamp_s
        if len(self._newest_stamp_s) > SOURCES_REMEMBERED_MAX:
            del self._newest_stamp_s[next(iter(self._newest_stamp_s))]


def _clip(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)


def _as_asked(request: Request) -> Twist2D:
    """The request's velocity, as far as a message can tell it."""
    return Twist2D(linear_x=_clip(request.linear_x, 2.0), angular_z=_clip(request.angular_z, 4.0))


def _approach(sent: float, wanted: float, step: float) -> float:
    """From `sent` towards `wanted`: speeding up by at most `step`, slowing down at once, turning round through zero."""
    if sent * wanted < 0.0:
        return 0.0
    slowest = min(abs(sent), abs(wanted))
    return math.copysign(min(abs(wanted), slowest + step), wanted) if wanted else 0.0
