"""One look at every sensor at one moment (requirement C5): immutable; what is stale is named and has no value."""

import math
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from contracts.geometry import Pose2D
from contracts.motion import Hazard
from contracts.robot import Battery, SensorState, SensorStatus
from mesh.latest_value import LatestValue, Reading
from robot_bridge.sensing.reception import Reception
from robot_bridge.sensing.sensor_readings import (
    ColourImage,
    DepthImage,
    DockView,
    Grid,
    Intrinsics,
    Odometry,
    Scan,
    SensorReadings,
)


class AgeLimits(BaseModel):
    """What is older is stale."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    scan_age_s_max: float = Field(default=0.5, gt=0.0, description="with an older scan the robot does not drive")
    odometry_age_s_max: float = Field(default=0.5, gt=0.0, description="with older odometry the robot does not drive")
    image_age_s_max: float = Field(default=1.5, gt=0.0, description="an older picture or depth picture is stale")
    pose_age_s_max: float = Field(default=5.0, gt=0.0, description="an older pose in map is stale")
    hazard_hold_s: float = Field(default=1.0, gt=0.0, description="a hazard counts so long after it was told last")


@dataclass(frozen=True, slots=True)
class Snapshot:
    """A value is none where its sensor never spoke or has grown stale; `sensors` says which, and how old."""

    taken_s: float
    sensors: dict[str, SensorStatus]
    scan: Scan | None
    odometry: Odometry | None
    pose: Pose2D | None
    map: Grid | None
    battery: Battery | None
    dock: DockView | None
    hazards: frozenset[Hazard]

    @property
    def stale(self) -> tuple[str, ...]:
        return tuple(name for name, status in self.sensors.items() if not status.valid)


def take_snapshot(senses: SensorReadings, ages: AgeLimits, now_s: float) -> Snapshot:
    """Each mailbox is read once, so that a value and its age belong together."""
    scan, odometry, battery = senses.scan.newest, senses.odometry.newest, senses.battery.newest
    dock, grid, hazards = senses.dock.newest, senses.map.newest, senses.hazards.newest
    pose, pose_age_s = senses.poses.newest(), senses.poses.age_s(now_s)

    def status(name: str, reading: Reading[Any] | None, age_s_max: float = math.inf) -> SensorStatus:
        return judge(senses.reception, name, reading.age_s(now_s) if reading is not None else None, age_s_max)

    sensors = {
        "scan": status("scan", scan, ages.scan_age_s_max),
        "odom": status("odom", odometry, ages.odometry_age_s_max),
        "rgb": status("rgb", senses.rgb.newest, ages.image_age_s_max),
        "rgb_info": camera_info(senses.rgb, senses.rgb_intrinsics, status("rgb_info", senses.rgb_intrinsics.newest)),
        "depth": status("depth", senses.depth.newest, ages.image_age_s_max),
        "depth_info": camera_info(
            senses.depth, senses.depth_intrinsics, status("depth_info", senses.depth_intrinsics.newest)
        ),
        "pose": judge(senses.reception, "pose", pose_age_s if pose is not None else None, ages.pose_age_s_max),
        "map": status("map", grid),
    }
    speaks, offered = sensors["odom"].valid, bool(senses.hazards_offered.value)
    sensors |= {
        "battery": changing(status("battery", battery), base_speaks=speaks),
        "dock": changing(status("dock", dock), base_speaks=speaks),
        "hazards": changing(status("hazards", hazards), base_speaks=speaks, offered=offered),
    }
    return Snapshot(
        taken_s=now_s,
        sensors=sensors,
        scan=scan.value if scan is not None and sensors["scan"].valid else None,
        odometry=odometry.value if odometry is not None and sensors["odom"].valid else None,
        pose=pose if sensors["pose"].valid else None,
        map=grid.value if grid is not None else None,
        battery=charge(senses, battery.value) if battery is not None and sensors["battery"].valid else None,
        dock=dock.value if dock is not None and sensors["dock"].valid else None,
        hazards=senses.hazards.active(now_s, ages.hazard_hold_s),
    )


def charge(senses: SensorReadings, battery: Battery) -> Battery:
    """A battery that does not say whether it is charged is charged on the dock."""
    dock = senses.dock.value
    if senses.charging_told.value is False and dock is not None and dock.is_docked:
        return battery.model_copy(update={"charging": True})
    return battery


def changing(told: SensorStatus, *, base_speaks: bool, offered: bool = False) -> SensorStatus:
    """Told on change only: the last word holds as long as the base speaks at all."""
    if base_speaks and offered and told.state is SensorState.NEVER:
        return told.model_copy(update={"state": SensorState.FRESH})
    if not base_speaks and told.valid:
        return told.model_copy(update={"state": SensorState.STALE})
    return told


def judge(reception: Reception, name: str, age_s: float | None, age_s_max: float) -> SensorStatus:
    """What is fresh stays fresh until it is old, also where newer messages of it are not understood."""
    refused, note = reception.refused(name), reception.note(name)
    if age_s is not None and age_s <= age_s_max:
        detail = f"a newer one was not understood: {refused.reason}" if refused is not None else note
        return SensorStatus(state=SensorState.FRESH, age_s=age_s, detail=detail)
    if refused is not None:
        return SensorStatus(state=SensorState.NOT_UNDERSTOOD, age_s=age_s, detail=refused.reason)
    return SensorStatus(state=SensorState.NEVER if age_s is None else SensorState.STALE, age_s=age_s)


def camera_info(
    pictures: LatestValue[ColourImage] | LatestValue[DepthImage], infos: LatestValue[Intrinsics], status: SensorStatus
) -> SensorStatus:
    """A camera_info of another cut than the pictures makes no sense with them."""
    picture, info = pictures.value, infos.value
    if picture is None or info is None or not status.valid:
        return status
    why = info.why_not_of(*picture.size_px)
    return SensorStatus(state=SensorState.NOT_UNDERSTOOD, age_s=status.age_s, detail=why) if why else status
