"""Sectors, ring, gaps and affordances of drawn rooms, scanned beam by beam."""

import math

import numpy as np
import pytest

from contracts.obstacles import Gap, Obstacles, SectorLabel
from robot_bridge.safety.obstacles import ObstacleLimits, obstacles
from robot_bridge.sensing.sensor_readings import Scan

LIMITS = ObstacleLimits()
RADIUS_M = LIMITS.footprint_radius_m
Wall = tuple[tuple[float, float], tuple[float, float]]


def scanned(walls: list[Wall], *, beams: int = 720, reach_m: float = 12.0, unknown_deg: range = range(0)) -> Scan:
    """What a laser in base_link says of the walls; whole degrees in `unknown_deg` say nothing."""
    hits, open_rad = [], []
    for bearing in np.linspace(-math.pi, math.pi, beams, endpoint=False):
        if math.floor(math.degrees(bearing)) in unknown_deg:
            continue
        ray = np.array([math.cos(bearing), math.sin(bearing)])
        distance = min((_hit(ray, wall) for wall in walls), default=math.inf)
        if distance <= reach_m:
            hits.append(ray * distance)
        else:
            open_rad.append(bearing)
    points = np.array(hits) if hits else np.empty((0, 2))
    return Scan(1.0, points, open_rad=np.array(open_rad))


def _hit(ray: np.ndarray, wall: Wall) -> float:
    a, b = np.array(wall[0]), np.array(wall[1])
    across = np.array([ray, a - b]).T
    if abs(np.linalg.det(across)) < 1e-12:
        return math.inf
    t, part = np.linalg.solve(across, a)
    return float(t) if t > 0.0 and 0.0 <= part <= 1.0 else math.inf


def room(half_m: float) -> list[Wall]:
    corners = [(half_m, half_m), (-half_m, half_m), (-half_m, -half_m), (half_m, -half_m)]
    return list(zip(corners, corners[1:] + corners[:1], strict=True))


def seen(walls: list[Wall], **how: object) -> Obstacles:
    return obstacles(scanned(walls, **how), LIMITS)  # type: ignore[arg-type]


def test_each_named_sector_tells_the_nearest_distance_from_the_footprint() -> None:
    found = seen([*room(3.0), ((1.0, -0.2), (1.0, 0.2))])
    assert found.sectors_m["front"] == pytest.approx(1.0 - RADIUS_M, abs=0.01)
    assert found.sectors_m["front_wide"] == pytest.approx(1.0 - RADIUS_M, abs=0.01)
    assert found.sectors_m["left"] == pytest.approx(3.0 - RADIUS_M, abs=0.01)
    assert found.sectors_m["back"] == pytest.approx(3.0 - RADIUS_M, abs=0.01)
    assert not found.emergency


def test_something_inside_the_stop_distance_ahead_is_an_emergency() -> None:
    assert seen([((0.26, -0.2), (0.26, 0.2))]).emergency
    assert not seen([((-0.26, -0.2), (-0.26, 0.2))]).emergency


@pytest.mark.parametrize(
    ("clearance_m", "label"), [(0.1, "WALL"), (0.3, "OBSTACLE"), (0.7, "NEAR"), (1.5, "CLEAR"), (50.0, "CLEAR")]
)
def test_the_ring_labels_each_thirty_degrees(clearance_m: float, label: str) -> None:
    ahead = clearance_m + RADIUS_M
    found = seen([((ahead, -ahead), (ahead, ahead))])
    assert [sector.label for sector in found.ring][:1] == [SectorLabel(label)]
    assert [round(math.degrees(sector.bearing_rad)) for sector in found.ring] == [
        0, 30, 60, 90, 120, 150, -180, -150, -120, -90, -60, -30,
    ]  # fmt: skip


def test_one_stray_beam_does_not_change_a_ring_sector_but_a_tenth_of_them_does() -> None:
    scan = scanned(room(3.0))
    stray = Scan(1.0, np.concatenate([scan.points_m, [[0.5, 0.0]]]))
    assert obstacles(stray, LIMITS).ring[0].label is SectorLabel.CLEAR
    many = Scan(1.0, np.concatenate([scan.points_m, np.full((8, 2), [0.5, 0.0])]))
    assert obstacles(many, LIMITS).ring[0].distance_m == pytest.approx(0.5 - RADIUS_M)


