"""The plain search (requirements A5, A6): one slow turn, looking all the while; one plan, driven to its end."""

from contracts.vision import Detections
from coordinator.core import actions as do
from coordinator.core.activities import Rotating
from coordinator.core.events import DetectionsSeen, Event, MotionEnded
from coordinator.core.reactions import Reaction, react
from coordinator.core.rules import Rules
from coordinator.core.states.scanning import Scanning, inspected
from coordinator.core.states.travelling import MovingToScan
from coordinator.core.step_context import StepContext
from geometry.poses import wrap

SWEEP_FROM_RAD = 0.35


class SlowTurn(Scanning):
    """Headings that were not in the picture during the turn are looked at one by one afterwards."""

    def look_at(self, context: StepContext, angle_rad: float) -> None:
        left_rad = context.search.headings[-1] - context.search.headings[0]
        if context.search.sweeps == 0 and left_rad > 0.0 and abs(angle_rad) <= SWEEP_FROM_RAD:
            _sweep(context, left_rad)
        else:
            super().look_at(context, angle_rad)

    def handle(self, context: StepContext, event: Event) -> None:
        match context.mission.activity, event:
            case Rotating(looking_s=float() as since_s), DetectionsSeen(detections=seen) if seen.stamp_s >= since_s:
                self._look_in_passing(context, seen)
            case Rotating(looking_s=float()), MotionEnded() as ended:
                if react(context, ended) is Reaction.GO_ON:
                    context.update_search(sweeps=context.search.sweeps + 1)
                    self.begin(context)
            case _:
                super().handle(context, event)

    def _look_in_passing(self, context: StepContext, seen: Detections) -> None:
        """Headings that the camera swept over are done."""
        sighting = inspected(context, seen)
        if sighting is not None:
            context.stop_motion()
            self.sighted(context, sighting)
            return
        yaw = seen.pose.yaw if seen.pose is not None else context.mission.robot.yaw
        near = context.rules.camera_hfov_rad * (1.0 - context.rules.scan_overlap_min) / 2
        context.update_search(headings=tuple(h for h in context.search.headings if abs(wrap(h - yaw)) > near))


class PlannedOnce(MovingToScan):
    def begin(self, context: StepContext) -> None:
        if context.search.plans == 0:
            super().begin(context)
        else:
            self.to_next_point(context)


def sweep_speed_rad_s(rules: Rules) -> float:
    """So slow that every bearing is in the picture for `scan_looks_min` looks of the detector."""
    return min(rules.scan_speed_rad_s, rules.camera_hfov_rad / (rules.scan_looks_min * rules.detector_period_s))


def _sweep(context: StepContext, angle_rad: float) -> None:
    speed_rad_s = sweep_speed_rad_s(context.rules)
    call, limit_s = context.call(), min(60.0, abs(angle_rad) / speed_rad_s * 1.3 + 5.0)
    context.request(do.Rotate(call, angle_rad, speed_rad_s, limit_s))
    until_s = context.now_s + limit_s + context.rules.call_margin_s
    context.set_activity(Rotating(call, until_s, looking_s=context.robot_now_s))
