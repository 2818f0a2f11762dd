"""Everything the simulated robot says and does over real DDS, from outside its process."""

import math
import time
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseWithCovarianceStamped, TwistStamped
from irobot_create_msgs.action import Dock, LedAnimation, Undock
from irobot_create_msgs.msg import (
    AudioNote,
    AudioNoteVector,
    DockStatus,
    HazardDetection,
    HazardDetectionVector,
    WheelStatus,
)
from irobot_create_msgs.srv import EStop
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from nav2_msgs.action import ComputePathToPose, NavigateToPose
from nav2_msgs.srv import ClearEntireCostmap
from nav_msgs.msg import OccupancyGrid, Odometry
from pydantic import TypeAdapter
from rclpy.action import ActionClient
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import BatteryState, CameraInfo, Image, Imu, LaserScan
from tf2_msgs.msg import TFMessage

from sim.home import Home
from support.base_behaviour import BaseBehaviour
from support.simulated_robot import Mission, SimProcess, done, wait_for

pytestmark = pytest.mark.timeout(120)

KEPT = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
SENSOR = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)

TOPICS: list[tuple[str, Any, QoSProfile, str]] = [
    ("oakd/rgb/preview/image_raw", Image, SENSOR, "oakd_rgb_camera_optical_frame"),
    ("oakd/rgb/preview/camera_info", CameraInfo, SENSOR, "oakd_rgb_camera_optical_frame"),
    ("oakd/stereo/image_raw", Image, SENSOR, "oakd_stereo_camera_optical_frame"),
    ("oakd/stereo/camera_info", CameraInfo, SENSOR, "oakd_stereo_camera_optical_frame"),
    ("scan", LaserScan, SENSOR, "rplidar_link"),
    ("odom", Odometry, SENSOR, "odom"),
    ("imu", Imu, SENSOR, "base_link"),
    ("amcl_pose", PoseWithCovarianceStamped, KEPT, "map"),
    ("map", OccupancyGrid, KEPT, "map"),
    ("battery_state", BatteryState, KEPT, "base_link"),
    ("dock_status", DockStatus, KEPT, "base_link"),
    ("wheel_status", WheelStatus, KEPT, "base_link"),
]


@pytest.mark.parametrize(("topic", "kind", "qos", "frame_id"), TOPICS, ids=[t[0] for t in TOPICS])
def test_each_topic_arrives_in_its_frame_stamped_in_the_present(
    mission: Mission, topic: str, kind: Any, qos: QoSProfile, frame_id: str
) -> None:
    mission.listen(topic, kind, qos)
    message = mission.hear(topic)
    assert message.header.frame_id == frame_id
    age_s = time.time() - message.header.stamp.sec - message.header.stamp.nanosec * 1e-9
    assert 0.0 <= age_s < 120.0


def test_pictures_have_the_size_and_encoding_of_an_oak_d(mission: Mission) -> None:
    mission.listen("oakd/rgb/preview/image_raw", Image, SENSOR)
    mission.listen("oakd/stereo/image_raw", Image, SENSOR)
    rgb, depth = mission.hear("oakd/rgb/preview/image_raw"), mission.hear("oakd/stereo/image_raw")
    assert (rgb.width, rgb.height, rgb.encoding, rgb.step) == (250, 250, "rgb8", 750)
    assert (depth.width, depth.height, depth.encoding, depth.step) == (640, 400, "16UC1", 1280)
    millimetres = np.frombuffer(bytes(depth.data), dtype="<u2")
    assert 100 < np.median(millimetres[millimetres > 0]) < 4000


def test_the_frames_chain_from_the_map_to_every_sensor(mission: Mission, sim: SimProcess) -> None:
    moving: dict[str, Any] = {}
    mission.node.create_subscription(
        TFMessage, "tf", lambda m: moving.update({t.child_frame_id: t for t in m.transforms}), QoSProfile(depth=10)
    )
    mission.listen("tf_static", TFMessage, KEPT)
    wait_for(lambda: set(moving) == {"odom", "base_link"}, "both moving frames")
    fixed = {t.child_frame_id: t for t in mission.hear("tf_static").transforms}
    assert moving["odom"].header.frame_id == "map"
    assert moving["base_link"].header.frame_id == "odom"
    ahead_s = moving["odom"].header.stamp.sec - moving["base_link"].header.stamp.sec
    assert 0 <= ahead_s <= 2  # AMCL dates its correction 1.0 s ahead
    assert set(fixed) == {"rplidar_link", "oakd_rgb_camera_optical_frame", "oakd_stereo_camera_optical_frame"}
    optical = fixed["oakd_rgb_camera_optical_frame"].transform.rotation
    assert (optical.x, optical.y, optical.z, optical.w) == (-0.5, 0.5, -0.5, 0.5)
    camera, laser = fixed["oakd_rgb_camera_optical_frame"].transform, fixed["rplidar_link"].transform
    # turtlebot4_description 2.1.1, urdf/lite/turtlebot4.urdf.xacro
    assert (camera.translation.x, camera.translation.z) == (-0.037, 0.186)
    assert (laser.translation.x, laser.translation.z) == (0.004, 0.140)
    assert 2 * math.atan2(laser.rotation.z, laser.rotation.w) == pytest.approx(math.pi / 2)


