"""One look at every sensor at one moment (requirement C5): immutable; what is stale is named and has no value."""

from dataclasses import dataclass

from contracts.geometry import Pose2D
from contracts.motion import Hazard
from contracts.robot import Battery, SensorStatus
from robot_bridge.senses import DockView, Grid, Odometry, Scan, Senses
from robot_bridge.settings import Settings


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


def look(senses: Senses, settings: Settings, now_s: float) -> Snapshot:
    """Each mailbox is read once, so that a value and its age belong together."""
    scan, odometry, battery = senses.scan.newest, senses.odometry.newest, senses.battery.newest
    dock, grid, hazards = senses.dock.newest, senses.map.newest, senses.hazards.newest
    pose, pose_age_s = senses.poses.newest(), senses.poses.age_s(now_s)

    def status(received_s: float | None, age_s_max: float) -> SensorStatus:
        age_s = max(0.0, now_s - received_s) if received_s is not None else None
        return SensorStatus(valid=age_s is not None and age_s <= age_s_max, age_s=age_s)

    def changing(reading: "object", *, base_speaks: bool, offered: bool = False) -> SensorStatus:
        """Told on change only: the last word holds as long as the base speaks at all."""
        told = of(reading, float("inf"))
        return SensorStatus(valid=base_speaks and (told.valid or offered), age_s=told.age_s)

    def of(reading: "object", age_s_max: float) -> SensorStatus:
        return status(getattr(reading, "received_s", None), age_s_max)

    sensors = {
        "scan": of(scan, settings.scan_age_s_max),
        "odom": of(odometry, settings.odometry_age_s_max),
        "rgb": of(senses.rgb.newest, settings.image_age_s_max),
        "depth": of(senses.depth.newest, settings.image_age_s_max),
        "pose": SensorStatus(
            valid=pose is not None and pose_age_s is not None and pose_age_s <= settings.pose_age_s_max,
            age_s=pose_age_s,
        ),
        "map": of(grid, float("inf")),
    }
    speaks = sensors["odom"].valid
    sensors |= {
        "battery": changing(battery, base_speaks=speaks),
        "dock": changing(dock, base_speaks=speaks),
        "hazards": changing(hazards, base_speaks=speaks, offered=hazards_offered(senses, settings)),
    }
    return Snapshot(
        taken_s=now_s,
        sensors=sensors,
        scan=scan.value if scan is not None and sensors["scan"].valid else None,
        odometry=odometry.value if odometry is not None and sensors["odom"].valid else None,
        pose=pose if sensors["pose"].valid else None,
        map=grid.value if grid is not None else None,
        battery=battery.value if battery is not None and sensors["battery"].valid else None,
        dock=dock.value if dock is not None and sensors["dock"].valid else None,
        hazards=senses.hazards.active(now_s, settings.hazard_hold_s),
    )


def hazards_offered(senses: Senses, settings: Settings) -> bool:
    """Whether somebody would tell of a hazard if there were one."""
    unpublished = senses.unpublished.value
    return unpublished is not None and settings.ros.hazards.name not in unpublished
