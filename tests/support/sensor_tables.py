"""The tables of docs/sensors.md: a row is a field and what comes in it, and is a test."""

from collections.abc import Callable
from typing import Any

import numpy as np
from irobot_create_msgs.msg import DockStatus

from robot_bridge.sensing.sensor_readings import SensorReadings
from support import ros_messages as ros
from support.sensor_rules import INF, NAN, PAGE, Cell, Table, as_of, page, stamped, stamped_base

Change = Callable[[Any], None]


def put(path: str, value: Any) -> Change:
    """Sets a field, `a.b.c` or `a.3`, of the message."""

    def change(message: Any) -> None:
        *way, last = path.split(".")
        for name in way:
            message = getattr(message, name)
        if last.isdigit():
            message[int(last)] = value
        else:
            setattr(message, last, value)

    return change


def cells(path: str, *rows: tuple[str, Any, str]) -> tuple[Cell, ...]:
    """Of one field: case, value, what is told."""
    return tuple(Cell(path, case, told, put(path, value)) for case, value, told in rows)


def no(reason: str) -> str:
    return f"not understood: {reason}"


# the laser


def _scan(senses: SensorReadings) -> str:
    scan = senses.scan.value
    assert scan is not None
    blind = round(float(np.degrees(scan.blind[:, 1].sum())))
    return f"{len(scan.points_m)} hits, {len(scan.open_rad)} see nothing there, blind over {blind} degrees"


ALL_HIT = f"{ros.BEAMS} hits, 0 see nothing there, blind over 0 degrees"
ALL_BLIND = "0 hits, 0 see nothing there, blind over 360 degrees"
SILENT = f"{ALL_BLIND}; said: none of its {ros.BEAMS} beams says anything"
ALL_OPEN = f"0 hits, {ros.BEAMS} see nothing there, blind over 0 degrees"


def ranges(metres: float) -> list[float]:
    return [metres] * ros.BEAMS


def _backwards(message: Any) -> None:
    message.angle_min, message.angle_max = message.angle_max, message.angle_min
    message.angle_increment = -message.angle_increment