def test_a_goal_is_driven_to_when_somebody_passes_the_velocity_on(mission: Mission, sim: SimProcess) -> None:
    mission.listen("odom", Odometry, SENSOR)
    before, remaining_m = sim.truth(), []
    target = free_place_near(mission, sim, 0.8)
    mission.relaying = True
    navigate = ActionClient(mission.node, NavigateToPose, "navigate_to_pose")
    handle = mission.send_goal(navigate, goal_at(*target), lambda m: remaining_m.append(m.feedback.distance_remaining))
    result = done(handle.get_result_async(), timeout_s=90.0)
    mission.relaying = False
    assert result.status == GoalStatus.STATUS_SUCCEEDED
    after = sim.truth()
    assert math.hypot(after["pose"]["x"] - target[0], after["pose"]["y"] - target[1]) < 0.32  # 0.25 as it believes
    assert after["path_length_m"] > before["path_length_m"] + 0.3
    assert after["collisions"] == before["collisions"]
    assert len(remaining_m) > 3
    assert remaining_m[0] == 0.0  # before there is a path
    assert max(remaining_m) > 0.5 > remaining_m[-1] > 0.2


def test_the_stand_in_itself_never_reaches_the_wheels(mission: Mission, sim: SimProcess) -> None:
    drivers = {p.node_name for p in mission.node.get_publishers_info_by_topic("cmd_vel")}
    assert drivers.isdisjoint({"nav2_stand_in", "turtlebot4_sim"})
    navigate = ActionClient(mission.node, NavigateToPose, "navigate_to_pose")
    wait_for(sim.at_rest, "rest")
    before = sim.truth()
    handle = mission.send_goal(navigate, goal_at(*free_place_near(mission, sim, 0.8)))
    mission.hear_new("cmd_vel_nav")
    assert handle.accepted
    canceling = handle.cancel_goal_async()
    assert done(handle.get_result_async(), timeout_s=90.0).status == GoalStatus.STATUS_CANCELED
    assert canceling.result().goals_canceling
    assert sim.truth()["path_length_m"] == pytest.approx(before["path_length_m"], abs=0.01)


def test_cancelling_a_goal_stops_the_robot(mission: Mission, sim: SimProcess) -> None:
    mission.relaying = True
    navigate = ActionClient(mission.node, NavigateToPose, "navigate_to_pose")
    handle = mission.send_goal(navigate, goal_at(*free_place_near(mission, sim, 0.8)))
    wait_for(lambda: not sim.at_rest(), "motion")
    handle.cancel_goal_async()
    assert done(handle.get_result_async(), timeout_s=90.0).status == GoalStatus.STATUS_CANCELED
    wait_for(sim.at_rest, "rest")
    mission.relaying = False


def test_a_goal_outside_the_map_is_accepted_and_aborts_with_nav2s_code(mission: Mission) -> None:
    navigate = ActionClient(mission.node, NavigateToPose, "navigate_to_pose")
    result = mission.run_goal(navigate, goal_at(500.0, 500.0))
    assert result.status == GoalStatus.STATUS_ABORTED
    assert result.result.error_code == ComputePathToPose.Result.GOAL_OUTSIDE_MAP == 204


def test_paths_are_computed_without_moving_and_say_why_not(mission: Mission, sim: SimProcess) -> None:
    compute = ActionClient(mission.node, ComputePathToPose, "compute_path_to_pose")
    x, y = free_place_near(mission, sim, 0.8)
    good = mission.run_goal(compute, path_to(x, y))
    assert good.status == GoalStatus.STATUS_SUCCEEDED
    assert good.result.path.header.frame_id == "map"
    assert good.result.path.poses[-1].pose.position.x == pytest.approx(x)
    outside = mission.run_goal(compute, path_to(500.0, 500.0))
    assert outside.status == GoalStatus.STATUS_ABORTED
    assert (outside.result.error_code, outside.result.error_msg) == (ComputePathToPose.Result.GOAL_OUTSIDE_MAP, "")
    elsewhere = path_to(x, y)
    elsewhere.goal.header.frame_id = "base_link"
    assert mission.run_goal(compute, elsewhere).result.error_code == ComputePathToPose.Result.TF_ERROR


