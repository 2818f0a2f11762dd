"""DRIVING_1M: one step of about a metre towards a target that is too far to judge or to reach (requirement A10)."""

from contracts.causes import GoalCause
from contracts.mission import EventFacts, EventKind, MissionState
from contracts.robot import GoalStatus
from coordinator.core.activities import Driving, Navigating
from coordinator.core.approach_poses import approach_candidates, other_sides, surface_distance_m
from coordinator.core.events import Event, GoalEnded, MotionEnded
from coordinator.core.reactions import Reaction, react
from coordinator.core.search import back_to_search, set_aside
from coordinator.core.sightings import reject
from coordinator.core.states.depth_check import label_of
from coordinator.core.states.state import State
from coordinator.core.step_context import StepContext

STUCK_M, STUCK_MAX = 0.1, 2
"""What cannot be measured and cannot be come nearer to in two steps is left: from elsewhere it may be seen better."""


class Driving1m(State):
    def begin(self, context: StepContext) -> None:
        elsewhere = context.candidate.elsewhere
        candidates = (
            other_sides(context) if elsewhere else approach_candidates(context, context.rules.step_ring_radii_m)
        )
        if candidates:
            side = "on another side of it" if elsewhere else "closer to it"
            context.log_event(EventKind.NAVIGATION, f"driving to a place {side}")
            context.navigate(candidates, ring_radius_m=0.0)
        elif elsewhere:
            context.update(candidate=None, approach=None)
            back_to_search(context, "there is no other side to look at it from")
        else:
            _straight(context)

    def handle(self, context: StepContext, event: Event) -> None:
        match context.mission.activity, event:
            case Navigating(), GoalEnded(status=status) if context.candidate.elsewhere:
                context.update_candidate(elsewhere=False)
                if status is GoalStatus.SUCCEEDED:
                    context.transition_to(MissionState.CENTERING, "on another side of it: looking from here")
                else:
                    context.update(candidate=None, approach=None)
                    back_to_search(context, f"its other side cannot be reached ({event.error or status.value})")
            case Navigating(), GoalEnded(status=status, cause=cause):
                if status is GoalStatus.REJECTED or cause is GoalCause.UNREACHABLE:
                    why = f"{event.error or 'Nav2 rejected the goal'}: driving straight ahead"
                    context.log_event(EventKind.NAVIGATION, why)
                    _straight(context)
                else:
                    context.transition_to(MissionState.CENTERING, f"the step ended ({status.value}): looking from here")
            case Driving(), MotionEnded() as ended:
                _driven(context, ended)
            case _:
                pass


def _driven(context: StepContext, ended: MotionEnded) -> None:
    early = f"the step ended after {ended.driven_m:.2f} m: {ended.text or ended.end.sentence}"
    match react(context, ended):
        case Reaction.GO_ON:
            candidate = context.candidate
            stuck = not ended.end.completed and ended.driven_m < STUCK_M and candidate.map_xy is None
            context.update_candidate(stuck=candidate.stuck + stuck)
            if context.candidate.stuck >= STUCK_MAX:
                why = f"a {label_of(context)} too far away to measure, and no way nearer from there"
                reject(context, why, narrow=True)
                back_to_search(context, why)
                return
            how = "one step closer" if ended.end.completed else early
            context.transition_to(MissionState.CENTERING, how, facts=EventFacts(moved_m=round(ended.driven_m, 3)))
        case Reaction.SET_ASIDE:
            set_aside(context, early)
        case _:
            pass


def _straight(context: StepContext) -> None:
    left_m = surface_distance_m(context)
    step_m = context.rules.step_m if left_m is None else min(context.rules.step_m, left_m - 2 * context.rules.reach_m)
    if step_m < 0.1:
        context.transition_to(MissionState.CENTERING, "close enough to judge: looking again")
    else:
        context.drive(step_m)