def test_free_and_not_known_are_different_things() -> None:
    nothing = seen([])
    assert {sector.label for sector in nothing.ring} == {SectorLabel.CLEAR}
    assert {sector.distance_m for sector in nothing.ring} == {None}
    assert nothing.affordances.forward == 1.0
    blind = seen(room(3.0), unknown_deg=range(-60, 60))
    assert blind.ring[0].label is None
    assert blind.affordances.forward == 0.1
    assert blind.affordances.backward == 1.0


def test_affordances_grow_with_the_distance() -> None:
    found = seen([((1.3, -4.0), (1.3, 4.0)), ((-0.3, 0.5), (4.0, 0.5)), ((-3.0, -4.0), (-3.0, 4.0))])
    clearance_m = 1.3 - RADIUS_M
    assert found.affordances.forward > found.affordances.left
    assert 0.1 < found.affordances.left < found.affordances.forward < 1.0
    assert found.affordances.right == 1.0
    assert found.affordances.backward == 1.0
    lone = seen([((1.3, -0.01), (1.3, 0.01))]).affordances.forward
    assert lone == pytest.approx(0.1 + 0.9 * (clearance_m - 0.2) / 1.8, abs=0.01)


def doorway(width_m: float, *, ahead_m: float = 1.5, shift_m: float = 0.0) -> list[Wall]:
    """A room with a door in the wall ahead, and another room behind it."""
    left, right = shift_m + width_m / 2.0, shift_m - width_m / 2.0
    return [
        ((ahead_m, left), (ahead_m, 2.0)),
        ((ahead_m, -2.0), (ahead_m, right)),
        ((ahead_m, 2.0), (-2.0, 2.0)),
        ((-2.0, 2.0), (-2.0, -2.0)),
        ((-2.0, -2.0), (ahead_m, -2.0)),
        ((5.0, -4.0), (5.0, 4.0)),
        ((ahead_m, 4.0), (5.0, 4.0)),
        ((ahead_m, -4.0), (5.0, -4.0)),
    ]


@pytest.mark.parametrize(("width_m", "shift_m"), [(0.8, 0.0), (0.9, 0.7), (1.2, -0.5), (0.75, 0.0)])
def test_a_doorway_is_a_gap_with_its_width_and_bearing(width_m: float, shift_m: float) -> None:
    (gap,) = seen(doorway(width_m, shift_m=shift_m)).gaps
    assert gap.width_m == pytest.approx(width_m, abs=0.06)
    assert gap.bearing_rad == pytest.approx(math.atan2(shift_m, 1.5), abs=0.04)
    assert gap.distance_m == pytest.approx(math.hypot(1.5, shift_m), abs=0.05)


@pytest.mark.parametrize("walls", [doorway(0.5), room(2.0), [*room(3.0), ((1.0, -0.2), (1.0, 0.2))][:4]])
def test_what_is_too_narrow_or_no_opening_at_all_is_no_gap(walls: list[Wall]) -> None:
    assert seen(walls).gaps == ()


def test_an_alcove_is_no_doorway() -> None:
    walls = [wall for wall in doorway(0.9) if wall[0][0] != 5.0 and wall[1][0] != 5.0]
    walls += [((2.1, -0.45), (2.1, 0.45)), ((1.5, 0.45), (2.1, 0.45)), ((1.5, -0.45), (2.1, -0.45))]
    limits = ObstacleLimits(gap_behind_m=0.8)
    assert obstacles(scanned(walls), limits).gaps == ()
    assert len(obstacles(scanned(doorway(0.9)), limits).gaps) == 1


def test_a_doorway_behind_the_robot_has_its_bearing_too() -> None:
    turned = [tuple((-x, -y) for x, y in wall) for wall in doorway(0.9)]
    (gap,) = seen(turned).gaps  # type: ignore[arg-type]
    assert abs(gap.bearing_rad) == pytest.approx(math.pi, abs=0.04)


def test_a_doorway_nobody_can_see_into_is_not_claimed() -> None:
    assert seen(doorway(0.9), unknown_deg=range(-25, 25)).gaps == ()


def test_noise_of_the_laser_makes_no_gaps_and_hides_none() -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        scan = scanned(doorway(0.9))
        radius = np.hypot(scan.points_m[:, 0], scan.points_m[:, 1])
        noisy = scan.points_m * (1.0 + rng.normal(0.0, 0.01, radius.shape) / radius)[:, None]
        found: tuple[Gap, ...] = obstacles(Scan(1.0, noisy, open_rad=scan.open_rad), LIMITS).gaps
        assert [round(gap.width_m, 1) for gap in found] == [0.9]
