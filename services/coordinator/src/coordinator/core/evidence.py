"""What all looks at one thing come to: the votes' log-odds, fused across frames and viewpoints. Pure.

A look that repeats another one says little new. Each counts by one over the sum of its correlations with all looks,
itself included: looks from one place count together as their mean, n looks from n places as n / (1 + (n - 1) r). Two
views of one thing were measured to correlate by r = 0.25 to 0.40 (`bench.calibration`). The order makes no difference.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from contracts.vision import Verdict, Vote
from geometry.poses import wrap

Place = tuple[float, float]

SAME_SIDE_RAD = 0.5
SAME_DISTANCE = 0.35
"""Of the logarithm of the distance: 1 m and 1.4 m are much the same view, 1 m and 2 m are not."""
CORRELATION = 0.4
UNMEASURED_LOG_ODDS = 1.0
"""Of a vote whose model was never calibrated."""
LOOK_LOG_ODDS_MAX = 3.0
"""What one picture can say: it cannot overturn many."""


@dataclass(frozen=True, slots=True)
class Judgement:
    """One picture that was judged: of what stands at `at`, from `seen_from`, both in map."""

    at: Place
    seen_from: Place
    log_odds: float


def said_by(votes: Sequence[Vote]) -> float:
    """What the votes on one picture say together, within bounds."""
    said = sum(_of(vote) for vote in votes)
    return min(max(said, -LOOK_LOG_ODDS_MAX), LOOK_LOG_ODDS_MAX)


def fused(looks: Sequence[Judgement]) -> float:
    """Log-odds that it is the target, 0 without a look."""
    return math.fsum(one.log_odds / math.fsum(correlation(one, other) for other in looks) for one in looks)


def correlation(one: Judgement, other: Judgement) -> float:
    """1 for the same view, `CORRELATION` for one from elsewhere."""
    side_rad = wrap(_side_rad(one) - _side_rad(other))
    nearer = math.log(max(_distance_m(one), 0.05) / max(_distance_m(other), 0.05))
    alike = math.exp(-((side_rad / SAME_SIDE_RAD) ** 2) - (nearer / SAME_DISTANCE) ** 2)
    return CORRELATION + (1.0 - CORRELATION) * alike


def of_the_same(looks: Sequence[Judgement], at: Place, within_m: float) -> tuple[Judgement, ...]:
    return tuple(look for look in looks if math.dist(look.at, at) <= within_m)


def sides_rad(looks: Sequence[Judgement]) -> tuple[float, ...]:
    """The directions from which it was judged, as seen from the thing."""
    return tuple(_side_rad(look) for look in looks)


def _side_rad(look: Judgement) -> float:
    return math.atan2(look.seen_from[1] - look.at[1], look.seen_from[0] - look.at[0])


def _distance_m(look: Judgement) -> float:
    return math.dist(look.at, look.seen_from)


def _of(vote: Vote) -> float:
    if vote.log_odds is not None or vote.verdict is Verdict.ABSTAIN:
        return vote.log_odds or 0.0
    return UNMEASURED_LOG_ODDS if vote.verdict is Verdict.YES else -UNMEASURED_LOG_ODDS
