"""The map."""

import math

from nav_msgs.msg import OccupancyGrid

from robot_bridge.navigation import maps
from robot_bridge.sensing.sensor_readings import Grid
from robot_bridge.sensing.transforms import matrix, planar

LEVEL_COSINE = math.cos(math.radians(2.0))
"""Of the tilt that an origin may have by rounding."""


def grid(message: OccupancyGrid) -> Grid:
    info = message.info
    p, q = info.origin.position, info.origin.orientation
    try:
        origin = matrix((p.x, p.y, p.z), (q.x, q.y, q.z, q.w))
    except ValueError as error:
        raise ValueError("the map's origin is not a pose: its quaternion is zero or no number") from error
    if origin[2, 2] < LEVEL_COSINE:
        raise ValueError("the map's origin is tilted or upside down: only a map on the level floor can be read")
    return maps.understood(message.data, info.width, info.height, float(info.resolution), planar(origin))
