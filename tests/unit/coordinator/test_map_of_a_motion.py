"""A motion's places are of one map, told or not when it begins."""

import pytest

from contracts.mission import Outcome
from coordinator.core import events as ev
from coordinator.core.motions import PlaceLeg, PlainMotion
from support.mission_script import ORIGIN, Script


@pytest.mark.parametrize(("told", "outcome", "map_id"), [("home", None, "home"), ("office", Outcome.ABORTED, None)])
def test_a_motion_begun_before_the_robots_map_was_told_is_held_to_the_map_of_its_places(
    told: str, outcome: Outcome | None, map_id: str | None
) -> None:
    place = PlaceLeg(4.0, 0.0, None, "the kitchen")
    script = Script().robot(ORIGIN).feed(ev.MotionStarted("m1", "go", PlainMotion("there", (place,), map_id="home")))
    assert script.mission.map_id is None
    now = ev.RobotUpdated(
        stamp_s=script.now_s, pose=ORIGIN, odometry=ORIGIN, docked=False, speed_m_s=0.0, stopped=False, epoch=0,
        map_id=told,
    )  # fmt: skip
    script.feed(now)
    assert (script.mission.outcome, script.mission.map_id) == (outcome, map_id)
