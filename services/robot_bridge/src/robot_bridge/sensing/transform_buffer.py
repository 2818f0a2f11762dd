"""Where frames are and were: a tree of transforms over time, and the robot's pose in the map at any recent moment."""

# pytransform3d ships no types.
# pyright: reportUnknownMemberType=false, reportUnknownVariableType=false, reportUntypedBaseClass=false
# pyright: reportUnknownArgumentType=false

import math
import threading
from bisect import bisect_right
from typing import Any, cast

import numpy as np
from pytransform3d.transform_manager import NumpyTimeseriesTransform, TemporalTransformManager, TimeVaryingTransform
from pytransform3d.transformations import pq_from_transform, transform_from_pq

from contracts.geometry import Pose2D
from geometry.poses import compose, inverse
from robot_bridge.sensing.transforms import Matrix, planar, upright

HISTORY_S = 20.0
"""How far back a pose can be asked for."""
EXTRAPOLATION_S = 0.25
"""How far past the newest sample the newest pose still counts as the pose then."""
RECENT_S = 1.0
"""So far back the newest correction is better than the one before it: it is what the localiser has learned since."""
FRAMES_MAX = 500
NEWEST = math.inf
"""The moment of each transform's newest sample."""


class UnknownMomentError(LookupError):
    """A transform is not known at the time asked for."""


class TransformTrack(TimeVaryingTransform):
    """One frame in another over the last `HISTORY_S`, in the order of the stamps; between samples it is interpolated
    along a screw motion (ScLERP)."""

    def __init__(self, extrapolation_s: float = EXTRAPOLATION_S) -> None:
        self._extrapolation_s = extrapolation_s
        self._stamps_s: list[float] = []
        self._late_s: float | None = None
        self._pqs: list[Any] = []

    def __len__(self) -> int:
        return len(self._stamps_s)

    @property
    def newest_s(self) -> float:
        """The newest sample's stamp; -inf without one, or where it is the same at all times."""
        return self._stamps_s[-1] if self._stamps_s else -math.inf

    def add(self, stamp_s: float, transform: Matrix) -> None:
        """A late or repeated sample is ignored. Two late ones in their order, or one that is very late, say that the
        clock was set back: the past is another world then."""
        stamps, late_s = self._stamps_s, self._late_s
        self._late_s = None
        if stamps and stamp_s <= stamps[-1]:
            set_back = stamp_s <= stamps[-1] - HISTORY_S or (late_s is not None and late_s < stamp_s < stamps[-1])
            if set_back:
                self.fix(transform)
                stamps[0] = stamp_s
            elif stamp_s < stamps[-1]:
                self._late_s = stamp_s
            return
        stamps.append(stamp_s)
        self._pqs.append(pq_of(transform))
        half = len(stamps) // 2
        if len(stamps) > 64 and stamps[half] < stamp_s - HISTORY_S:
            del stamps[:half], self._pqs[:half]

    def fix(self, transform: Matrix) -> None:
        """The same at all times, whatever was known before."""
        self._stamps_s[:], self._pqs[:] = [-math.inf], [pq_of(transform)]

    def renew(self, transform: Matrix) -> None:
        """The newest sample was this instead."""
        self._pqs[-1] = pq_of(transform)

    def at(self, stamp_s: float, *, extrapolation_s: float | None = None) -> Matrix | None:
        """None before the first sample or too long after the last."""
        after = bisect_right(self._stamps_s, stamp_s)
        if after == 0:
            return None
        if after == len(self._stamps_s):
            allowed_s = self._extrapolation_s if extrapolation_s is None else extrapolation_s
            fresh = stamp_s == NEWEST or stamp_s - self._stamps_s[-1] <= allowed_s or self._stamps_s[-1] == -math.inf
            return cast(Matrix, transform_from_pq(self._pqs[-1])) if fresh else None
        between = slice(after - 1, after + 1)
        first, second = self._pqs[between]
        if _is_upright(first) and _is_upright(second):
            before_s, after_s = self._stamps_s[between]
            return _upright_between(first, second, (stamp_s - before_s) / (after_s - before_s))
        series = NumpyTimeseriesTransform(np.array(self._stamps_s[between]), np.array(self._pqs[between]))
        return cast(Matrix, series.as_matrix(stamp_s))

    def as_matrix(self, query_time: "float | np.ndarray[Any, Any]") -> Matrix:
        """For pytransform3d's manager, which asks for one moment; raises `UnknownMomentError`."""
        if (transform := self.at(float(query_time))) is None:
            raise UnknownMomentError(query_time)
        return transform

    def check_transforms(self) -> "TransformTrack":
        """Samples are checked where they come in."""
        return self


