"""How sure memory is that a thing is still in its place (pure).

Belief is a probability. A sighting and a miss change it by Bayes' rule; age wears it down, by class, towards a fifth of
what it was: a thing not seen for long is doubtful, but only looking in its place and not seeing it makes it lost.
"""

from contracts.memory import ObjectState

BELIEF_MAX = 0.95
BELIEF_MIN = 0.001
AGED_SHARE = 0.2
"""What age alone leaves: the place where a cup was last month is still a better guess than any other."""
LOST_BELOW = 0.15
DOUBTFUL_BELOW = 0.5
FIRST = 0.5
"""Before the first sighting."""
PLACE_LOSS_MIN = 1.0 / 20.0
"""Looking again and again from one place proves no more than this factor of the odds: the same thing may hide it there,
or the detector may be blind to it from there. So it takes two places to lose what was surely there."""
DETECTED = ((1.2, 0.8), (1.8, 0.55), (2.5, 0.1), (2.8, 0.0))
"""(distance in m, chance that a detector sees a cup), straight lines between; measured on the simulator's weights, and
lowered because neighbouring frames are alike."""
SURE_CONFIDENCE = 0.6
"""What was never seen better than at half of this is expected to be detected half as often."""


def aged(belief: float, age_s: float, half_life_s: float) -> float:
    """`belief`, stated `age_s` ago. A clock that went back counts as no time."""
    return belief * (AGED_SHARE + (1.0 - AGED_SHARE) * 0.5 ** (max(0.0, age_s) / half_life_s))


def after_sighting(belief: float, confidence: float) -> float:
    """A detection of confidence 0.3 is 2.8 times as likely where there is such a thing as where there is none; at 0.9,
    17 times."""
    return _limited(_odds(belief) * (1.0 + 20.0 * confidence**2))


def after_miss(belief: float, detectability: float, place_loss: float = 1.0) -> tuple[float, float]:
    """The belief after a look in which it should have been seen with the chance `detectability`, and the new product of
    what looks from this place took (`PLACE_LOSS_MIN` at the least)."""
    loss = max(1.0 - detectability, PLACE_LOSS_MIN / place_loss)
    return _limited(_odds(belief) * loss), place_loss * loss


def detectability(distance_m: float, reach: float, confidence: float) -> float:
    """The chance that one look from there shows it, 0 to 1."""
    near = distance_m / reach
    last_m, last_p = 0.0, DETECTED[0][1]
    chance = 0.0
    for at_m, p in DETECTED:
        if near <= at_m:
            chance = last_p + (p - last_p) * (near - last_m) / (at_m - last_m)
            break
        last_m, last_p = at_m, p
    return chance * min(1.0, confidence / SURE_CONFIDENCE)


def state_of(stated: float, now: float, *, moved: bool) -> ObjectState:
    """`stated` is the belief at the last evidence, `now` the same aged until now."""
    if stated < LOST_BELOW:
        return ObjectState.MOVED if moved else ObjectState.LOST
    return ObjectState.PRESENT if now >= DOUBTFUL_BELOW else ObjectState.DOUBTFUL


def _odds(belief: float) -> float:
    return belief / (1.0 - belief)


def _limited(odds: float) -> float:
    return min(BELIEF_MAX, max(BELIEF_MIN, odds / (1.0 + odds)))
