"""The map's marks."""

import json
import math

import pytest

from contracts.geometry import Pose2D
from contracts.laser import LaserScan
from contracts.memory import ObjectState
from support.ui_world import home_map, mission, robot_state, status, thing
from ui import map_layers, map_view
from ui.latest_facts import LatestFacts, Remembered
from ui.map_layers import MapLayers

PICTURE = map_view.picture(home_map())
FRAME = PICTURE.frame


def test_the_laser_is_drawn_from_where_it_was_taken() -> None:
    taken = Pose2D(x=1.0, y=0.5, yaw=math.pi / 2)
    scan = LaserScan(stamp_s=1.0, pose=taken, points_m=((1.0, 0.0),))
    drawn = map_layers.laser(FRAME, scan, Pose2D(x=0.0, y=0.0, yaw=0.0))["points"]
    assert drawn == pytest.approx(FRAME.to_px(1.0, 1.5), abs=0.1)


def test_without_a_pose_there_is_no_laser_to_draw() -> None:
    scan = LaserScan(stamp_s=1.0, points_m=((1.0, 0.0),))
    assert map_layers.laser(FRAME, scan, None) == {"points": []}


def test_things_carry_belief_and_age_and_whether_they_are_gone() -> None:
    things = (thing(1), thing(2, "blue cup", belief=0.1, state=ObjectState.LOST))
    drawn = map_layers.remembered(FRAME, things, (), now_s=things[0].last_seen_s + 7200.0)["objects"]
    assert [(one["text"], one["belief"], one["gone"], one["hours"]) for one in drawn] == [
        ("red bottle", 0.8, False, 2.0),
        ("blue cup", 0.1, True, 2.0),
    ]


def test_a_part_that_looks_the_same_keeps_its_version() -> None:
    marks, facts = MapLayers(silence_s_max=2.0), LatestFacts()
    facts.take_robot(robot_state(), 1.0)
    facts.take_mission(status(mission()), 1.0)
    facts.remembered = Remembered(objects=(thing(1),))
    before = {name: part.version for name, part in marks.newest(PICTURE, facts, 1.0).items()}
    facts.take_mission(status(mission()), 1.5)
    facts.take_robot(robot_state(Pose2D(x=0.0, y=0.0, yaw=0.0)), 1.5)
    after = {name: part.version for name, part in marks.newest(PICTURE, facts, 1.5).items()}
    assert {name for name in after if after[name] != before[name]} == {"robot", "paths"}


def test_every_part_is_json() -> None:
    marks = MapLayers(silence_s_max=2.0)
    parts = marks.newest(PICTURE, LatestFacts(), 1.0)
    assert set(parts) == {"map", "robot", "laser", "paths", "search", "memory", "belief", "rooms"}
    assert all(json.loads(part.text) is not None for part in parts.values())