def pq_of(transform: Matrix) -> Any:
    """As `pq_from_transform`, which takes a fifth of a millisecond to check it. That of a robot on a floor comes at the
    rate of its odometry, and is written out to the same bits."""
    (a, b, c, x), (d, e, f, y), (g, h, i, z) = transform[:3].tolist()
    if not (c == f == g == h == 0.0 and i == 1.0 and a == e and b == -d):
        return pq_from_transform(transform)
    if a + e + i > 0.0:
        root = math.sqrt(1.0 + (a + e + i))
        return np.array([x, y, z, 0.5 * root, 0.0, 0.0, 0.5 / root * (d - b)])
    root = math.sqrt(1.0 + i - a - e)
    return np.array([x, y, z, 0.5 / root * (d - b), 0.0, 0.0, 0.5 * root])


def _is_upright(pq: Any) -> bool:
    """Of a robot on a floor, as every sample of odometry and of the localiser is."""
    return bool(pq[2] == pq[4] == pq[5] == 0.0)


def _upright_between(first: Any, second: Any, share: float) -> Matrix:
    """The same screw motion in the plane, for a hundredth of the time: an arc of constant speed and turn."""
    x, y, yaw = float(first[0]), float(first[1]), 2.0 * math.atan2(first[6], first[3])
    cos, sin = math.cos(yaw), math.sin(yaw)
    dx, dy = float(second[0]) - x, float(second[1]) - y
    ahead, left = cos * dx + sin * dy, cos * dy - sin * dx
    turned = math.remainder(2.0 * math.atan2(second[6], second[3]) - yaw, math.tau)
    if abs(turned) > 1e-9:  # along the arc, not the chord
        half, part = turned / 2.0, share * turned
        pull = half / math.tan(half)
        speed_x, speed_y = pull * ahead + half * left, pull * left - half * ahead
        ahead = (math.sin(part) * speed_x - (1.0 - math.cos(part)) * speed_y) / turned
        left = ((1.0 - math.cos(part)) * speed_x + math.sin(part) * speed_y) / turned
    else:
        ahead, left = share * ahead, share * left
    then_cos, then_sin = math.cos(yaw + share * turned), math.sin(yaw + share * turned)
    return np.array([
        [then_cos, -then_sin, 0.0, x + cos * ahead - sin * left],
        [then_sin, then_cos, 0.0, y + sin * ahead + cos * left],
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ])  # fmt: skip


class TransformBuffer:
    """The frames of the robot's body (tf_static, and tf where a joint moves), each in its parent. Any thread."""

    def __init__(self, base_frame: str = "base_link") -> None:
        self._base_frame = base_frame
        self._lock = threading.Lock()
        self._tracks: dict[str, tuple[str, TransformTrack]] = {}
        self._manager: TemporalTransformManager | None = None

    def set_base(self, base_frame: str) -> None:
        self._base_frame = base_frame

    def fix(self, parent: str, child: str, child_in_parent: Matrix) -> None:
        """Any order; a later transform of the same child replaces the earlier.

        Raises `ValueError` for a frame in itself and for one without a name; so does `move`.
        """
        with self._lock:
            if (track := self._track(parent, child)) is not None:
                track.fix(child_in_parent)

    def move(self, parent: str, child: str, stamp_s: float, child_in_parent: Matrix) -> None:
        """Where a joint held the child at `stamp_s`."""
        with self._lock:
            if (track := self._track(parent, child)) is not None:
                track.add(stamp_s, child_in_parent)

    def in_base(self, frame: str, stamp_s: float = NEWEST) -> Matrix | None:
        """The frame in base_link, 4x4; none when no chain of transforms known at that time leads there."""
        return self.between(frame, self._base_frame, stamp_s)

    def between(self, frame: str, target: str, stamp_s: float = NEWEST) -> Matrix | None:
        """The frame in another; none as for `in_base`."""
        frame, target = frame.lstrip("/"), target.lstrip("/")
        if frame == target:
            return np.eye(4)
        with self._lock:
            manager = self._managed()
            try:
                return cast(Matrix, manager.get_transform_at_time(frame, target, stamp_s))
            except (KeyError, UnknownMomentError):
                return None

    def _track(self, parent: str, child: str) -> TransformTrack | None:
        parent, child = parent.lstrip("/"), child.lstrip("/")
        if not (parent and child):
            raise ValueError("a frame has no name")
        if parent == child:
            raise ValueError(f"the frame {child} is given in itself")
        known = self._tracks.get(child)
        if known is not None and known[0] == parent:
            return known[1]
        if known is None and len(self._tracks) >= FRAMES_MAX:
            return None
        track = TransformTrack()
        self._tracks[child] = parent, track
        self._manager = None
        return track

    def _managed(self) -> TemporalTransformManager:
        """Made anew only when a frame has come or moved to another parent."""
        if self._manager is None:
            self._manager = TemporalTransformManager(check=True)
            for child, (parent, track) in self._tracks.items():
                self._manager.add_transform(child, parent, track)
        return self._manager