def test_an_inactive_navigator_rejects_goals(mission: Mission) -> None:
    navigate = ActionClient(mission.node, NavigateToPose, "navigate_to_pose")
    change(mission, Transition.TRANSITION_DEACTIVATE)
    rejected = mission.send_goal(navigate, goal_at(500.0, 500.0))
    state = mission.call(GetState, "bt_navigator/get_state", GetState.Request())
    change(mission, Transition.TRANSITION_ACTIVATE)
    assert not rejected.accepted
    assert state.current_state.label == "inactive"
    for server in ("bt_navigator", "planner_server", "controller_server"):
        assert mission.call(GetState, f"{server}/get_state", GetState.Request()).current_state.label == "active"


def test_the_costmaps_can_be_cleared(mission: Mission) -> None:
    for scope in ("global", "local"):
        name = f"{scope}_costmap/clear_entirely_{scope}_costmap"
        assert mission.call(ClearEntireCostmap, name, ClearEntireCostmap.Request()) is not None


def test_the_e_stop_holds_the_base_against_every_velocity(
    mission: Mission, sim: SimProcess, relay_process: Any
) -> None:
    mission.listen("wheel_status", WheelStatus, KEPT)
    wait_for(lambda: not sim.at_rest(), "motion")
    stopped = mission.call(EStop, "e_stop", EStop.Request(e_stop_on=True))
    assert not stopped.success  # as create3_republisher answers, whatever the base has done
    wait_for(sim.at_rest, "rest")
    assert sim.truth()["e_stop_on"]
    wait_for(lambda: not mission.newest["wheel_status"].wheels_enabled, "wheels that say so")
    wait_for(lambda: mission.node.count_publishers("cmd_vel") >= 2, "the relay's publisher")
    mission.call(EStop, "e_stop", EStop.Request(e_stop_on=False))
    wait_for(lambda: not sim.at_rest(), "motion")
    wait_for(lambda: mission.newest["wheel_status"].wheels_enabled, "wheels that say so")


def test_the_base_comes_to_rest_by_itself_when_its_driver_is_killed(sim: SimProcess, relay_process: Any) -> None:
    wait_for(lambda: abs(sim.truth()["twist"]["angular_z"]) > 0.6, "turning")
    killed_s = sim.truth()["now_s"]
    relay_process.kill()
    relay_process.wait()
    wait_for(sim.at_rest, "rest")
    assert sim.truth()["moved_at_s"] - killed_s < 0.9  # the base's own timeout, 0.5 s, and its ramp


def test_the_base_rejects_undocking_off_its_dock_and_docking_where_it_does_not_see_it(mission: Mission) -> None:
    mission.listen("dock_status", DockStatus, KEPT)
    status = mission.hear("dock_status")
    assert not status.is_docked
    assert not status.dock_visible
    assert not mission.send_goal(ActionClient(mission.node, Undock, "undock"), Undock.Goal()).accepted
    assert not mission.send_goal(ActionClient(mission.node, Dock, "dock"), Dock.Goal()).accepted


class TestSimulatedBase(BaseBehaviour):
    """Behind create3_republisher, as the toy's."""


def test_hazards_are_told_on_change_only_and_kept_for_late_listeners(mission: Mission) -> None:
    heard: list[list[int]] = []
    mission.node.create_subscription(
        HazardDetectionVector, "hazard_detection", lambda m: heard.append([d.type for d in m.detections]), KEPT
    )
    publisher = mission.node.create_publisher(TwistStamped, "cmd_vel", 10)
    backwards = TwistStamped()
    backwards.twist.linear.x = -0.15

    def drives_back_to_its_limit() -> bool:
        publisher.publish(backwards)
        return [HazardDetection.BACKUP_LIMIT] in heard

    wait_for(drives_back_to_its_limit, "the backup limit")
    wait_for(lambda: heard[-1] == [], "its end")
    assert all(now != before for before, now in pairwise(heard))
    mission.listen("hazard_detection", HazardDetectionVector, KEPT)
    assert not mission.hear("hazard_detection").detections
    mission.node.destroy_publisher(publisher)


