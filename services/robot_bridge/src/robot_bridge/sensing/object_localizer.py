"""From a box in the picture to metres and places, with whatever the senses hold at the time."""

import asyncio
from dataclasses import dataclass

import numpy as np

from contracts.robot import BoxQuery, DepthReply, LocalizeReply, Sighting
from contracts.vision import ObjectSpotted
from mesh.clock import Clock
from mesh.errors import UnavailableError, UnprocessableError
from robot_bridge.sensing.depth import Measured, core, depths_in_box, localise, measure, scaled_box
from robot_bridge.sensing.sensor_readings import DepthImage, Intrinsics, SensorReadings
from robot_bridge.sensing.transforms import Matrix, compose, in_map, inverse, upright


@dataclass(frozen=True, slots=True)
class ObjectLocalizer:
    """Depth and place of boxes."""

    senses: SensorReadings
    clock: Clock
    match_s_max: float
    image_age_s_max: float

    async def depth(self, query: BoxQuery) -> DepthReply:
        colour, box = self._camera(query)
        measured, image = await self._measure(query, colour, box)
        if image is None:
            return DepthReply(distance_m=None, reason=measured.reason)
        age_s = abs(image.stamp_s - query.stamp_s) if query.stamp_s is not None else self._depth_age_s()
        return DepthReply(
            distance_m=measured.distance_m,
            spread_m=measured.spread_m,
            samples=measured.samples,
            holes=measured.holes,
            age_s=age_s,
            reason=measured.reason,
        )

    async def localize(self, query: BoxQuery) -> LocalizeReply:
        colour, box = self._camera(query)
        measured, image = await self._measure(query, colour, box)
        mount = self.senses.frames.in_base(colour.frame_id)
        if mount is None:
            raise UnavailableError("tf", f"no transform leads from base_link to {colour.frame_id}")
        place = localise(box, measured.distance_m, colour, mount)
        stamp_s = query.stamp_s if query.stamp_s is not None else image.stamp_s if image is not None else None
        robot = self.senses.poses.at(stamp_s) if stamp_s is not None else self.senses.poses.newest()
        reason = measured.reason
        if place.base_point is not None and robot is None:
            reason = "the robot's pose at that time is not known"
        return LocalizeReply(
            distance_m=place.distance_m,
            bearing_rad=place.bearing_rad,
            base_point=place.base_point,
            map_point=in_map(robot, place.base_point) if robot is not None and place.base_point is not None else None,
            reason=reason,
        )

    async def sighting(self, spotted: ObjectSpotted) -> Sighting:
        """How far, and where, what was spotted is; raises nothing: what cannot be measured has a reason."""
        query = BoxQuery(
            bbox_xyxy=spotted.detection.bbox_xyxy,
            image_width_px=spotted.image_width_px,
            image_height_px=spotted.image_height_px,
            stamp_s=spotted.stamp_s,
        )
        try:
            found = await self.localize(query)
        except (UnavailableError, UnprocessableError) as error:
            return Sighting(stamp_s=spotted.stamp_s, label=spotted.target.label, reason=error.detail)
        return Sighting(
            stamp_s=spotted.stamp_s,
            label=spotted.target.label,
            distance_m=found.distance_m,
            bearing_rad=found.bearing_rad,
            map_point=found.map_point,
            reason=found.reason,
        )

    def _camera(self, query: BoxQuery) -> tuple[Intrinsics, tuple[float, float, float, float]]:
        x_min, y_min, x_max, y_max = query.bbox_xyxy
        if not (x_max > x_min and y_max > y_min):
            raise UnprocessableError("the box has no area (x_min, y_min, x_max, y_max in pixels)")
        if x_max <= 0 or y_max <= 0 or x_min >= query.image_width_px or y_min >= query.image_height_px:
            raise UnprocessableError("the box lies outside the picture")
        colour = self.senses.rgb_intrinsics.value
        if colour is None:
            why = self.senses.reception.why_none("rgb_info", "no camera_info has been received")
            raise UnavailableError("rgb_info", why)
        size = (query.image_width_px, query.image_height_px)
        if why := colour.why_not_of(*size):
            picture = self.senses.rgb.value
            if picture is not None and not colour.why_not_of(*picture.size_px):
                raise UnprocessableError(why)  # the camera is well: it is not its picture that was asked about
            raise UnavailableError("rgb_info", why)
        return colour, scaled_box(query.bbox_xyxy, size, (colour.width_px, colour.height_px))

    async def _measure(
        self, query: BoxQuery, colour: Intrinsics, box: tuple[float, float, float, float]
    ) -> tuple[Measured, DepthImage | None]:
        image = self.senses.depth_history.nearest(query.stamp_s)
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
        if query.stamp_s is None and age_s > self.image_age_s_max:
            why = reception.why_none("depth", f"the newest depth image is {age_s:.1f} s old")
            return Measured(None, None, 0, why), None
        if query.stamp_s is not None and abs(image.stamp_s - query.stamp_s) > self.match_s_max:
            apart_s = abs(image.stamp_s - query.stamp_s)
            return Measured(None, None, 0, f"the nearest depth image is {apart_s:.1f} s away from the picture"), None
        height_px, width_px = image.depth_m.shape
        camera = camera.scaled_to(width_px, height_px)
        moved = self._registration(camera.frame_id, image.stamp_s, colour.frame_id, query.stamp_s)
        return await asyncio.to_thread(_near, image, core(box), colour, camera, moved), image

    def _registration(
        self, depth_frame: str, depth_s: float, colour_frame: str, colour_s: float | None
    ) -> Matrix | None:
        """The depth camera, when it looked, in the colour camera, when the picture was taken; none = the same place.

        The two pictures are up to `match_s_max` apart, in which a turning robot has turned.
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


def _near(
    image: DepthImage,
    box: tuple[float, float, float, float],
    colour: Intrinsics,
    camera: Intrinsics,
    moved: Matrix | None,
) -> Measured:
    return measure(depths_in_box(image.depth_m, box, colour, camera, moved))
