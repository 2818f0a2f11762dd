"""DRIVING_1M: one step of about a metre towards a target that is too far to judge or to reach (requirement A10)."""

from contracts.geometry import Pose2D, Twist2D
from contracts.mission import EventKind, MissionState
from contracts.robot import GoalStatus
from coordinator.core import actions as do
from coordinator.core.activities import ChoosingPath, Driving, Going, Steering
from coordinator.core.approach_poses import ring_groups, surface_distance_m, too_near_for_a_goal
from coordinator.core.centering import set_aside
from coordinator.core.events import DetectionsSeen, Event, GoalEnded, MotionEnded, PathChosen, Tick
from coordinator.core.reactions import Reaction, react
from coordinator.core.rules import ApproachRule
from coordinator.core.sightings import follow, tracked
from coordinator.core.step_context import Draft


def begin(draft: Draft) -> None:
    if draft.rules.approach_rule is ApproachRule.SEEDS:
        seconds = draft.rules.step_m / draft.rules.approach_speed_m_s
        draft.be(Steering(until_s=draft.now_s + seconds, next_depth_s=draft.now_s + seconds, moving_s=draft.now_s))
        return
    groups, costs = ring_groups(draft, draft.rules.step_ring_radii_m)
    if groups:
        draft.choose_path(groups, costs)
    else:
        _straight(draft)


def handle(draft: Draft, event: Event) -> None:
    match draft.mission.activity, event:
        case ChoosingPath(poses=poses), PathChosen(index=index) if index is not None and index < len(poses):
            _step_to(draft, poses[index])
        case ChoosingPath(), PathChosen(error=error):
            draft.say(EventKind.NAVIGATION, f"no path to a nearer place ({error}): straight on")
            _straight(draft)
        case Going(goal=goal, tries=tries), GoalEnded(status=status, error_code=code):
            if status is GoalStatus.ABORTED and tries == 0:
                draft.say(EventKind.NAVIGATION, f"aborted with error {code}: once more from here", error_code=code)
                draft.navigate(goal, tries=1)
            elif status is GoalStatus.REJECTED:
                draft.say(EventKind.NAVIGATION, "the goal was rejected: straight on")
                _straight(draft)
            else:
                draft.go(MissionState.CENTERING, f"the step ended ({status.value}): looking from here")
        case Driving(), MotionEnded() as ended:
            _driven(draft, ended)
        case Steering(), Tick():
            speed = draft.rules.approach_speed_m_s
            draft.act(do.SetVelocity(Twist2D(linear_x=speed), draft.rules.lease_s))
        case Steering(), DetectionsSeen(detections=seen):
            sighting = tracked(draft.mission, draft.candidate, seen)
            if sighting is None:
                return
            follow(draft, sighting)
            if abs(sighting.error_px) > draft.rules.drift_px:
                draft.stop_motion()
                draft.go(MissionState.CENTERING, "it drifted from the middle: centring again")
        case _:
            pass


def _driven(draft: Draft, ended: MotionEnded) -> None:
    early = f"the step ended after {ended.driven_m:.2f} m: {ended.text or ended.end.sentence}"
    match react(draft, ended):
        case Reaction.GO_ON:
            how = "one step nearer" if ended.end.completed else early
            draft.go(MissionState.CENTERING, how, moved_m=round(ended.driven_m, 3))
        case Reaction.SET_ASIDE:
            set_aside(draft, early)
        case _:
            pass


def on_steering_end(draft: Draft) -> None:
    draft.stop_motion()
    draft.go(MissionState.CENTERING, "one step nearer: looking again")


def _step_to(draft: Draft, pose: Pose2D) -> None:
    if too_near_for_a_goal(draft, pose):
        _straight(draft)
        return
    draft.say(EventKind.NAVIGATION, "to a place nearer to it", goal=pose.model_dump())
    draft.navigate(pose)


def _straight(draft: Draft) -> None:
    left_m = surface_distance_m(draft)
    step_m = draft.rules.step_m if left_m is None else min(draft.rules.step_m, left_m - 2 * draft.rules.reach_m)
    if step_m < 0.1:
        draft.go(MissionState.CENTERING, "near enough to judge: looking again")
    else:
        draft.drive(step_m)
