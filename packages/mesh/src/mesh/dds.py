"""The Fast DDS profile that the simulated robot and robot_bridge share."""

import os
from pathlib import Path

PROFILE = Path(__file__).with_name("fastdds.xml")
VARIABLE = "FASTRTPS_DEFAULT_PROFILES_FILE"


def use_mesh_profile() -> None:
    """Points Fast DDS at the mesh's profile, before ROS is initialised, unless the user named one of their own."""
    os.environ.setdefault(VARIABLE, str(PROFILE))