STEP = "0.0872665"
LASER = Table("sensor_msgs/LaserScan", "scan", "scan", ros.round_room, _scan, (
    *cells("ranges",
        ("right", ranges(3.0), ALL_HIT),
        ("absent (none)", [], no("it has 0 beams")),
        ("too many", [1.0] * 30_000, no("it has 30000 beams")),
        ("fewer than the angles say", [3.0] * 60,
         no(f"its angles, -3.14159 to 3.05433 rad, are not those of 60 beams {STEP} rad apart")),
        ("0", ranges(0.0), SILENT),
        ("NaN", ranges(NAN), SILENT),
        ("inf", ranges(INF), ALL_OPEN),
        ("-inf (too near, REP-117)", ranges(-INF), SILENT),
        ("negative", ranges(-1.0), SILENT),
        ("nearer than range_min", ranges(0.1), SILENT),
        ("a little beyond range_max", ranges(13.0), ALL_OPEN),
        ("far beyond range_max", ranges(65.5),
         f"{ALL_BLIND}; said: most of its ranges lie far beyond range_max, 12 m: they are not metres"),
        ("millimetres", ranges(3000.0),
         f"{ALL_BLIND}; said: most of its ranges lie far beyond range_max, 12 m: they are not metres"),
    ),
    Cell("ranges", "0", ALL_OPEN, put("ranges", ranges(0.0)), {"laser_zero_means": "nothing_there"}),
    Cell("ranges", "a post of the robot's at 0.17 m",
         "72 hits, 0 see nothing there, blind over 0 degrees; said: something inside the footprint is seen at 0 "
         "degrees, 0.17 m from the middle: if it is a part of the robot, mask it (ROBOT_BRIDGE_LASER_MASKS)",
         put("ranges.36", 0.17)),
    Cell("ranges", "the same, masked", "71 hits, 0 see nothing there, blind over 0 degrees", put("ranges.36", 0.17),
         {"laser_masks": ({"from_rad": -0.1, "to_rad": 0.1, "range_m_max": 0.2},)}),
    *cells("range_max",
        ("0 (never filled in)", 0.0, no("its range_max is 0 m")),
        ("0.2 (another unit)", 0.2, no("its range_max is 0.2 m")),
        ("1, with ranges of 3", 1.0,
         f"{ALL_BLIND}; said: most of its ranges lie far beyond range_max, 1 m: they are not metres"),
        ("12000 (millimetres)", 12_000.0, no("its range_max is 12000 m")),
        ("negative", -12.0, no("its range_max is -12 m")),
        ("NaN", NAN, no("its range_max is nan m")),
        ("inf", INF, ALL_HIT),
        ("-inf", -INF, no("its range_max is -inf m")),
    ),
    *cells("range_min",
        ("0", 0.0, ALL_HIT),
        ("150 (millimetres)", 150.0, no("its range_min is 150 m")),
        ("negative", -0.1, no("its range_min is -0.1 m")),
        ("NaN", NAN, no("its range_min is nan m")),
        ("inf", INF, no("its range_min is inf m")),
        ("-inf", -INF, no("its range_min is -inf m")),
    ),
    Cell("range_min", "not below range_max", no("its range_max, 1 m, is not beyond its range_min, 1 m"),
         lambda m: (put("range_min", 1.0)(m), put("range_max", 1.0)(m))[0]),
    *cells("angle_increment",
        ("0", 0.0, no("its angle_increment is 0 rad")),
        ("5 (degrees)", 5.0, no("its angle_increment is 5 rad")),
        ("NaN", NAN, no("its angle_increment is nan rad")),
        ("inf", INF, no("its angle_increment is inf rad")),
        ("-inf", -INF, no("its angle_increment is -inf rad")),
        ("of other angles", 0.04,
         no("its angles, -3.14159 to 3.05433 rad, are not those of 72 beams 0.04 rad apart")),
        ("more than a full turn", 0.1, no("72 beams 0.1 rad apart are more than a full turn")),
    ),
    Cell("angle_increment", "negative, as its angles", ALL_HIT, _backwards),
    *cells("angle_min",
        ("-180 (degrees)", -180.0, no("its angle_min is -180 rad")),
        ("NaN", NAN, no("its angle_min is nan rad")),
        ("inf", INF, no("its angle_min is inf rad")),
        ("-inf", -INF, no("its angle_min is -inf rad")),
    ),
    *cells("angle_max",
        ("0 (never filled in)", 0.0,
         no(f"its angles, -3.14159 to 0 rad, are not those of 72 beams {STEP} rad apart")),
        ("one step off (rounding)", 3.1415927, ALL_HIT),
        ("NaN", NAN, no(f"its angles, -3.14159 to nan rad, are not those of 72 beams {STEP} rad apart")),
        ("inf", INF, no(f"its angles, -3.14159 to inf rad, are not those of 72 beams {STEP} rad apart")),
    ),
    *cells("intensities",
        ("of another length", [1.0] * 10, no("it has 10 intensities for 72 beams")),
        ("NaN (not used)", ranges(NAN), ALL_HIT),
    ),
    *cells("scan_time",
        ("0", 0.0, ALL_HIT),
        ("negative", -0.1, no("its scan_time is -0.1 s")),
        ("100 (milliseconds)", 100.0, no("its scan_time is 100 s")),
        ("NaN", NAN, no("its scan_time is nan s")),
        ("inf", INF, no("its scan_time is inf s")),
    ),
    *cells("time_increment",
        ("0", 0.0, ALL_HIT),
        ("negative", -0.1, no("its time_increment is -0.1 s")),
        ("1.4 (milliseconds)", 1.4, no("its time_increment is 1.4 s")),
        ("NaN", NAN, no("its time_increment is nan s")),
        ("inf", INF, no("its time_increment is inf s")),
    ),
    *cells("header.frame_id",
        ("absent", "", no("no transform leads from base_link to its frame, which is unnamed")),
        ("unknown", "lidar", no("no transform leads from base_link to its frame, lidar")),
        ("with a slash", "/laser", ALL_HIT),
        ("of a laser that looks down", "optical", no("it is mounted at a slant")),
    ),
))  # fmt: skip


