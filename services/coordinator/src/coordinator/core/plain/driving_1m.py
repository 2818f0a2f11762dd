"""DRIVING_1M by the plain rule (requirement A10): straight ahead for as long as a metre takes."""

from contracts.geometry import Twist2D
from contracts.mission import MissionState
from coordinator.core import actions as do
from coordinator.core.activities import Steering
from coordinator.core.events import DetectionsSeen, Event, Tick
from coordinator.core.plain.approaching import follow_straight
from coordinator.core.states.state import State
from coordinator.core.step_context import StepContext


class StraightStep(State):
    def begin(self, context: StepContext) -> None:
        until_s = context.now_s + context.rules.step_m / context.rules.approach_speed_m_s
        context.set_activity(Steering(until_s=until_s, next_depth_s=until_s, moving_s=context.now_s))

    def handle(self, context: StepContext, event: Event) -> None:
        match context.mission.activity, event:
            case Steering(), Tick():
                ahead = Twist2D(linear_x=context.rules.approach_speed_m_s)
                context.request(do.SetVelocity(ahead, context.rules.lease_s))
            case Steering(), DetectionsSeen(detections=seen):
                follow_straight(context, seen)
            case _:
                pass

    def on_timeout(self, context: StepContext) -> None:
        context.stop_motion()
        context.transition_to(MissionState.CENTERING, "one step closer: looking again")
