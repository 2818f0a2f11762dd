"""The arm's kinematics over its own model: there and back, what it touches, what it reaches, and where to stand."""

import math
from pathlib import Path

import numpy as np
import pytest

from contracts.geometry import Pose2D
from contracts.manipulation import FetchCause, GraspKind
from grasping.candidates import TipPose
from grasping.hands import SO101_HAND as HAND
from grasping.kinematics import NEAR_M, NEAR_RAD, ArmKinematics
from grasping.planning import WANTED, GraspPlan, plan_grasps
from grasping.reachability import CELL_M, SHAPE, ReachabilityMap, distance_scores, stances_for
from grasping.things import MeasuredThing
from sim.world.arm.models import SO101
from support.so101 import MOUNT, description, kinematics, reachability

STEEP = tuple(math.radians(each) for each in (0, 15, 30, 45, 60, 75))


def bottle(x: float = 0.3, y: float = 0.0) -> MeasuredThing:
    return MeasuredThing(x, y, 0.1, 0.066, 0.066, 0.2)


def plan(thing: MeasuredThing, kind: GraspKind = GraspKind.SIDE) -> GraspPlan:
    return plan_grasps(thing, kind, HAND, MOUNT.foot_x_m, reachability(), kinematics())


def test_where_the_tip_is_told_to_go_it_is() -> None:
    arm, chance = kinematics(), np.random.default_rng(1)
    for _ in range(20):
        joints = tuple(chance.uniform((-1.0, -0.5, -0.5, -1.0, -1.5), (1.0, 1.0, 1.0, 1.0, 1.5)).tolist())
        wanted = arm.tip_at(joints)
        near = tuple(each + 0.2 for each in joints)
        found = arm.solve(wanted, near)
        assert found is not None
        reached = arm.tip_at(found)
        assert np.linalg.norm(reached.at - wanted.at) < NEAR_M
        assert math.acos(min(1.0, float(reached.approach @ wanted.approach))) < 2 * NEAR_RAD


def test_what_is_out_of_reach_has_no_joints() -> None:
    far = TipPose(np.array((1.5, 0.0, 0.3)), np.array((1.0, 0.0, 0.0)), np.array((0.0, 0.0, 1.0)))
    assert kinematics().solve(far, SO101.home) is None


def test_joints_of_another_arm_are_refused() -> None:
    with pytest.raises(ValueError, match="5 finite joints"):
        kinematics().touches((0.0, 0.0), 0.0, None)


def test_folded_it_touches_nothing_and_bent_down_the_robot_or_the_floor() -> None:
    arm = kinematics()
    assert arm.touches(SO101.home, 0.0, None) == ()
    assert {"deck", "base", "floor"} & set(arm.touches((0.0, 1.6, 0.8, 0.6, 0.0), 0.0, None))


def test_a_thing_in_its_way_is_touched() -> None:
    arm = kinematics()
    planned = plan(bottle()).grasps[0]
    assert "round thing" not in arm.touches(planned.way_in[0], planned.jaw_rad, bottle())
    x, y, _ = (bottle().centre - 0.03 * planned.candidate.tip.opens).tolist()
    assert "round thing" in arm.touches(planned.way_in[-1], planned.jaw_rad, bottle(x, y)), "by the still jaw"


def test_the_hands_gaps_are_those_of_its_model() -> None:
    """Between the pads, along the tip's z; the turning pad is tilted, so that its middle counts."""
    import mujoco

    model = mujoco.MjModel.from_xml_path(str(SO101.file()))
    data = mujoco.MjData(model)
    for angle, gap in zip(HAND.angles_rad[:5], HAND.gaps_m[:5], strict=True):
        data.qpos[model.joint(SO101.gripper).qposadr[0]] = angle
        mujoco.mj_kinematics(model, data)
        tip, moving = data.site(HAND.tip), data.geom(HAND.pads[1])
        z = float((moving.xpos - tip.xpos) @ tip.xmat.reshape(3, 3)[:, 2])
        tilt = abs(float(moving.xmat.reshape(3, 3)[:, 0] @ tip.xmat.reshape(3, 3)[:, 2]))
        assert z - 0.0045 * tilt - HAND.face_m == pytest.approx(gap, abs=0.004)


# the map


def test_a_cell_that_the_map_says_is_reached_is() -> None:
    arm, reach = kinematics(), reachability()
    cells = np.argwhere(reach.margin > 0.15)
    chosen = cells[np.random.default_rng(2).choice(len(cells), 40, replace=False)]
    reached = 0
    for cell in chosen.tolist():
        tip = arm.tip_at((0.0, *reach.postures[tuple(cell)].tolist(), math.pi / 2))
        moved = tip.moved(np.array((0.004, 0.0, -0.004)))
        reached += arm.solve(moved, (0.1, *reach.postures[tuple(cell)].tolist(), math.pi / 2)) is not None
    assert reached >= 38


