"""What the simulated robot measures, against what is really there."""

import math

import numpy as np
import pytest

from contracts.geometry import Pose2D
from sim.world import RenderingUnavailableError, Scan, WorldOptions
from sim.world.robot import DEPTH_CAMERA, LIDAR, RGB_CAMERA
from sim.world.sensors import DepthNoise
from support.simulated_room import DOCK, MIDDLE, PERFECT, drive, world_at

NOISY = WorldOptions()


def _at(scan: Scan, from_ahead_rad: float) -> float:
    """The range in a direction of the robot, whose lidar is mounted a quarter turn to the left."""
    return float(scan.ranges_m[round((from_ahead_rad - math.pi / 2 - scan.angle_min) / scan.angle_increment) % 720])


@pytest.mark.parametrize(
    ("angle", "distance"),
    [(0.0, 3.0 - LIDAR.x), (math.pi / 2, 2.6), (-math.pi / 2, 1.4), (-math.pi, 3.0 + LIDAR.x)],
)
def test_the_lidar_sees_the_walls_at_their_true_distances(angle: float, distance: float) -> None:
    scan = world_at(Pose2D(x=3.0, y=1.4, yaw=0.0)).scan()
    assert scan.ranges_m.shape == (720,)
    assert scan.ranges_m.dtype == np.float32
    assert _at(scan, angle) == pytest.approx(distance, abs=0.005)


def test_the_lidar_turns_with_the_robot() -> None:
    scan = world_at(Pose2D(x=2.0, y=2.0, yaw=math.pi / 2)).scan()
    assert _at(scan, -math.pi / 2) == pytest.approx(4.0, abs=0.005)


def test_lidar_noise_is_a_centimetre() -> None:
    world = world_at(options=NOISY)
    ahead = [_at(world.scan(), 0.0) for _ in range(200)]
    assert np.std(ahead) == pytest.approx(NOISY.scan_sigma_m, rel=0.25)
    assert np.mean(ahead) == pytest.approx(4.0 - LIDAR.x, abs=0.005)


@pytest.mark.parametrize(("distance", "sigma"), [(1.0, 0.012), (2.5, 0.286)])
def test_depth_noise_is_as_published(distance: float, sigma: float) -> None:
    rng = np.random.default_rng(0)
    noise = DepthNoise(400, 640, NOISY, rng)
    true = np.full((400, 640), distance, np.float32)
    frames = np.stack([noise.apply(true, rng) for _ in range(12)])
    seen = frames[frames > 0]
    assert len(seen) > 0.95 * frames.size
    assert np.std(seen) == pytest.approx(sigma, rel=0.08)
    assert np.mean(seen) == pytest.approx(distance, abs=0.2 * sigma)


def test_the_median_over_a_box_keeps_most_of_the_depth_noise() -> None:
    rng = np.random.default_rng(1)
    noise = DepthNoise(400, 640, NOISY, rng)
    true = np.full((400, 640), 2.5, np.float32)
    medians = [float(np.median(noise.apply(true, rng)[180:220, 300:340])) for _ in range(60)]
    assert 0.12 < np.std(medians) < 0.286


def test_depth_has_no_return_beyond_three_metres_and_inside_0_2() -> None:
    rng = np.random.default_rng(0)
    noise = DepthNoise(400, 640, NOISY, rng)
    assert (noise.apply(np.full((400, 640), 3.6, np.float32), rng) == 0.0).all()
    assert (noise.apply(np.full((400, 640), 0.15, np.float32), rng) == 0.0).all()


def test_depth_pictures_show_the_wall_ahead_at_its_true_distance() -> None:
    with world_at(Pose2D(x=4.5, y=2.0, yaw=0.0)) as world:
        depth = world.depth()
        assert depth.shape == (400, 640)
        assert depth.dtype == np.float32
        assert depth[150, 320] == pytest.approx(6.0 - 4.5 - DEPTH_CAMERA.x_m, abs=0.005)


def test_a_point_lands_on_the_pixel_the_camera_model_says() -> None:
    with world_at(Pose2D(x=3.5, y=2.8, yaw=0.0)) as world:
        depth, camera = world.depth(), world.depth_camera
        ahead, left, up = 4.5 - 0.04 - 3.5 - camera.x_m, 0.2, 0.2 - camera.z_m
        u, v = camera.cx - camera.fx * left / ahead, camera.cy - camera.fy * up / ahead
        assert depth[int(v), int(u)] == pytest.approx(ahead, abs=0.01)
        assert depth[int(v), int(u) + 40] == 0.0 or depth[int(v), int(u) + 40] > ahead + 0.5


def test_the_colour_picture_shows_the_red_bottle_in_its_middle() -> None:
    with world_at(Pose2D(x=3.7, y=3.0, yaw=0.0)) as world:
        picture = world.rgb()
        assert picture.shape == (250, 250, 3)
        assert picture.dtype == np.uint8
        red, green, blue = picture[140, 125].astype(int)
        assert red > 2 * green
        assert red > 2 * blue


