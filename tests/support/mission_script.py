"""Plays events into the coordinator's core and keeps what it asked for."""

import math
from typing import TypeVar

from contracts.causes import GoalCause
from contracts.colours import Colour
from contracts.geometry import Point3D, Pose2D
from contracts.measuring import Measurement
from contracts.mission import MissionState
from contracts.motion import MotionEnd
from contracts.robot import GoalStatus
from contracts.vision import Detection, Detections, Target, Validation, Verdict, Vote
from coordinator.core import actions as do
from coordinator.core import events as ev
from coordinator.core.mission import Mission, SearchPose
from coordinator.core.rules import Policy, Rules
from coordinator.core.step import step

A = TypeVar("A", bound=do.Action)

ORIGIN = Pose2D(x=0.0, y=0.0, yaw=0.0)
TARGET = Target(label="bottle", description="red bottle")


STEP_BY_STEP: dict[str, object] = {
    "coverage_rule": "viewpoints", "approach_rule": "localized", "validation_rule": "two_of_three",
    "approach_speed_m_s": 0.15,
}  # fmt: skip
"""Drive, stop, look, vote: each on its own. As delivered it does more than one of these at once."""
AS_DELIVERED: dict[str, object] = {name: Policy.model_fields[name].default for name in STEP_BY_STEP}


def rules_of(**changes: object) -> Rules:
    """For the robot most tests are about, step by step: a test of what is done at once names the rule."""
    return Rules.model_validate(STEP_BY_STEP | {"camera_hfov_rad": 0.942, "camera_forward_m": 0.06} | changes)