# the base


def _odometry(senses: SensorReadings) -> str:
    odometry = senses.odometry.value
    assert odometry is not None
    return f"at ({odometry.pose.x:g}, {odometry.pose.y:g}), {odometry.twist.linear_x:g} m/s"


RIGHT = "at (0, 0), 0 m/s"
ODOMETRY = Table("nav_msgs/Odometry", "odom", "odom", ros.still_odometry, _odometry, (
    *cells("pose.pose.position.x",
        ("right", 2.0, "at (2, 0), 0 m/s"),
        ("NaN", NAN, no("its position is (nan, 0, 0) m")),
        ("inf", INF, no("its position is (inf, 0, 0) m")),
        ("-inf", -INF, no("its position is (-inf, 0, 0) m")),
        ("on the other side of the earth", 2e7, no("its position is (2e+07, 0, 0) m")),
    ),
    *cells("pose.pose.orientation.w",
        ("0 (never filled in)", 0.0, no("its quaternion is 0 long, not 1")),
        ("not of length 1", 2.0, no("its quaternion is 2 long, not 1")),
        ("-1 (the same turn)", -1.0, RIGHT),
        ("NaN", NAN, no("its quaternion is nan long, not 1")),
        ("inf", INF, no("its quaternion is inf long, not 1")),
    ),
    Cell("pose.pose.orientation", "upside down", no("its orientation lays the robot on its side"),
         lambda m: (put("pose.pose.orientation.x", 1.0)(m), put("pose.pose.orientation.w", 0.0)(m))[0]),
    *cells("twist.twist.linear.x",
        ("200 (millimetres)", 200.0, no("its speed is 200 m/s")),
        ("NaN", NAN, no("its speed is nan m/s")),
        ("inf", INF, no("its speed is inf m/s")),
        ("-inf", -INF, no("its speed is -inf m/s")),
    ),
    *cells("twist.twist.angular.z",
        ("57 (degrees)", 57.0, no("its turn is 57 rad/s")),
        ("NaN", NAN, no("its turn is nan rad/s")),
        ("inf", INF, no("its turn is inf rad/s")),
        ("-inf", -INF, no("its turn is -inf rad/s")),
    ),
    *cells("header.frame_id",
        ("absent", "", f"{RIGHT}; said: it is in the frame (unnamed), not in odom"),
        ("another", "robot1/odom", f"{RIGHT}; said: it is in the frame robot1/odom, not in odom"),
        ("with a slash", "/odom", RIGHT),
    ),
))  # fmt: skip


def _charge(senses: SensorReadings) -> str:
    battery = senses.battery.value
    assert battery is not None
    charge = "charge not known" if battery.percentage is None else f"{battery.percentage:.0f} %"
    return f"{charge}{', charging' if battery.charging else ''}"


def unknown(why: str) -> str:
    return f"charge not known; said: its charge is not known: {why}"


PER_CENT = "it counts its charge 0 to 100, not 0 to 1: read as per cent"
BATTERY = Table("sensor_msgs/BatteryState", "battery", "battery", ros.battery, _charge, (
    *cells("percentage",
        ("right", 0.37, "37 %"),
        ("0, with a voltage", 0.0, "0 %"),
        ("-0", -0.0, "0 %"),
        ("a little above 1 (rounding)", 1.02, "100 %"),
        ("1.3", 1.3, unknown("it says 1.3, not 0 to 1")),
        ("37 (per cent)", 37.0, f"37 %; said: {PER_CENT}"),
        ("8 (per cent)", 8.0, f"8 %; said: {PER_CENT}"),
        ("100 (per cent)", 100.0, f"100 %; said: {PER_CENT}"),
        ("300", 300.0, unknown("it says 300, not 0 to 1")),
        ("-1 (some drivers' unknown)", -1.0, unknown("it says -1, not 0 to 1")),
        ("NaN (unknown, by its definition)", NAN, unknown("it says nan, not 0 to 1")),
        ("inf", INF, unknown("it says inf, not 0 to 1")),
        ("-inf", -INF, unknown("it says -inf, not 0 to 1")),
    ),
    Cell("percentage", "0 and no voltage (never filled in)", unknown("neither charge nor voltage is filled in"),
         lambda m: (put("percentage", 0.0)(m), put("voltage", 0.0)(m))[0]),
    *cells("power_supply_status",
        ("charging", 1, "80 %, charging"),
        ("another number", 77, "80 %"),
    ),
    Cell("power_supply_status", "charging, percentage NaN",
         "charge not known, charging; said: its charge is not known: it says nan, not 0 to 1",
         lambda m: (put("percentage", NAN)(m), put("power_supply_status", 1)(m))[0]),
))  # fmt: skip
DOCK = Table("irobot_create_msgs/DockStatus", "dock_status", "dock", DockStatus, lambda senses: (
    f"docked: {senses.dock.value.is_docked}, seen: {senses.dock.value.dock_visible}"  # type: ignore[union-attr]
), (
    *cells("is_docked", ("false", False, "docked: False, seen: False"), ("true", True, "docked: True, seen: False")),
    *cells("dock_visible", ("true", True, "docked: False, seen: True")),
))  # fmt: skip

