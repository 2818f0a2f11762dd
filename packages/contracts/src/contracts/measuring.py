"""How far away, and where, the things in a picture are: one measurement a box."""

from enum import StrEnum

from pydantic import Field

from contracts.base import BboxXyxy, ImageSidePx, Message, SigmaM
from contracts.geometry import Point3D

TEXT_MAX = 500


class NotMeasured(StrEnum):
    """Why a box has no distance, or no place in map."""

    NO_AREA = "no_area"
    """The box is empty."""
    OUTSIDE_PICTURE = "outside_picture"
    """The box lies outside the picture."""
    NO_DEPTH_IMAGE = "no_depth_image"
    """No depth image was taken near the picture's time."""
    NO_DEPTH = "no_depth"
    """Too little of the box has a depth, or no depth is shared by enough of it."""
    NO_POSE = "no_pose"
    """The distance is known; the robot's pose in map at that time is not."""
    IMPLAUSIBLE = "implausible"
    """The depth camera cannot measure such a distance."""
    NOT_ANSWERED = "not_answered"
    """Nobody measured: robot_bridge was away, too slow, or had no camera to measure with."""


class Measurement(Message):
    """What the depth camera says of one box. `sigma_m` is the standard deviation of `distance_m` and `depth_m`."""

    distance_m: float | None = Field(
        default=None, description="from the camera to the near surface, horizontal; none = not measured"
    )
    depth_m: float | None = Field(default=None, description="the same along the optical axis")
    sigma_m: SigmaM | None = Field(default=None, description="grows with the distance")
    bearing_rad: float | None = Field(
        default=None, description="of the box centre from the robot's x axis, counter-clockwise positive"
    )
    base_point: Point3D | None = Field(default=None, description="in base_link at the time of the picture")
    map_point: Point3D | None = Field(default=None, description="in map")
    cause: NotMeasured | None = Field(default=None, description="why there is no distance, or no place in map")
    text: str = Field(default="", max_length=TEXT_MAX, description="the cause in words, for a person")

    @property
    def answered(self) -> bool:
        """False where nobody measured: that says nothing about the box."""
        return self.cause is not NotMeasured.NOT_ANSWERED


def not_measured(cause: NotMeasured, text: str) -> Measurement:
    """`text` is cut where it is too long: it may be another program's."""
    return Measurement(cause=cause, text=text[:TEXT_MAX])


class LocalizeRequest(Message):
    """Boxes in the colour picture taken at `stamp_s`; without a stamp the newest depth image is used."""

    boxes_xyxy: tuple[BboxXyxy, ...] = Field(max_length=300)
    image_width_px: ImageSidePx
    image_height_px: ImageSidePx
    stamp_s: float | None = None


class LocalizeReply(Message):
    """One measurement a box, in the order sent."""

    measurements: tuple[Measurement, ...] = Field(max_length=300)
