"""What each sensor of the simulated robot gets wrong; pure but for the random numbers it is given."""

import math

import numpy as np
from numpy.typing import NDArray

from contracts.geometry import Pose2D
from geometry.poses import compose
from sim.world.types import Floats, WorldOptions

SCAN_RAYS = 720
SCAN_RANGE_MIN_M, SCAN_RANGE_MAX_M = 0.15, 12.0
_PATCH_PX = 40


def noisy_scan(distances_m: NDArray[np.float64], rng: np.random.Generator, sigma_m: float) -> Floats:
    """Float32 ranges from true ones (negative = nothing hit): noise, and `inf` outside the lidar's range."""
    noisy = distances_m + sigma_m * rng.standard_normal(distances_m.shape)
    seen = (distances_m >= SCAN_RANGE_MIN_M) & (distances_m <= SCAN_RANGE_MAX_M)
    return np.where(seen, np.clip(noisy, SCAN_RANGE_MIN_M, SCAN_RANGE_MAX_M), np.inf).astype(np.float32)


class DepthNoise:
    """Stereo noise of standard deviation 0.012 m * z^3.461, which gives 1.2 cm at 1.0 m and 28.6 cm at 2.5 m.

    Most of the variance is shared by neighbouring pixels (patches of 40 px), as it is in block-matched stereo: a median
    over an object's box keeps it. The rest is each pixel's own. Beyond `depth_max_m` returns fade out within 0.2 m.
    Both parts are cut out of larger fields drawn once, at random places: drawing them anew costs more than rendering.
    """

    def __init__(self, height_px: int, width_px: int, options: WorldOptions, rng: np.random.Generator) -> None:
        self._options = options
        self._shape = (height_px, width_px)
        field = (2 * height_px, 2 * width_px)
        shared, own = math.sqrt(options.depth_correlated_share / 2), math.sqrt(1 - options.depth_correlated_share)
        self._shared = [np.float32(shared) * _smooth_field(field, rng) for _ in range(2)]
        self._own = np.float32(own) * rng.standard_normal(field, dtype=np.float32)
        self._fading = np.float32(options.depth_max_m) + 0.1 * rng.standard_normal(field, dtype=np.float32)
        table = np.arange(0, int(options.depth_max_m * 100) + 60) / 100.0
        sigma = options.depth_sigma_m_at_1m * table**options.depth_sigma_exponent
        self._sigma_by_cm = np.minimum(sigma, options.depth_sigma_max_m).astype(np.float32)

    def apply(self, true_m: Floats, rng: np.random.Generator) -> Floats:
        """Float32 of the same shape, m along the optical axis; 0.0 where nothing comes back."""
        options = self._options
        if options.noise_free:
            return np.where(true_m <= options.depth_max_m, true_m, 0.0).astype(np.float32)
        noise = self._cut(self._shared[0], rng) + self._cut(self._shared[1], rng)
        noise += self._cut(self._own, rng)
        centimetres = np.minimum(true_m, np.float32(options.depth_max_m + 0.5))
        centimetres *= np.float32(100.0)
        noise *= np.take(self._sigma_by_cm, centimetres.astype(np.int32))
        noise += true_m
        noise *= (true_m < self._cut(self._fading, rng)) & (np.minimum(true_m, noise) >= options.depth_min_m)
        return noise

    def _cut(self, field: Floats, rng: np.random.Generator) -> Floats:
        """A piece of the picture's size from a random place of a field."""
        height, width = self._shape
        row, column = rng.integers(0, (height, width)).tolist()
        return field[row : row + height, column : column + width]


def _smooth_field(shape: tuple[int, int], rng: np.random.Generator) -> Floats:
    """Unit-variance normal noise that neighbouring pixels share: coarse numbers, interpolated."""
    rows, columns = _smooth_upsampling(shape[0]), _smooth_upsampling(shape[1])
    coarse = rng.standard_normal((rows.shape[1], columns.shape[1]), dtype=np.float32)
    return (rows @ coarse @ columns.T).astype(np.float32)


def _smooth_upsampling(size_px: int) -> Floats:
    """(size, n) weights that spread n coarse normal numbers over `size` pixels, unit variance everywhere."""
    centres = np.arange(-_PATCH_PX // 2, size_px + _PATCH_PX, _PATCH_PX)
    distance = np.abs(np.arange(size_px)[:, None] - centres[None, :]) / _PATCH_PX
    weights = np.maximum(0.0, 1.0 - distance)
    return (weights / np.linalg.norm(weights, axis=1, keepdims=True)).astype(np.float32)


class OdometryDrift:
    """Dead reckoning with a wrong wheel scale and a heading that wanders with the way driven."""

    def __init__(self, options: WorldOptions, rng: np.random.Generator) -> None:
        self._rng = rng
        perfect = options.noise_free
        draw, turn_draw = (0.0, 0.0) if perfect else rng.standard_normal(2)
        self._scale = 1.0 + options.odometry_scale_sigma * float(np.clip(draw, -2, 2))
        self._turn_scale = 1.0 + options.odometry_turn_scale_sigma * float(np.clip(turn_draw, -2, 2))
        self._heading_sigma = 0.0 if perfect else options.odometry_heading_sigma_rad_per_sqrt_m
        self.pose = Pose2D(x=0.0, y=0.0, yaw=0.0)

    def move(self, forward_m: float, sideways_m: float, turn_rad: float) -> None:
        """The robot really moved so, in its own frame."""
        way_m = math.hypot(forward_m, sideways_m)
        wander = self._heading_sigma * math.sqrt(way_m) * float(self._rng.standard_normal())
        moved = Pose2D(x=self._scale * forward_m, y=self._scale * sideways_m, yaw=self._turn_scale * turn_rad + wander)
        self.pose = compose(self.pose, moved)


class LocalizationError:
    """How far the localiser is off: three slowly wandering numbers (Ornstein-Uhlenbeck), cut at 2.5 sigma."""

    def __init__(self, options: WorldOptions, rng: np.random.Generator) -> None:
        self._rng = rng
        sigma = (options.localization_sigma_m, options.localization_sigma_m, options.localization_sigma_yaw_rad)
        self._sigma = np.zeros(3) if options.noise_free else np.array(sigma)
        self._memory_s = options.localization_wander_s
        self._value = rng.standard_normal(3)

    def tick(self, dt_s: float) -> None:
        keep = math.exp(-dt_s / self._memory_s)
        self._value = keep * self._value + math.sqrt(1 - keep * keep) * self._rng.standard_normal(3)

    @property
    def value(self) -> tuple[float, float, float]:
        """Error in x (m), y (m) of the map, and yaw (rad)."""
        x, y, yaw = (np.clip(self._value, -2.5, 2.5) * self._sigma).tolist()
        return x, y, yaw


class BatteryModel:
    """26 Wh: about 5 W idle and 8 W more at full speed; the dock gives 20 W."""

    _CAPACITY_J = 26.0 * 3600.0

    def __init__(self, percentage: float) -> None:
        self.percentage = percentage
        self.charging = False

    def tick(self, dt_s: float, speed_m_s: float, docked: bool) -> None:
        self.charging = docked and self.percentage < 100.0
        power_w = 20.0 if self.charging else -(5.0 + 26.0 * abs(speed_m_s))
        self.percentage = min(100.0, max(0.0, self.percentage + 100.0 * power_w * dt_s / self._CAPACITY_J))

    @property
    def voltage_v(self) -> float:
        """Four lithium cells in series, roughly linear between 13.2 V and 16.4 V."""
        return 13.2 + 3.2 * self.percentage / 100.0