# where it is


def _place(senses: SensorReadings) -> str:
    pose = senses.poses.newest()
    assert pose is not None
    return f"at ({pose.x:g}, {pose.y:g})"


def each(change: Change) -> Change:
    return lambda message: change(message.transforms[0])


def tf(path: str, *rows: tuple[str, Any, str]) -> tuple[Cell, ...]:
    return tuple(Cell(f"transforms[].{path}", case, told, each(put(path, value))) for case, value, told in rows)


KEPT = "at (0, 0); said: a newer one was not understood: "
CORRECTION = Table("tf2_msgs/TFMessage, map to odom", "tf", "pose",
    lambda: ros.correction(0.0), _place, (
    *tf("transform.translation.x",
        ("right", 2.0, "at (2, 0)"),
        ("NaN", NAN, no("its position is (nan, 0, 0) m")),
        ("inf", INF, no("its position is (inf, 0, 0) m")),
        ("-inf", -INF, no("its position is (-inf, 0, 0) m")),
        ("on the other side of the earth", 2e7, no("its position is (2e+07, 0, 0) m")),
    ),
    *tf("transform.rotation.w",
        ("0 (never filled in)", 0.0, no("its quaternion is 0 long, not 1")),
        ("NaN", NAN, no("its quaternion is nan long, not 1")),
        ("not of length 1", 0.5, no("its quaternion is 0.5 long, not 1")),
    ),
    Cell("transforms[]", "none", "never", put("transforms", [])),
))  # fmt: skip
LOCALISER = Table("geometry_msgs/PoseWithCovarianceStamped", "amcl_pose", "pose", ros.localised, _place, (
    *cells("pose.pose.position.x", ("NaN", NAN, f"{KEPT}its position is (nan, 0, 0) m")),
    *cells("pose.pose.orientation.w", ("0", 0.0, f"{KEPT}its quaternion is 0 long, not 1")),
    *cells("pose.covariance.0",
        ("NaN", NAN, f"{KEPT}its covariance is no number: the localiser has lost itself"),
        ("inf", INF, f"{KEPT}its covariance is no number: the localiser has lost itself"),
    ),
    *cells("header.frame_id",
        ("absent", "", f"{KEPT}it is in the frame (unnamed), not in map"),
        ("another", "odom", f"{KEPT}it is in the frame odom, not in map"),
    ),
))  # fmt: skip


def _map(senses: SensorReadings) -> str:
    grid = senses.map.value
    assert grid is not None
    return f"{grid.cells.shape[1]} x {grid.cells.shape[0]} cells"