def test_lights_and_notes_are_played(mission: Mission, sim: SimProcess) -> None:
    lights = ActionClient(mission.node, LedAnimation, "led_animation")
    goal = LedAnimation.Goal(animation_type=LedAnimation.Goal.SPIN_LIGHTS)
    goal.max_runtime.nanosec = 300_000_000
    result = mission.run_goal(lights, goal)
    assert result.status == GoalStatus.STATUS_SUCCEEDED
    assert result.result.runtime.nanosec >= 300_000_000
    publisher = mission.node.create_publisher(AudioNoteVector, "cmd_audio", 10)
    wait_for(lambda: publisher.get_subscription_count() == 1, "the base")
    note = AudioNote(frequency=440)
    note.max_runtime.nanosec = 500_000_000

    def heard() -> bool:
        """Published until heard: the base may match the publisher later than the publisher matches the base."""
        publisher.publish(AudioNoteVector(notes=[note]))
        return sim.truth()["last_audio"] == [[440, 0.5]]

    wait_for(heard, "the note")


def test_an_initial_pose_is_taken_as_the_estimate_until_the_localiser_knows_better(mission: Mission) -> None:
    believed_x: list[float] = []
    mission.node.create_subscription(
        TFMessage,
        "tf",
        lambda m: believed_x.extend(t.transform.translation.x for t in m.transforms if t.child_frame_id == "odom"),
        QoSProfile(depth=10),
    )
    publisher = mission.node.create_publisher(PoseWithCovarianceStamped, "initialpose", 10)
    wait_for(lambda: publisher.get_subscription_count() == 1, "the localiser")
    given = PoseWithCovarianceStamped()
    given.pose.pose.position.x, given.pose.pose.orientation.w = -700.0, 1.0

    def taken() -> bool:
        publisher.publish(given)
        return any(x < -500.0 for x in believed_x)

    wait_for(taken, "the new estimate")
    wait_for(lambda: abs(believed_x[-1]) < 50.0, "the localiser's own")


def test_velocities_that_are_none_are_ignored(mission: Mission, sim: SimProcess) -> None:
    publisher = mission.node.create_publisher(TwistStamped, "cmd_vel", 10)
    message = TwistStamped()
    message.twist.linear.x = math.nan
    wait_for(lambda: publisher.get_subscription_count() == 1, "the base")
    before = sim.truth()["time_s"]
    publisher.publish(message)
    wait_for(lambda: sim.truth()["time_s"] > before + 0.3, "time to pass")
    assert sim.at_rest()
    mission.node.destroy_publisher(publisher)


def test_ground_truth_keeps_real_time_and_answers_bad_questions_clearly(sim: SimProcess) -> None:
    assert sim.truth()["real_time"]["factor"] > 0.5
    assert sim.get("/score?kind=bottle&colour=red")["correct"] is False
    assert sim.status("/score?kind=unicorn") == 404
    assert sim.status("/score") == 422
    assert TypeAdapter(Home).validate_python(sim.get("/home")).seed == 3


def change(mission: Mission, transition: int) -> None:
    request = ChangeState.Request(transition=Transition(id=transition))
    assert mission.call(ChangeState, "bt_navigator/change_state", request).success


def goal_at(x: float, y: float, yaw: float = 0.0) -> NavigateToPose.Goal:
    goal = NavigateToPose.Goal()
    goal.pose.header.frame_id = "map"
    goal.pose.pose.position.x, goal.pose.pose.position.y = float(x), float(y)
    goal.pose.pose.orientation.z, goal.pose.pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return goal


def path_to(x: float, y: float) -> ComputePathToPose.Goal:
    return ComputePathToPose.Goal(goal=goal_at(x, y).pose)


def free_place_near(mission: Mission, sim: SimProcess, distance_m: float) -> tuple[float, float]:
    """A free cell about that far from the robot to which a straight free way leads."""
    mission.listen("map", OccupancyGrid, KEPT)
    grid = mission.hear("map")
    occupied = np.array(grid.data).reshape(grid.info.height, grid.info.width) != 0
    pose = sim.truth()["pose"]
    steps = np.arange(0.0, distance_m + 0.05, 0.05)
    around = [(0.0, 0.0)] + [(0.3 * math.cos(a), 0.3 * math.sin(a)) for a in np.arange(0, math.tau, 0.4)]
    for bearing in pose["yaw"] + math.pi / 2 + np.arange(0.0, math.tau, 0.2):
        x = pose["x"] + steps * math.cos(bearing)
        y = pose["y"] + steps * math.sin(bearing)
        if not any(occupied[cells(grid, x + dx, y + dy)].any() for dx, dy in around):
            return float(x[-1]), float(y[-1])
    raise AssertionError("the robot is walled in")


def cells(grid: OccupancyGrid, x: Any, y: Any) -> Any:
    origin, resolution = grid.info.origin.position, grid.info.resolution
    return ((y - origin.y) / resolution).astype(int), ((x - origin.x) / resolution).astype(int)
