"""Robots differ in names, types and namespaces: each is a setting, and with the right ones it is the same robot."""

from pathlib import Path

import pytest

from contracts.topics import ROBOT_STATE
from robot_bridge.settings import Channel, RosSettings, Settings
from support.bridge_behaviour import running
from support.ros_robot import RosToyRobot
from support.toy_robot import ToyRobot
from support.waiting import until

pytestmark = pytest.mark.filterwarnings("ignore:failed to send response:RuntimeWarning")


async def test_a_namespaced_robot_with_plain_twists_and_a_laser_of_another_name_is_driven(
    tmp_path: Path, ros_domain: int
) -> None:
    ros = RosSettings(
        namespace="robot1",
        scan=Channel(name="lidar/scan", reliability="best_effort", depth=1),
        cmd_vel_type="Twist",
        cmd_vel_nav_type="Twist",
    )
    toy = ToyRobot()
    robot = RosToyRobot(toy, namespace="robot1", stamped=False, scan="lidar/scan")
    robot.open()
    try:
        async with running(tmp_path, toy, None, ros=ros, nav2_active_wait_s=30.0) as rig:
            assert (await rig.velocity(duration_s=1.0)).json()["accepted"]
            await until(lambda: toy.linear_x == 0.2, timeout_s=30.0)
            goal = (await rig.goal(clear_costmaps=False)).json()
            assert goal["status"] == "EXECUTING"
            await until(lambda: rig.bus.of(ROBOT_STATE)[-1].commanded_by == "cmd_vel_nav", timeout_s=30.0)
            assert (await rig.post("/celebrate")).json()["end"] == "completed"
            await until(lambda: len(toy.notes) == 6, timeout_s=30.0)
    finally:
        robot.close()


def test_every_name_type_and_quality_can_be_set_from_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROBOT_BRIDGE_ROS__NAMESPACE", "robot1")
    monkeypatch.setenv("ROBOT_BRIDGE_ROS__SCAN__NAME", "lidar/scan")
    monkeypatch.setenv("ROBOT_BRIDGE_ROS__MAP__DURABILITY", "volatile")
    monkeypatch.setenv("ROBOT_BRIDGE_ROS__CMD_VEL_TYPE", "Twist")
    monkeypatch.setenv("ROBOT_BRIDGE_ROS__CMD_VEL_UNSTAMPED__NAME", "cmd_vel_unstamped")
    monkeypatch.setenv("ROBOT_BRIDGE_DOCK_POSE", '{"x": 1.0, "y": 2.0, "yaw": 0.0}')
    settings = Settings()
    assert (settings.ros.namespace, settings.ros.scan.name) == ("robot1", "lidar/scan")
    assert settings.ros.tf == RosSettings().tf
    assert settings.ros.map == Channel(name="map", reliability="reliable", durability="volatile", depth=1)
    assert settings.ros.cmd_vel_unstamped == Channel(name="cmd_vel_unstamped")
    assert settings.dock_pose is not None