MAP = Table("nav_msgs/OccupancyGrid", "map", "map", ros.room_map, _map, (
    *cells("info.width",
        ("right", 40, "40 x 30 cells"),
        ("0", 0, no("the map is empty: 0 x 30 cells")),
    ),
    *cells("info.resolution",
        ("0", 0.0, no("the map's cells are 0 m wide, not 0.001 to 1 m")),
        ("NaN", NAN, no("the map's cells are nan m wide, not 0.001 to 1 m")),
        ("50 (millimetres)", 50.0, no("the map's cells are 50 m wide, not 0.001 to 1 m")),
    ),
    *cells("info.origin.orientation.w",
        ("0 (never filled in)", 0.0, no("the map's origin is not a pose: its quaternion is zero or no number")),
        ("NaN", NAN, no("the map's origin is not a pose: its quaternion is zero or no number")),
    ),
))  # fmt: skip

# the cameras


def _seen(senses: SensorReadings) -> str:
    image = senses.rgb.value
    assert image is not None
    blue, green, red = image.pixels[24, 32]
    return f"{image.size_px[0]} x {image.size_px[1]}, ({red}, {green}, {blue})"


PLAIN = "64 x 48, (90, 90, 90)"
COLOUR = Table("sensor_msgs/Image, colour", "rgb", "rgb", ros.picture, _seen, (
    *cells("encoding",
        ("bgr8", "bgr8", PLAIN),
        ("RGB8, in capitals", "RGB8", PLAIN),
        ("8UC3 (bytes of OpenCV: BGR)", "8UC3", PLAIN),
        ("absent", "", no("cannot read an unnamed encoding as a colour picture")),
        ("unknown", "h264", no("cannot read h264 as a colour picture")),
        ("of fewer bytes than it needs", "bgra8", no("its rows are 192 bytes long, bgra8 needs 256")),
    ),
    *cells("width",
        ("0", 0, no("the picture is 0 x 48 pixels large")),
        ("100000", 100_000, no("the picture is 100000 x 48 pixels large")),
        ("more than a row holds", 65, no("its rows are 192 bytes long, bgr8 needs 195")),
    ),
    *cells("height",
        ("0", 0, no("the picture is 64 x 0 pixels large")),
        ("more rows than came", 49, no("it holds 9216 bytes, its size needs 9408")),
    ),
    *cells("step",
        ("0", 0, no("its rows are 0 bytes long, bgr8 needs 192")),
        ("more than its data", 300, no("it holds 9216 bytes, its size needs 14400")),
    ),
    *cells("data", ("absent", b"", no("it holds 0 bytes, its size needs 9216"))),
))  # fmt: skip


def _depth(senses: SensorReadings) -> str:
    image = senses.depth.value
    assert image is not None
    measured = image.depth_m[np.isfinite(image.depth_m) & (image.depth_m > 0.0)]
    return f"{np.median(measured):g} m" if measured.size else "holes only"


def metres(value: float, encoding: str = "32FC1") -> Change:
    def change(message: Any) -> None:
        other = ros.depth(value, encoding=encoding)
        message.encoding, message.step, message.data = other.encoding, other.step, other.data

    return change


def depths(*rows: tuple[str, float, str, str]) -> tuple[Cell, ...]:
    return tuple(Cell(f"data, {encoding}", case, told, metres(value, encoding)) for case, value, encoding, told in rows)


DEPTH = Table("sensor_msgs/Image, depth", "depth", "depth", ros.depth, _depth, (
    *depths(
        ("right", 1.5, "16UC1", "1.5 m"),
        ("right", 1.5, "32FC1", "1.5 m"),
        ("right", 1.5, "64FC1", "1.5 m"),
        ("0 (nothing measured)", 0.0, "16UC1", "holes only"),
        ("65535 (nothing measured)", 65.535, "16UC1", "holes only"),
        ("metres", 0.002, "16UC1", no("its depths are 0.002 m at most: they are in another unit")),
        ("NaN", NAN, "32FC1", "holes only"),
        ("inf (too far)", INF, "32FC1", "holes only"),
        ("-inf (too near)", -INF, "32FC1", "holes only"),
        ("negative", -1.5, "32FC1", "holes only"),
        ("further than any camera measures", 25.0, "32FC1", "holes only"),
        ("1500 (millimetres)", 1500.0, "32FC1", no("its depths are about 1500 m: they are millimetres, not metres")),
        ("1500 (millimetres)", 1500.0, "64FC1", no("its depths are about 1500 m: they are millimetres, not metres")),
    ),
    *cells("encoding",
        ("absent", "", no("cannot read an unnamed encoding as depth")),
        ("of colour", "bgr8", no("cannot read bgr8 as depth")),
        ("mono16 (as 16UC1)", "mono16", "1.5 m"),
        ("of more bytes than came", "32FC1", no("its rows are 128 bytes long, 32FC1 needs 256")),
    ),
))  # fmt: skip


