"""What a look should have shown: in view, in range, not hidden, not under another name."""

import math

import numpy as np
import pytest

from contracts.geometry import Pose2D
from contracts.measuring import Measurement
from contracts.memory import Look, SeenBox
from geometry.grids import OccupancyGrid
from geometry.poses import compose
from memory.frames import Camera, project
from memory.negative_evidence import Expected, classify, clear, expected, range_towards
from memory.objects import MapObject
from support.observations import HFOV_RAD, SIDE_PX, look

CAMERA = Camera(hfov_rad=HFOV_RAD, height_m=0.24, forward_m=0.06)


def cup(x: float = 1.2, y: float = 0.0, z: float = 0.3, label: str = "cup") -> MapObject:
    return MapObject(
        id=1, label=label, x=x, y=y, z=z, variance_m2=0.01, belief=0.9, believed_s=0.0, confidence=0.9,
        first_seen_s=0.0, last_seen_s=0.0,
    )  # fmt: skip


def verdict(given: Look, thing: MapObject, ground: OccupancyGrid | None = None, depth_m: float | None = None) -> str:
    wanted = expected(given, [thing], CAMERA, 2.3)

    def towards(one: Expected) -> Measurement:
        return Measurement(depth_m=depth_m if given.ranges_m is None else range_towards(one, given), sigma_m=0.01)

    seen, missing, undetermined = classify(given, wanted, towards, ground)
    return "seen" if seen else "missing" if missing else "undetermined" if undetermined else "out of view"


def test_what_is_in_plain_view_and_not_seen_is_missing() -> None:
    assert verdict(look(), cup()) == "missing"


@pytest.mark.parametrize(
    "thing",
    [cup(x=-1.2), cup(x=2.8), cup(x=0.3), cup(x=1.0, y=0.9), cup(x=0.7, z=0.75), cup(x=1.0, z=1.9)],
    ids=["behind", "too far", "too near", "beside", "above, close by", "high up"],
)
def test_what_is_out_of_view_keeps_its_belief(thing: MapObject) -> None:
    assert verdict(look(), thing) == "out of view"


def test_a_couch_is_expected_from_farther_than_a_cup() -> None:
    assert verdict(look(), cup(x=3.5)) == "out of view"
    assert verdict(look(), cup(x=3.5, label="couch")) == "missing"


def test_a_box_of_its_label_over_its_place_is_it() -> None:
    at = project((1.2, 0.0, 0.3), Pose2D(x=0.0, y=0.0, yaw=0.0), CAMERA, (SIDE_PX, SIDE_PX))
    assert at is not None
    assert verdict(look(0.0, 0.0, 0.0, SeenBox(label="cup", bbox_xyxy=at.box(0.1))), cup()) == "seen"


def test_a_box_of_another_label_over_its_place_may_be_it_under_another_name() -> None:
    everywhere = SeenBox(label="vase", bbox_xyxy=(0.0, 0.0, 250.0, 250.0))
    assert verdict(look(0.0, 0.0, 0.0, everywhere), cup()) == "undetermined"


def test_something_nearer_in_the_depth_image_hides_it() -> None:
    assert verdict(look(far_m=0.7), cup()) == "undetermined"
    assert verdict(look(far_m=1.1), cup()) == "missing"


def test_only_what_was_looked_for_can_be_missing() -> None:
    assert verdict(look(labels=("bottle",)), cup()) == "out of view"
    assert verdict(look(labels=("bottle", "cup")), cup()) == "missing"


def test_without_depth_and_without_a_map_nothing_can_be_told() -> None:
    assert verdict(look(far_m=None), cup()) == "undetermined"


def wall_at(x: float) -> OccupancyGrid:
    cells = np.zeros((80, 80), np.int8)
    cells[:, int((x + 2.0) / 0.05)] = 100
    return OccupancyGrid(cells, 0.05, Pose2D(x=-2.0, y=-2.0, yaw=0.0))


def test_a_wall_of_the_map_hides_it_but_what_it_stands_on_does_not() -> None:
    assert verdict(look(far_m=None), cup(x=1.5), wall_at(0.5)) == "undetermined"
    assert verdict(look(far_m=None), cup(x=1.5), wall_at(1.3)) == "missing"
    assert verdict(look(far_m=None), cup(x=1.5), wall_at(1.3), depth_m=0.8) == "undetermined"


@pytest.mark.parametrize("yaw", [0.1, math.pi / 2, math.pi, -2.0])
def test_a_wall_of_a_turned_map_hides_what_is_behind_it(yaw: float) -> None:
    """The map's rows run along its own axis: the wall is the row that crosses the way to the cup."""
    cells = np.zeros((81, 81), np.int8)
    cells[:, 60] = 100  # one metre from the middle
    corner = compose(Pose2D(x=0.0, y=0.0, yaw=yaw), Pose2D(x=-2.025, y=-2.025, yaw=0.0))
    turned = OccupancyGrid(cells, 0.05, corner)
    ahead, behind = ((math.cos(a), math.sin(a)) for a in (yaw, yaw + math.pi))
    here = Pose2D(x=0.0, y=0.0, yaw=0.0)
    assert not clear(turned, here, cup(2.0 * ahead[0], 2.0 * ahead[1]))
    assert clear(turned, here, cup(2.0 * behind[0], 2.0 * behind[1]))


def test_a_point_is_projected_as_a_pinhole_does() -> None:
    pose = Pose2D(x=1.0, y=2.0, yaw=math.pi / 2)
    at = project((0.5, 3.06, 0.24), pose, CAMERA, (SIDE_PX, SIDE_PX))
    assert at is not None
    assert at.u == pytest.approx(125.0 - 0.5 * 125.0 / math.tan(HFOV_RAD / 2))
    assert at.v == pytest.approx(125.0)
    assert at.distance_m == pytest.approx(math.hypot(0.5, 1.0))
    assert project((1.0, 1.0, 0.2), pose, CAMERA, (SIDE_PX, SIDE_PX)) is None
