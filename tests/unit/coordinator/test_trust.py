"""What no service may claim."""

from dataclasses import replace

import pytest

from contracts.geometry import Point3D, Pose2D
from contracts.measuring import Measurement
from contracts.robot import CandidatePose, GoalStatus
from contracts.vision import Validation, Verdict, Vote
from coordinator.core.activities import Navigating
from coordinator.core.events import GoalEnded
from coordinator.core.mission import Mission, RobotSnapshot
from coordinator.core.plausibility import checked_arrival, is_confirmed, is_of_now, plausible
from support.mission_script import rules_of

HERE = Pose2D(x=0.0, y=0.0, yaw=0.0)
RULES = rules_of()


@pytest.mark.parametrize(("stamp_s", "believed"), [(1000.0, True), (996.0, True), (990.0, False), (1003.0, False)])
def test_a_frame_is_believed_around_now_on_the_robots_own_clock(stamp_s: float, believed: bool) -> None:
    mission = Mission(rules=RULES, robot=RobotSnapshot(offset_s=900.0))
    assert is_of_now(mission, stamp_s, now_s=100.0) is believed


@pytest.mark.parametrize(("away_m", "status"), [(0.4, GoalStatus.SUCCEEDED), (2.0, GoalStatus.ABORTED)])
def test_an_arrival_counts_where_the_robot_stands_there(away_m: float, status: GoalStatus) -> None:
    going = Navigating(1, 10.0, (CandidatePose(pose=Pose2D(x=away_m, y=0.0, yaw=0.0)),))
    mission = Mission(rules=RULES, robot=RobotSnapshot(pose=HERE), activity=going)
    assert checked_arrival(mission, GoalEnded(1, GoalStatus.SUCCEEDED)).status is status
    lost = replace(mission, robot=RobotSnapshot(pose=None))
    assert checked_arrival(lost, GoalEnded(1, GoalStatus.SUCCEEDED)).status is GoalStatus.SUCCEEDED


@pytest.mark.parametrize(("distance_m", "kept"), [(0.3, 0.3), (7.9, 7.9), (0.0, None), (-1.0, None), (60.0, None)])
def test_a_distance_that_depth_cannot_give_is_no_measurement(distance_m: float, kept: float | None) -> None:
    point = Point3D(x=1.0, y=0.0, z=0.1)
    reply = Measurement(distance_m=distance_m, bearing_rad=0.1, map_point=point)
    told = plausible(reply, RULES)
    assert told.distance_m == kept
    assert (told.map_point is None) == (kept is None)


@pytest.mark.parametrize(
    ("claimed", "verdicts", "believed"),
    [
        (True, "yyn", True),
        (True, "yya", True),
        (True, "yna", False),
        (True, "yaa", False),
        (True, "", False),
        (False, "yyy", False),
    ],
)
def test_a_confirmation_needs_two_votes_whatever_it_says_of_itself(
    claimed: bool, verdicts: str, believed: bool
) -> None:
    words = {"y": Verdict.YES, "n": Verdict.NO, "a": Verdict.ABSTAIN}
    votes = tuple(Vote(voter="clip", verdict=words[one]) for one in verdicts)
    validation = Validation(confirmed=claimed, votes=votes, stamp_s=1.0, image_width_px=320, image_height_px=240)
    assert is_confirmed(validation, RULES) is believed
