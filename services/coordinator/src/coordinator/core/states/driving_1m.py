"""DRIVING_1M: one step of about a metre towards a target that is too far to judge or to reach (requirement A10)."""

from contracts.geometry import Pose2D
from contracts.mission import EventFacts, EventKind, MissionState
from contracts.robot import GoalStatus
from coordinator.core.activities import ChoosingPath, Driving, Navigating
from coordinator.core.approach_poses import approach_candidates, surface_distance_m, too_near_for_a_goal
from coordinator.core.events import Event, GoalEnded, MotionEnded, PathChosen
from coordinator.core.reactions import Reaction, react
from coordinator.core.search import set_aside
from coordinator.core.states.state import State
from coordinator.core.step_context import StepContext


class Driving1m(State):
    def begin(self, context: StepContext) -> None:
        groups, costs = approach_candidates(context, context.rules.step_ring_radii_m)
        if groups:
            context.choose_path(groups, costs)
        else:
            _straight(context)

    def handle(self, context: StepContext, event: Event) -> None:
        match context.mission.activity, event:
            case ChoosingPath(poses=poses), PathChosen(index=index) if index is not None and index < len(poses):
                _step_to(context, poses[index])
            case ChoosingPath(), PathChosen(error=error):
                context.log_event(EventKind.NAVIGATION, f"no path to a closer place ({error}): driving straight ahead")
                _straight(context)
            case Navigating(goal=goal, tries=tries), GoalEnded(status=status, error_code=code):
                if status is GoalStatus.ABORTED and tries == 0:
                    context.log_event(
                        EventKind.NAVIGATION, f"Nav2 error {code}: trying again", EventFacts(error_code=code)
                    )
                    context.navigate(goal, tries=1)
                elif status is GoalStatus.REJECTED:
                    context.log_event(EventKind.NAVIGATION, "Nav2 rejected the goal: driving straight ahead")
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
            how = "one step closer" if ended.end.completed else early
            context.transition_to(MissionState.CENTERING, how, facts=EventFacts(moved_m=round(ended.driven_m, 3)))
        case Reaction.SET_ASIDE:
            set_aside(context, early)
        case _:
            pass


def _step_to(context: StepContext, pose: Pose2D) -> None:
    if too_near_for_a_goal(context, pose):
        _straight(context)
        return
    context.log_event(EventKind.NAVIGATION, "driving to a place closer to it", EventFacts(goal=pose))
    context.navigate(pose)


def _straight(context: StepContext) -> None:
    left_m = surface_distance_m(context)
    step_m = context.rules.step_m if left_m is None else min(context.rules.step_m, left_m - 2 * context.rules.reach_m)
    if step_m < 0.1:
        context.transition_to(MissionState.CENTERING, "close enough to judge: looking again")
    else:
        context.drive(step_m)