def test_beyond_its_length_the_map_says_no() -> None:
    reach = reachability()
    assert reach.margin_at(0.58, 0.1, 0.5) == -1.0
    assert reach.margin_at(3.0, 0.1, 0.5) == -1.0
    assert reach.posture_at(3.0, 0.1, 0.5) is None
    assert reach.margin_at(0.2, 0.1, math.radians(60)) >= 0.0


def test_the_map_is_kept_and_a_damaged_one_made_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    arm = kinematics()
    monkeypatch.setattr(ArmKinematics, "_sampled", lambda _: reachability())
    first = arm.reachability(tmp_path)
    (file,) = tmp_path.iterdir()
    monkeypatch.setattr(ArmKinematics, "_sampled", lambda _: pytest.fail("made twice"))
    assert np.array_equal(arm.reachability(tmp_path).margin, first.margin)
    file.write_bytes(file.read_bytes()[:100])
    monkeypatch.setattr(ArmKinematics, "_sampled", lambda _: reachability())
    assert np.array_equal(arm.reachability(tmp_path).margin, first.margin)


def test_another_mount_is_another_map(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ArmKinematics, "_sampled", lambda _: reachability())
    kinematics().reachability(tmp_path)
    from dataclasses import replace

    ArmKinematics(description(), replace(MOUNT, foot_z_m=0.2)).reachability(tmp_path)
    assert len(list(tmp_path.iterdir())) == 2


def test_tables_of_another_shape_are_refused() -> None:
    with pytest.raises(ValueError, match="cells, not"):
        ReachabilityMap(np.zeros((2, 2, 2), np.float32), np.zeros((2, 2, 2, 3), np.float32))
    assert np.prod(SHAPE) < 50_000


# plans


def test_a_bottle_in_reach_has_grasps_the_best_first_that_touch_nothing() -> None:
    found = plan(bottle())
    assert 0 < len(found.grasps) <= WANTED
    assert [one.score for one in found.grasps] == sorted((one.score for one in found.grasps), reverse=True)
    for one in found.grasps:
        assert not kinematics().touches(one.way_in[0], one.jaw_rad, bottle())
        assert all(not kinematics().touches(each, one.jaw_rad, None) for each in (*one.way_in, *one.way_up))


def test_the_tip_goes_straight_in() -> None:
    one = plan(bottle()).grasps[0]
    begin, end = one.candidate.before.at, one.candidate.tip.at
    for joints in one.way_in:
        at = kinematics().tip_at(joints).at - begin
        along = (end - begin) / np.linalg.norm(end - begin)
        assert np.linalg.norm(at - (at @ along) * along) < 2 * NEAR_M


@pytest.mark.parametrize(
    ("thing", "cause"),
    [
        (bottle(0.7), FetchCause.OUT_OF_REACH),
        (MeasuredThing(0.3, 0.0, 0.1, 0.12, 0.12, 0.2), FetchCause.TOO_WIDE),
    ],
)
def test_without_a_grasp_the_cause_is_told(thing: MeasuredThing, cause: FetchCause) -> None:
    assert plan(thing) == GraspPlan((), cause)


# where to stand


def test_where_to_stand_is_where_the_arm_reaches_and_the_base_is_clear() -> None:
    pan_x = MOUNT.foot_x_m + HAND.pan_from_foot_m
    distances = distance_scores(reachability(), 0.11, STEEP, pan_x, nearest_m=0.24)
    assert distances
    assert all(0.24 <= distance_m < 0.45 for distance_m, _ in distances)
    here = Pose2D(x=0.0, y=0.0, yaw=0.0)
    thing = MeasuredThing(2.0, 1.0, 0.1, 0.066, 0.066, 0.2)
    stances = stances_for(thing, distances, here)
    for one in stances:
        away = math.hypot(thing.x_m - one.pose.x, thing.y_m - one.pose.y)
        facing = math.atan2(thing.y_m - one.pose.y, thing.x_m - one.pose.x)
        assert any(away == pytest.approx(distance_m) for distance_m, _ in distances)
        assert math.cos(facing - one.pose.yaw) == pytest.approx(1.0)
    assert math.hypot(stances[0].pose.x - 2.0, stances[0].pose.y - 1.0) == pytest.approx(distances[0][0])
    assert [one.score for one in stances] == sorted((one.score for one in stances), reverse=True)


def test_from_the_best_place_to_stand_there_is_a_grasp() -> None:
    pan_x = MOUNT.foot_x_m + HAND.pan_from_foot_m
    (best, _), *_ = distance_scores(reachability(), 0.11, STEEP, pan_x, nearest_m=0.24)
    assert plan(bottle(best)).grasps
    assert best == pytest.approx(round((best - pan_x - CELL_M / 2) / CELL_M) * CELL_M + pan_x + CELL_M / 2)
