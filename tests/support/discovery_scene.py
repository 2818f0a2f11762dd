"""`python -m support.discovery_scene FOLDER`: the bridge finds the toy robot, drives it and gives it a goal, or fails.

A process of its own: Fast DDS keeps ROS_DISCOVERY_SERVER for the life of the process that has once read it.
"""

import asyncio
import sys
from pathlib import Path

from mesh.dds import use_mesh_profile
from support.bridge_behaviour import running
from support.ros_robot import RosToyRobot
from support.toy_robot import ToyRobot
from support.waiting import until


async def play(folder: Path) -> None:
    toy = ToyRobot()
    robot = RosToyRobot(toy)
    robot.open()
    try:
        async with running(folder, toy, None, nav2_active_wait_s=30.0) as rig:  # ready: every topic flows
            assert (await rig.velocity(duration_s=2.0)).json()["accepted"]
            await until(lambda: toy.has_driven)
            assert (await rig.goal(clear_costmaps=False)).json()["status"] == "EXECUTING"
    finally:
        robot.close()


if __name__ == "__main__":
    use_mesh_profile()
    asyncio.run(play(Path(sys.argv[1])))