def test_without_egl_the_error_names_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sim.world.rendering.ctypes.util.find_library", lambda _name: None)
    with pytest.raises(RenderingUnavailableError, match="apt-get install -y --no-install-recommends libegl1"):
        world_at().rgb()


def test_noisy_depth_pictures_are_repeatable_and_float32() -> None:
    with world_at(seed=2, options=NOISY) as one, world_at(seed=2, options=NOISY) as two:
        first, second = one.depth(), two.depth()
        assert first.dtype == np.float32
        assert (first == second).all()
        assert (one.depth() != first).any()


def test_camera_models_have_the_robots_fields_of_view() -> None:
    assert math.degrees(RGB_CAMERA.horizontal_fov_rad) == pytest.approx(54.0)
    assert math.degrees(DEPTH_CAMERA.horizontal_fov_rad) == pytest.approx(72.0)
    assert (RGB_CAMERA.width_px, RGB_CAMERA.height_px) == (250, 250)
    assert (DEPTH_CAMERA.width_px, DEPTH_CAMERA.height_px) == (640, 400)


def test_odometry_drifts_but_by_no_more_than_a_few_percent() -> None:
    errors: list[float] = []
    for seed in range(4):
        world = world_at(Pose2D(x=1.0, y=2.0, yaw=0.0), seed=seed, options=NOISY)
        drive(world, 0.3, 0.0, 10.0)
        told = world.odometry().pose
        errors.append(math.hypot(told.x - (world.truth.pose.x - 1.0), told.y - (world.truth.pose.y - 2.0)))
    assert max(errors) > 0.002
    assert max(errors) < 0.15


def test_perfect_odometry_begins_at_zero_and_tells_the_way() -> None:
    world = world_at(Pose2D(x=1.0, y=2.0, yaw=0.5), options=PERFECT)
    assert world.odometry().pose == Pose2D(x=0.0, y=0.0, yaw=0.0)
    drive(world, 0.3, 0.0, 2.0)
    assert world.odometry().pose.x == pytest.approx(world.truth.path_length_m, abs=0.01)
    assert world.odometry().twist.linear_x == pytest.approx(0.3, rel=0.03)


def test_the_localiser_is_off_by_centimetres_and_never_the_truth() -> None:
    world = world_at(options=NOISY)
    errors: list[tuple[float, float]] = []
    for _ in range(100):
        world.advance(1.0)
        told, true = world.localization().pose, world.truth.pose
        assert told != true
        errors.append((math.hypot(told.x - true.x, told.y - true.y), abs(told.yaw - true.yaw)))
    away, turned = np.array(errors).T
    assert 0.01 < np.mean(away) < 0.05
    assert np.max(away) < 0.09
    assert np.max(turned) < 0.04


def test_the_localiser_wanders_slowly() -> None:
    world = world_at(options=NOISY)
    before = world.localization().pose
    world.advance(0.2)
    after = world.localization().pose
    assert math.hypot(after.x - before.x, after.y - before.y) < 0.02


def test_the_localisers_covariance_stands_on_the_diagonal() -> None:
    estimate = world_at(options=NOISY).localization()
    assert len(estimate.covariance) == 36
    assert estimate.covariance[0] == pytest.approx(estimate.sigma_x_m**2)
    assert estimate.covariance[35] == pytest.approx(estimate.sigma_yaw_rad**2)


def test_the_imu_feels_gravity_and_the_turn() -> None:
    world = world_at()
    drive(world, 0.0, 1.0, 1.5)
    imu = world.imu()
    assert imu.angular_velocity[2] == pytest.approx(1.0, abs=0.1)
    assert imu.linear_acceleration[2] == pytest.approx(9.81, abs=1.5)


def test_the_battery_falls_while_driving_and_fills_on_the_dock() -> None:
    driving, docked = world_at(), world_at(DOCK)
    before = driving.battery().percentage
    drive(driving, 0.1, 0.5, 20.0)
    docked.advance(20.0)
    assert driving.battery().percentage < before
    assert not driving.battery().charging
    assert docked.battery().percentage > before
    assert docked.battery().charging


def test_the_same_seed_gives_the_same_readings_and_another_seed_does_not() -> None:
    one, same, other = (world_at(MIDDLE, seed=seed, options=NOISY) for seed in (3, 3, 4))
    for world in (one, same, other):
        drive(world, 0.2, 0.3, 2.0)
    assert one.localization() == same.localization() != other.localization()
    assert one.odometry() == same.odometry() != other.odometry()
    first, second, third = one.scan().ranges_m, same.scan().ranges_m, other.scan().ranges_m
    assert (first == second).all()
    assert (first != third).any()
