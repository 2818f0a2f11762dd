"""From a box in the picture to metres and places, with whatever the senses hold at the time."""

import asyncio
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydantic import Field, ValidationError

from contracts.base import BboxXyxy
from contracts.description import CameraModel, DepthNoise
from contracts.geometry import Point3D, Pose2D
from contracts.measuring import LocalizeReply, LocalizeRequest, Measurement, NotMeasured, not_measured
from contracts.robot import BoxQuery, DepthReply
from geometry.poses import compose, inverse
from mesh.clock import Clock
from mesh.errors import UnavailableError, UnprocessableError
from robot_bridge.sensing.depth import Box, Measured, core, depths_in_box, localise, measure, scaled_box
from robot_bridge.sensing.sensor_readings import DepthImage, Intrinsics, SensorReadings
from robot_bridge.sensing.snapshot import AgeLimits
from robot_bridge.sensing.transforms import Matrix, in_map, upright


class LocalizerLimits(AgeLimits):
    depth_match_s_max: float = Field(default=0.5, gt=0.0, description="between a picture and the depth measured in it")
    depth_noise: DepthNoise = DepthNoise(at_1m_m=0.012, exponent=3.461)
    """Stereo: 1.2 cm at 1.0 m, 28.6 cm at 2.5 m (requirement A9)."""


@dataclass(frozen=True, slots=True)
class ObjectLocalizer:
    """Depth and place of boxes."""

    senses: SensorReadings
    clock: Clock
    limits: LocalizerLimits

    async def depth(self, query: BoxQuery) -> DepthReply:
        size_px = (query.image_width_px, query.image_height_px)
        if refused := _refused(query.bbox_xyxy, size_px):
            raise UnprocessableError(refused.text)
        colour = self._colour(size_px)
        view = self._depth_view(query.stamp_s, colour)
        if isinstance(view, str):
            return DepthReply(distance_m=None, reason=view)
        measured = await asyncio.to_thread(view.measured, _scaled(query.bbox_xyxy, size_px, colour))
        age_s = abs(view.image.stamp_s - query.stamp_s) if query.stamp_s is not None else self._depth_age_s()
        return DepthReply(
            distance_m=measured.distance_m,
            spread_m=measured.spread_m,
            samples=measured.samples,
            holes=measured.holes,
            age_s=age_s,
            reason=measured.reason,
        )

    async def localize(self, request: LocalizeRequest) -> LocalizeReply:
        """One measurement a box. Raises `UnavailableError` where no box at all can be measured."""
        size_px = (request.image_width_px, request.image_height_px)
        colour = self._colour(size_px)
        view = self._depth_view(request.stamp_s, colour)
        mount = self._mount(colour)
        stamp_s = request.stamp_s if request.stamp_s is not None or isinstance(view, str) else view.image.stamp_s
        robot = self.senses.poses.at(stamp_s) if stamp_s is not None else self.senses.poses.newest()

        measured = await asyncio.to_thread(measurements, request.boxes_xyxy, size_px, colour, mount, view, robot)
        return LocalizeReply(measurements=measured)

    def camera(self) -> CameraModel:
        """The colour camera on the robot. Raises `UnavailableError` where it is not known whole."""
        info = self.senses.rgb_intrinsics.value
        if info is None:
            raise UnavailableError("rgb_info", self._why_no_info())
        x, y, z = (float(one) for one in self._mount(info)[:3, 3])
        try:
            return CameraModel(
                width_px=info.width_px, height_px=info.height_px, fx=info.fx, fy=info.fy, cx=info.cx, cy=info.cy,
                position_in_base=Point3D(x=x, y=y, z=z),
            )  # fmt: skip
        except ValidationError as error:
            raise UnavailableError("rgb_info", f"there is no such camera: {error.errors()[0]['msg']}") from error

    def _mount(self, camera: Intrinsics) -> Matrix:
        mount = self.senses.frames.in_base(camera.frame_id)
        if mount is None:
            raise UnavailableError("tf", f"no transform leads from base_link to {camera.frame_id}")
        return mount

    def _why_no_info(self) -> str:
        return self.senses.reception.why_none("rgb_info", "no camera_info has been received")

    def _colour(self, size_px: tuple[int, int]) -> Intrinsics:
        """Of the colour camera; raises where it is not known, or where its picture has another shape than `size_px`."""
        colour = self.senses.rgb_intrinsics.value
        if colour is None:
            raise UnavailableError("rgb_info", self._why_no_info())
        if why := colour.why_not_of(*size_px):
            picture = self.senses.rgb.value
            if picture is not None and not colour.why_not_of(*picture.size_px):
                raise UnprocessableError(why)  # the camera is well: it is not its picture that was asked about
            raise UnavailableError("rgb_info", why)
        return colour

    def _depth_view(self, stamp_s: float | None, colour: Intrinsics) -> "DepthView | str":
        """The depth image of that time as the colour camera sees it, or why there is none."""
        image = self.senses.depth_history.nearest(stamp_s)
        camera = self.senses.depth_intrinsics.value
        age_s = self._depth_age_s()
        reception = self.senses.reception
        if camera is None:
            why = reception.why_none("depth_info", "no camera_info of the depth camera has been received")
            raise UnavailableError("depth_info", why)
        if image is None or age_s is None:
            raise UnavailableError("depth", reception.why_none("depth", "no depth image has been received"))
        if why := camera.why_not_of(*image.size_px):
            raise UnavailableError("depth_info", why)
        if stamp_s is None and age_s > self.limits.image_age_s_max:
            return reception.why_none("depth", f"the newest depth image is {age_s:.1f} s old")
        if stamp_s is not None and abs(image.stamp_s - stamp_s) > self.limits.depth_match_s_max:
            return f"the nearest depth image is {abs(image.stamp_s - stamp_s):.1f} s away from the picture"
        height_px, width_px = image.depth_m.shape
        camera = camera.scaled_to(width_px, height_px)
        moved = self._registration(camera.frame_id, image.stamp_s, colour.frame_id, stamp_s)
        return DepthView(image, colour, camera, moved, self.limits.depth_noise)

    def _registration(
        self, depth_frame: str, depth_s: float, colour_frame: str, colour_s: float | None
    ) -> Matrix | None:
        """The depth camera, when it looked, in the colour camera, when the picture was taken; none = the same place.

        The two pictures are up to `depth_match_s_max` apart, in which a turning robot has turned.
        """
        frames, poses = self.senses.frames, self.senses.poses
        depth_mount, colour_mount = frames.in_base(depth_frame), frames.in_base(colour_frame)
        then = poses.at(depth_s) if colour_s is not None else None
        now = poses.at(colour_s) if colour_s is not None else None
        turned = upright(compose(inverse(now), then)) if now is not None and then is not None else np.eye(4)
        if depth_frame == colour_frame:
            mount = colour_mount if colour_mount is not None else np.eye(4)
            return None if np.allclose(turned, np.eye(4), atol=1e-6) else np.linalg.inv(mount) @ turned @ mount
        if depth_mount is None or colour_mount is None:
            return None
        return np.linalg.inv(colour_mount) @ turned @ depth_mount

    def _depth_age_s(self) -> float | None:
        return self.senses.depth.age_s(self.clock.now_s())


