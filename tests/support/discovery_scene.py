"""`python -m support.discovery_scene both|robot|bridge FOLDER`: the bridge finds the toy robot and drives it, or fails.

Processes of their own: Fast DDS keeps ROS_DISCOVERY_SERVER for the life of the process that has once read it.
"""

import asyncio
import contextlib
import sys
import threading
from collections.abc import Generator
from pathlib import Path

from mesh.dds import use_mesh_profile
from support.bridge_behaviour import running
from support.ros_robot import RosToyRobot
from support.toy_robot import START, ToyRobot
from support.waiting import until_true


@contextlib.contextmanager
def standing() -> Generator[ToyRobot]:
    toy = ToyRobot()
    robot = RosToyRobot(toy)
    robot.open()
    try:
        yield toy
    finally:
        robot.close()


async def drive(folder: Path) -> None:
    """What is checked comes from the robot over ROS, wherever it is."""
    async with running(folder, ToyRobot(), None, nav2_active_wait_s=30.0) as rig:  # ready: every topic flows

        async def has_driven() -> bool:
            pose = (await rig.state()).pose
            return pose is not None and pose.x > START.x + 0.02

        assert (await rig.velocity(duration_s=2.0)).json()["accepted"]
        await until_true(has_driven)
        assert (await rig.goal(clear_costmaps=False)).json()["status"] == "EXECUTING"


def main(part: str, folder: str) -> None:
    use_mesh_profile()
    with standing() if part != "bridge" else contextlib.nullcontext():
        if part == "robot":
            threading.Event().wait()
        asyncio.run(drive(Path(folder)))


if __name__ == "__main__":
    main(*sys.argv[1:])