def _camera(senses: SensorReadings) -> str:
    info = senses.rgb_intrinsics.value
    assert info is not None
    return f"{info.width_px} x {info.height_px}, focal length {info.fx:g}, centre ({info.cx:g}, {info.cy:g})"


SENSOR = "64 x 48, focal length 50, centre (32, 24)"
CAMERA_INFO = Table("sensor_msgs/CameraInfo", "rgb_info", "rgb_info", ros.camera_info, _camera, (
    *cells("k",
        ("right", [50.0, 0.0, 32.0, 0.0, 50.0, 24.0, 0.0, 0.0, 1.0], SENSOR),
        ("0 (never filled in)", [0.0] * 9, no("its K has no focal length")),
        ("NaN", [NAN] * 9, no("its K has no focal length")),
        ("of a sensor of 3840 x 2160", [2248.0, 0.0, 1908.0, 0.0, 2248.0, 1046.0, 0.0, 0.0, 1.0],
         no("its principal point (1908, 1046) lies outside of its 64 x 48 pixels")),
    ),
    *cells("k.0",
        ("negative", -50.0, no("its K has no focal length")),
        ("inf", INF, no("its K has no focal length")),
        ("1 (of a picture 1 wide)", 1.0, no("its focal length is 1 pixels, its width 64")),
        ("three times the other's", 150.0, no("its focal lengths are 150 and 50 pixels")),
    ),
    *cells("k.2", ("0", 0.0, no("its principal point (0, 24) lies outside of its 64 x 48 pixels"))),
    *cells("k.8", ("0", 0.0, no("the last number of its K is 0, not 1"))),
    *cells("width", ("0 (never filled in)", 0, no("its size is 0 x 48 pixels"))),
    *cells("height", ("100000", 100_000, no("its size is 64 x 100000 pixels"))),
    *cells("binning_x", ("0 (none)", 0, SENSOR), ("100", 100, no("it puts 100 pixels into one"))),
    Cell("binning_x, binning_y", "2", "32 x 24, focal length 25, centre (16, 12)",
         lambda m: (put("binning_x", 2)(m), put("binning_y", 2)(m))[0]),
    Cell("roi", "the middle", "32 x 24, focal length 50, centre (16, 12)", lambda m: _region(m, 16, 12, 32, 24)),
    Cell("roi", "not in the picture", no("its region of interest is not a part of the picture"),
         lambda m: _region(m, 40, 0, 32, 24)),
    *cells("header.frame_id", ("absent", "", no("it names no frame"))),
    *cells("d", ("NaN (not used)", [NAN] * 5, SENSOR)),
))  # fmt: skip


def _region(message: Any, x: int, y: int, width: int, height: int) -> None:
    roi = message.roi
    roi.x_offset, roi.y_offset, roi.width, roi.height = x, y, width, height


def _of(table: Table, sensor: str, stamps: tuple[Cell, ...]) -> Table:
    """The cells of its stamp: a table of its own, for what is shown there is the time."""
    return Table(f"{table.message}, its stamp", table.topic, table.sensor, table.healthy,
                 lambda senses: as_of(senses, sensor), stamps)  # fmt: skip


TABLES = (
    LASER, _of(LASER, "scan", stamped(old_s=0.5)),
    ODOMETRY, _of(ODOMETRY, "odom", stamped_base(old_s=0.5)),
    BATTERY, DOCK, CORRECTION, LOCALISER, MAP,
    COLOUR, _of(COLOUR, "rgb", stamped(old_s=1.5)),
    DEPTH, _of(DEPTH, "depth", stamped(old_s=1.5)),
    CAMERA_INFO,
)  # fmt: skip

if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8"), TABLES), encoding="utf-8")
