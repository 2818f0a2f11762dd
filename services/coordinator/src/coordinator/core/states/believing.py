"""MOVING_TO_SCAN by belief: to the view that is worth most a second, looking on the way (`coordinator.belief`)."""

from contracts.geometry import Pose2D
from contracts.mission import EndCause, EventFacts, EventKind, MissionState
from contracts.robot import CandidatePose
from coordinator.core import actions as do
from coordinator.core.activities import Navigating, PlanningCoverage, WaitingForPlace
from coordinator.core.events import CoveragePlanned, DetectionsSeen, Event, Tick
from coordinator.core.mission import Loss
from coordinator.core.outcomes import give_up
from coordinator.core.states.travelling import MovingToScan, is_here
from coordinator.core.states.weighing import revisit
from coordinator.core.step_context import StepContext
from geometry.poses import apart_m, wrap

GLANCE_M, GLANCE_RAD = 0.35, 0.3


class ByBelief(MovingToScan):
    def begin(self, context: StepContext) -> None:
        search, rules = context.search, context.rules
        if context.mission.robot.pose is None:
            _wait_for_its_place(context)
            return
        refused = tuple(one.map_xy for one in search.rejections if one.map_xy is not None)
        expected = tuple((at.x, at.y) for one in search.losses if (at := _confirmed_at(one)) is not None)
        action = do.PlanCoverage(context.call(), search.unreachable, rules.plan_timeout_s, refused, expected)
        context.request(action)
        context.set_activity(PlanningCoverage(action.call, context.now_s + action.timeout_s + rules.call_margin_s))

    def handle(self, context: StepContext, event: Event) -> None:
        match context.mission.activity, event:
            case WaitingForPlace(), Tick():
                if context.mission.robot.pose is not None:
                    self.begin(context)
            case PlanningCoverage(), CoveragePlanned(points=(), trouble=None, why=why):
                if not revisit(context):
                    _give_up(context, why)
            case PlanningCoverage(), CoveragePlanned(trouble=None):
                self._go(context, event)
            case Navigating(), DetectionsSeen(detections=seen) if seen.pose is not None:
                if _is_new(context, seen.pose):
                    context.update_search(glanced_from=seen.pose)
                    context.request(do.RecordLook(seen.pose, seen, moving=True))
                super().handle(context, event)
            case _:
                super().handle(context, event)

    def on_arrival(self, context: StepContext) -> None:
        """The looks that were chosen with the place."""
        context.update_search(points=(), sweeps=0, scan_from=context.mission.robot.pose)
        context.transition_to(MissionState.SCANNING, "there: looking where it is worth it")

    def _go(self, context: StepContext, plan: CoveragePlanned) -> None:
        goal = plan.points[0]
        context.update_search(points=(goal,), headings=plan.headings, plans=context.search.plans + 1)
        context.log_event(EventKind.NAVIGATION, plan.why, EventFacts(goal=goal))
        if is_here(context, goal):
            self.arrive(context)
        else:
            context.navigate((CandidatePose(pose=goal),))


def _give_up(context: StepContext, why: str) -> None:
    """Not everything was looked at where places were chosen that could not be reached."""
    missed = len(context.search.unreachable)
    if missed:
        places = "1 place" if missed == 1 else f"{missed} places"
        give_up(context, EndCause.NO_PLACE_LEFT, f"{why}; {places} to look from could not be reached")
    else:
        give_up(context, EndCause.ALL_LOOKED, why)


def _wait_for_its_place(context: StepContext) -> None:
    """No call failed: a robot that stays lost for `lost_pose_s` has its mission ended with that as the cause."""
    text = "the robot does not know where it is: waiting until it does"
    context.log_event(EventKind.FAILURE, text, EventFacts(service="localisation"))
    context.set_activity(WaitingForPlace(context.now_s + context.rules.lost_pose_s, "localisation"))


def _confirmed_at(loss: Loss) -> Pose2D | None:
    return loss.record.place if loss.confirmed and loss.record is not None else None


def _is_new(context: StepContext, pose: Pose2D) -> bool:
    before = context.search.glanced_from
    return before is None or apart_m(pose, before) > GLANCE_M or abs(wrap(pose.yaw - before.yaw)) > GLANCE_RAD
