"""Poses round a wanted one."""

import itertools
import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from contracts.geometry import Point3D, Pose2D
from robot_bridge.navigation.candidate_poses import ClearanceMap, by_clearance, candidate_poses, length_m
from robot_bridge.navigation.maps import clearance_map
from robot_bridge.sensing.sensor_readings import Grid

ORIGIN = Pose2D(x=-1.0, y=-1.0, yaw=0.0)


def room() -> ClearanceMap:
    """6 x 6 m from (-1, -1), a wall round it, and a block of 1 m in its middle."""
    cells = np.zeros((120, 120), np.int8)
    cells[0, :] = cells[-1, :] = cells[:, 0] = cells[:, -1] = 100
    cells[50:70, 50:70] = 100
    cells[100:, 100:] = -1
    return clearance_map(Grid(cells, 0.05, ORIGIN))


ROOM = room()
wanted = st.builds(Pose2D, x=st.floats(-1.0, 5.0), y=st.floats(-1.0, 5.0), yaw=st.floats(-3.1, 3.1))


def test_clearance_is_the_way_to_the_nearest_cell_that_is_not_free() -> None:
    assert ROOM.at(Pose2D(x=0.5, y=2.0, yaw=0.0)) == np.float32(1.0) - np.float32(0.025)
    assert ROOM.at(Pose2D(x=2.0, y=2.0, yaw=0.0)) == 0.0
    assert ROOM.at(Pose2D(x=4.5, y=4.5, yaw=0.0)) == 0.0  # unknown is not free
    assert ROOM.at(Pose2D(x=50.0, y=0.0, yaw=0.0)) == 0.0


@given(wanted, st.floats(0.2, 2.0), st.floats(0.1, 0.5))
def test_every_pose_is_clear_and_within_the_radius_and_the_nearest_come_first(
    pose: Pose2D, radius_m: float, clearance_m: float
) -> None:
    found = candidate_poses(pose, ROOM, radius_m=radius_m, clearance_m_min=clearance_m)
    apart = [math.hypot(each.x - pose.x, each.y - pose.y) for each in found]
    assert all(ROOM.at(each) >= clearance_m for each in found)
    assert all(distance <= radius_m + 1e-9 for distance in apart)
    assert all(a <= b + 1e-9 for a, b in itertools.pairwise(apart))
    assert {each.yaw for each in found} <= {pose.yaw}


def test_poses_face_what_they_shall_look_at() -> None:
    thing = Point3D(x=2.0, y=2.0, z=0.5)
    found = candidate_poses(Pose2D(x=2.0, y=2.0, yaw=0.0), ROOM, radius_m=1.2, clearance_m_min=0.25, look_at=thing)
    assert found
    for pose in found:
        assert math.isclose(math.cos(math.atan2(2.0 - pose.y, 2.0 - pose.x) - pose.yaw), 1.0)


def test_no_radius_is_no_ring_and_the_roomiest_can_be_asked_for() -> None:
    pose = Pose2D(x=-0.7, y=0.5, yaw=0.0)
    assert candidate_poses(pose, ROOM, radius_m=0.0, clearance_m_min=0.1) == []
    rooms = [
        ROOM.at(each) for each in by_clearance(candidate_poses(pose, ROOM, radius_m=0.6, clearance_m_min=0.1), ROOM)
    ]
    assert rooms == sorted(rooms, reverse=True)
    assert rooms[0] > ROOM.at(pose) + 0.3


def test_the_length_of_a_path_is_that_of_its_legs() -> None:
    at = [Pose2D(x=0.0, y=0.0, yaw=0.0), Pose2D(x=3.0, y=4.0, yaw=0.0), Pose2D(x=3.0, y=5.0, yaw=0.0)]
    assert length_m(tuple(at)) == 6.0
    assert length_m(()) == 0.0
