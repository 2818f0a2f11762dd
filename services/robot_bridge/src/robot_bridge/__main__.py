"""`python -m robot_bridge`: the service on its own, configured by ROBOT_BRIDGE_* variables."""

import os
import sys

import structlog

from mesh.dds import use_mesh_profile
from mesh.logging import configure_logging
from mesh.server import serve
from mesh.tracing import configure_tracing
from robot_bridge.app import create_app
from robot_bridge.settings import Settings


def go_first(nice: int) -> None:
    """Before every other process of the machine, its threads included; where that is not permitted, as it is."""
    try:
        os.setpriority(os.PRIO_PROCESS, 0, nice)
    except PermissionError:
        structlog.get_logger().info("no permission to go first (CAP_SYS_NICE, or ulimit -e)", nice=nice)


def main() -> None:
    settings = Settings.read()
    configure_logging("robot_bridge", level=settings.log_level)
    configure_tracing("robot_bridge")
    use_mesh_profile()
    sys.setswitchinterval(0.001)  # a stop request waits for the robot's thread no longer than this
    go_first(settings.nice)
    serve(create_app(settings), host=settings.host, port=settings.port)


if __name__ == "__main__":
    main()