class PoseBuffer:
    """base_link in map at any recent moment: odometry (fast, drifting) composed with map->odom (slow, correcting).

    `map->odom` comes from TF, or from a localiser's pose (`add_localisation`) where TF is silent. Any thread.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._odom_to_base = TransformTrack()
        self._map_to_odom = TransformTrack(math.inf)
        self._corrected_s: float | None = None
        self._has_tf = False

    def add_odometry(self, stamp_s: float, pose: Pose2D) -> None:
        with self._lock:
            self._odom_to_base.add(stamp_s, upright(pose))

    def add_map_to_odom(self, stamp_s: float, pose: Pose2D, *, received_s: float) -> None:
        with self._lock:
            if not self._has_tf:
                self._map_to_odom = TransformTrack(math.inf)
                self._has_tf = True
            self._correct(stamp_s, upright(pose))
            self._corrected_s = received_s

    def still_localised(self, received_s: float) -> None:
        """The localiser has said the same again, as one does whose robot stands."""
        if self._has_tf:
            self._corrected_s = received_s

    def add_localisation(self, stamp_s: float, pose: Pose2D, *, received_s: float) -> None:
        """A localiser's base_link in map; says where odom must be. Ignored once TF says it itself."""
        with self._lock:
            if self._has_tf:
                return
            odometry = self._odom_to_base.at(stamp_s, extrapolation_s=1.0)
            if odometry is None:
                odometry = self._odom_to_base.at(NEWEST)
            if odometry is not None:
                self._map_to_odom.add(stamp_s, upright(compose(pose, inverse(planar(odometry)))))
                self._corrected_s = received_s

    def _correct(self, stamp_s: float, correction: Matrix) -> None:
        """AMCL dates its correction a second ahead, that it may be used until then. It is of no later a time than the
        newest odometry, which it was made from."""
        track = self._map_to_odom
        of_s = min(stamp_s, self._odom_to_base.newest_s)
        if of_s == -math.inf:
            track.fix(correction)
        elif of_s == track.newest_s:
            track.renew(correction)
        else:
            track.add(of_s, correction)

    def age_s(self, now_s: float) -> float | None:
        """Seconds since the localiser last spoke; none while not localised."""
        corrected_s = self._corrected_s
        return max(0.0, now_s - corrected_s) if corrected_s is not None else None

    def newest(self) -> Pose2D | None:
        """base_link in map by the newest odometry; none while not localised."""
        return self._at(NEWEST)

    def at(self, stamp_s: float) -> Pose2D | None:
        """base_link in map at `stamp_s` (the robot's clock); none when that is not known."""
        return self._at(stamp_s)

    def _at(self, stamp_s: float) -> Pose2D | None:
        with self._lock:
            recent = stamp_s >= self._map_to_odom.newest_s - RECENT_S
            odometry = self._odom_to_base.at(stamp_s)
            correction = self._map_to_odom.at(NEWEST if recent else stamp_s)
        return planar(correction @ odometry) if odometry is not None and correction is not None else None