@dataclass(frozen=True, slots=True)
class DepthView:
    """A depth image and how it lies in the colour picture."""

    image: DepthImage
    colour: Intrinsics
    camera: Intrinsics
    moved: Matrix | None
    noise: DepthNoise

    def measured(self, box: Box) -> Measured:
        return measure(depths_in_box(self.image.depth_m, core(box), self.colour, self.camera, self.moved), self.noise)


def measurements(
    boxes: Sequence[BboxXyxy],
    size_px: tuple[int, int],
    colour: Intrinsics,
    mount: Matrix,
    view: DepthView | str,
    robot: Pose2D | None,
) -> tuple[Measurement, ...]:
    """One a box, in the order given. Pure.

    `size_px`: width and height of the picture that the boxes are in; `mount`: the colour camera in base_link; `view`:
    or why there is no depth; `robot`: in map when the picture was taken, none = not known.
    """
    return tuple(
        _refused(box, size_px) or _measurement(_scaled(box, size_px, colour), colour, mount, view, robot)
        for box in boxes
    )


def _refused(box: BboxXyxy, size_px: tuple[int, int]) -> Measurement | None:
    x_min, y_min, x_max, y_max = box
    if not (x_max > x_min and y_max > y_min):
        return not_measured(NotMeasured.NO_AREA, "the box has no area (x_min, y_min, x_max, y_max in pixels)")
    if x_max <= 0 or y_max <= 0 or x_min >= size_px[0] or y_min >= size_px[1]:
        return not_measured(NotMeasured.OUTSIDE_PICTURE, "the box lies outside the picture")
    return None


def _scaled(box: BboxXyxy, size_px: tuple[int, int], colour: Intrinsics) -> Box:
    return scaled_box(box, size_px, (colour.width_px, colour.height_px))


def _measurement(
    box: Box, colour: Intrinsics, mount: Matrix, view: DepthView | str, robot: Pose2D | None
) -> Measurement:
    measured = Measured(None, None, 0, view) if isinstance(view, str) else view.measured(box)
    depth_m = measured.distance_m
    place = localise(box, depth_m, colour, mount)
    cause, text = None, measured.reason
    if depth_m is None:
        cause = NotMeasured.NO_DEPTH_IMAGE if isinstance(view, str) else NotMeasured.NO_DEPTH
    elif robot is None:
        cause, text = NotMeasured.NO_POSE, "the robot's pose at that time is not known"
    return Measurement(
        distance_m=place.distance_m,
        depth_m=depth_m,
        sigma_m=view.noise.sigma_m(depth_m) if depth_m is not None and not isinstance(view, str) else None,
        bearing_rad=place.bearing_rad,
        base_point=place.base_point,
        map_point=in_map(robot, place.base_point) if robot is not None and place.base_point is not None else None,
        cause=cause,
        text=text,
    )
