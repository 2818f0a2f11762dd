"""DEPTH_CHECK by evidence: all looks at a thing count. What earned doubt is looked at from another side before it is
given up, and again when everything else has failed.
"""

from dataclasses import replace

from contracts.mission import MissionState
from coordinator.core.approach_poses import other_sides
from coordinator.core.evidence import fused, of_the_same
from coordinator.core.mission import Candidate, Rejection, Search
from coordinator.core.rules import Rules, ValidationRule
from coordinator.core.sightings import reject
from coordinator.core.states.depth_check import DepthCheck
from coordinator.core.step_context import StepContext


class WeighingDepthCheck(DepthCheck):
    def doubts(self, context: StepContext) -> bool:
        return _log_odds(context) > context.rules.doubt_log_odds

    def looks_elsewhere(self, context: StepContext, text: str) -> bool:
        """Until it was seen from there it counts as refused in doubt."""
        candidate = context.candidate
        if candidate.other_sides >= context.rules.other_sides_max or not self.doubts(context):
            return False
        if not other_sides(context):
            return False
        reject(context, text, narrow=True)
        again = replace(candidate, other_sides=candidate.other_sides + 1, elsewhere=True, rounds=0)
        context.update(candidate=again)
        context.transition_to(MissionState.DRIVING_1M, f"{text}: looking at it from another side")
        return True


def revisit(context: StepContext) -> bool:
    """True where something refused is still in doubt: it is driven to once more, the likeliest first."""
    search, rules = context.search, context.rules
    if rules.validation_rule is not ValidationRule.EVIDENCE or search.revisits >= rules.revisits_max:
        return False
    doubtful = [r for r in search.rejections if not r.revisited and _odds_of(search, rules, r) > rules.doubt_log_odds]
    if not doubtful:
        return False
    chosen = max(doubtful, key=lambda r: _odds_of(search, rules, r))
    assert chosen.sighting is not None, "what has odds was seen"
    again = tuple(replace(r, revisited=r.revisited or r.map_xy == chosen.map_xy) for r in search.rejections)
    context.update_search(rejections=again, revisits=search.revisits + 1)
    candidate = Candidate(
        chosen.sighting, seen_s=context.now_s, map_xy=chosen.map_xy, other_sides=1, elsewhere=True, revisited=True,
        log_odds=chosen.record.log_odds if chosen.record is not None else (),
    )  # fmt: skip
    context.update(candidate=candidate)
    odds = _odds_of(search, rules, chosen)
    context.transition_to(
        MissionState.DRIVING_1M, f"nothing else is left: once more to {chosen.text}, log-odds {odds:+.1f}"
    )
    return True


def _log_odds(context: StepContext) -> float:
    return context.candidate.log_odds[-1] if context.candidate.log_odds else 0.0


def _odds_of(search: Search, rules: Rules, rejection: Rejection) -> float:
    """Of what was refused; without a place or a look there is nothing to drive to."""
    looks = (
        () if rejection.map_xy is None else of_the_same(search.judgements, rejection.map_xy, rules.rejected_radius_m)
    )
    return fused(looks) if looks and rejection.sighting is not None else float("-inf")
