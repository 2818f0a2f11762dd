"""What a service may not claim: a frame from the future, an arrival elsewhere, a distance no depth gives, one vote."""

from dataclasses import replace

from contracts.measuring import Measurement, NotMeasured, not_measured
from contracts.robot import GoalStatus
from contracts.vision import Validation, Verdict
from coordinator.core.activities import Navigating
from coordinator.core.events import GoalEnded
from coordinator.core.mission import Mission
from coordinator.core.rules import Rules
from geometry.poses import apart_m


def is_of_now(mission: Mission, stamp_s: float, now_s: float) -> bool:
    """A frame from the future or from long ago is a lie or a late message: it is not looked at."""
    rules, robot_now_s = mission.rules, now_s + mission.robot.offset_s
    return robot_now_s - rules.frame_age_s_max <= stamp_s <= robot_now_s + rules.frame_future_s_max


def checked_arrival(mission: Mission, event: GoalEnded) -> GoalEnded:
    """Nav2's word that it arrived counts only where the robot's own place does not say otherwise."""
    going, here = mission.activity, mission.robot.pose
    if not isinstance(going, Navigating) or here is None or event.status is not GoalStatus.SUCCEEDED:
        return event
    off_m = min(apart_m(here, each.pose) for each in going.candidates)
    if off_m <= mission.rules.arrived_m:
        return event
    return replace(event, status=GoalStatus.ABORTED, error=f"said it arrived, but stands {off_m:.1f} m from there")


def plausible(measurement: Measurement | None, rules: Rules) -> Measurement:
    """The measurement, without a distance where it claims one that depth cannot give."""
    if measurement is None:
        return not_measured(NotMeasured.NOT_ANSWERED, "no measurement came with the picture")
    distance_m = measurement.distance_m
    if distance_m is None or 0.0 < distance_m <= rules.depth_m_max:
        return measurement
    return not_measured(NotMeasured.IMPLAUSIBLE, f"{distance_m:.1f} m is no distance")


def is_confirmed(validation: Validation, rules: Rules) -> bool:
    """Two of three have to say yes (requirement A11), whatever the answer's own conclusion is."""
    yes = sum(vote.verdict is Verdict.YES for vote in validation.votes)
    return validation.confirmed and yes >= rules.yes_votes_min