class Script:
    """One mission; `now_s` moves only when told to."""

    def __init__(self, **rules: object) -> None:
        self.mission = Mission(rules=rules_of(**rules))
        self.now_s = 100.0
        self.actions: list[do.Action] = []
        self.states: list[MissionState] = []
        self.fed: list[ev.Event] = []
        self.robot()

    def feed(self, event: ev.Event) -> "Script":
        self.fed.append(event)
        self.mission, actions = step(self.mission, event, self.now_s)
        self.actions += actions
        if not self.states or self.states[-1] is not self.mission.state:
            self.states.append(self.mission.state)
        return self

    def robot(self, pose: Pose2D | None = ORIGIN, *, stopped: bool = False, epoch: int = 0, docked: bool = False,
              speed_m_s: float = 0.0, reason: str = "") -> "Script":  # fmt: skip
        return self.feed(
            ev.RobotUpdated(
                stamp_s=self.now_s,
                pose=pose,
                odometry=pose,
                docked=docked,
                speed_m_s=speed_m_s,
                stopped=stopped,
                epoch=epoch,
                stop_reason=reason,
            )
        )

    def begin(self, *views: Pose2D) -> "Script":
        places = tuple(SearchPose(view, "seen before") for view in views)
        return self.feed(ev.MissionStarted("m1", "find the red bottle", TARGET, "rules", places))

    def wait(self, seconds: float) -> "Script":
        """Ticks at 10 Hz; the robot keeps saying where it is."""
        for _ in range(round(seconds * 10)):
            self.now_s += 0.1
            self.robot(self.mission.robot.pose, epoch=self.mission.robot.epoch, speed_m_s=self.mission.robot.speed_m_s)
            self.feed(ev.Tick())
        return self

    def asked(self, kind: type[A]) -> list[A]:
        return [action for action in self.actions if isinstance(action, kind)]

    def last(self, kind: type[A]) -> A:
        found = self.asked(kind)
        assert found, f"no {kind.__name__} was asked for"
        return found[-1]

    def said(self) -> str:
        return "\n".join(action.text for action in self.asked(do.Say))

    # answers to the last call of a kind

    def turned(self, end: MotionEnd = MotionEnd.COMPLETED) -> "Script":
        action = self.last(do.Rotate)
        pose = self.mission.robot.pose
        if end.completed and pose is not None:
            self.robot(Pose2D(x=pose.x, y=pose.y, yaw=math.remainder(pose.yaw + action.angle_rad, math.tau)))
        turned_rad = action.angle_rad if end.completed else 0.0
        return self.feed(ev.MotionEnded(action.call, end, turned_rad=turned_rad, text=end.sentence))

    def arrived(self, status: GoalStatus = GoalStatus.SUCCEEDED, code: int = 0, *, at: int = 0) -> "Script":
        action = self.last(do.Navigate)
        if status is GoalStatus.SUCCEEDED:
            self.robot(action.candidates[at].pose)
        return self.feed(ev.GoalEnded(action.call, status, code))

    def unreachable(self) -> "Script":
        cause = GoalCause.UNREACHABLE
        return self.feed(ev.GoalEnded(self.last(do.Navigate).call, GoalStatus.ABORTED, 208, cause.sentence, cause))

    def planned(self, *points: Pose2D) -> "Script":
        return self.feed(ev.CoveragePlanned(self.last(do.PlanCoverage).call, points, 20.0))

    def drove(self, end: MotionEnd = MotionEnd.COMPLETED, *, moved: float | None = None) -> "Script":
        action = self.last(do.Drive)
        distance = action.distance_m if moved is None else moved
        pose = self.mission.robot.pose
        if pose is not None:
            x, y = pose.x + distance * math.cos(pose.yaw), pose.y + distance * math.sin(pose.yaw)
            self.robot(Pose2D(x=x, y=y, yaw=pose.yaw))
        return self.feed(ev.MotionEnded(action.call, end, driven_m=distance, text=end.sentence))

    def see(self, *boxes: Detection) -> "Script":
        """A frame taken a little after now."""
        self.now_s += 0.3
        return self.feed(
            ev.DetectionsSeen(
                Detections(
                    stamp_s=self.now_s,
                    image_width_px=320,
                    image_height_px=240,
                    pose=self.mission.robot.pose,
                    detections=boxes,
                )
            )
        )

    def see_at(
        self, distance_m: float, x: float, y: float = 0.0, *beside: Detection, colour: str | None = "red"
    ) -> "Script":
        """A frame with the bottle in its middle, measured: it lies at (x, y) in map."""
        point = Point3D(x=x, y=y, z=0.1)
        pose = self.mission.robot.pose or ORIGIN
        dx, dy = x - pose.x, y - pose.y
        cos, sin = math.cos(-pose.yaw), math.sin(-pose.yaw)
        base = Point3D(x=cos * dx - sin * dy, y=sin * dx + cos * dy, z=0.1)
        sigma_m = 0.012 * distance_m**3.461
        measured = Measurement(
            distance_m=distance_m, sigma_m=sigma_m, bearing_rad=0.0, base_point=base, map_point=point
        )
        return self.see(box(colour=colour).model_copy(update={"measurement": measured}), *beside)

    def voted(
        self, clip: Verdict, score: float = 0.1, *, detector: Verdict = Verdict.YES, log_odds: float | None = None
    ) -> "Script":
        votes = (
            Vote(voter="detector", verdict=detector, score=0.8 if detector is Verdict.YES else None, threshold=0.3),
            Vote(voter="clip", verdict=clip, score=score, threshold=0.4, log_odds=log_odds),
        )
        validation = Validation(
            confirmed=clip is Verdict.YES, votes=votes, stamp_s=self.now_s, image_width_px=320, image_height_px=240
        )
        return self.feed(ev.Validated(self.last(do.Validate).call, validation))

    # whole stretches

    def centred(self) -> "Script":
        """From a running mission that looks, to DEPTH_CHECK, with a red bottle straight ahead, not measured yet."""
        self.see(box())
        for _ in range(3):
            self.see(box())
        return self

    def measured(self, distance_m: float, samples: int = 1) -> "Script":
        """`samples` pictures in which a thing straight ahead is measured."""
        pose = self.mission.robot.pose or ORIGIN
        reach = distance_m + 0.06
        x, y = pose.x + reach * math.cos(pose.yaw), pose.y + reach * math.sin(pose.yaw)
        for _ in range(samples):
            self.see_at(distance_m, x, y)
        return self


def box(
    u_px: float = 160.0, *, label: str = "bottle", colour: str | None = "red", confidence: float = 0.8
) -> Detection:
    known = Colour(colour) if colour else None
    return Detection(label=label, confidence=confidence, bbox_xyxy=(u_px - 8, 100, u_px + 8, 150), colour=known)
