"""What Nav2's own client libraries and the ros2 command line ask for, asked in the same way: nothing may wait for ever.

The calls follow BasicNavigator (nav2_simple_commander) and ros2cli as they are on Jazzy; the code is ours.
"""

import itertools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseWithCovarianceStamped
from lifecycle_msgs.srv import GetState
from nav2_msgs.action import ComputePathToPose, NavigateToPose
from nav2_msgs.srv import ClearEntireCostmap
from nav_msgs.msg import OccupancyGrid
from rcl_interfaces.srv import GetParameters, ListParameters
from rclpy.action import ActionClient
from rclpy.qos import DurabilityPolicy, QoSProfile

from support.simulated_robot import Mission, SimProcess, done, wait_for

pytestmark = pytest.mark.timeout(120)

KEPT = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
LIFECYCLE = {
    "amcl", "map_server", "bt_navigator", "planner_server", "controller_server", "smoother_server", "behavior_server",
    "velocity_smoother", "collision_monitor",
}  # fmt: skip


@dataclass
class Client:
    """As BasicNavigator does it."""

    mission: Mission

    def wait_until_nav2_active(self, *, navigator: str = "bt_navigator", localizer: str = "amcl") -> None:
        self._wait_for_node(localizer)
        self.mission.listen("amcl_pose", PoseWithCovarianceStamped, KEPT)
        self.mission.hear("amcl_pose")
        self._wait_for_node(navigator)

    def _wait_for_node(self, name: str) -> None:
        def active() -> bool:
            state = self.mission.call(GetState, f"{name}/get_state", GetState.Request())
            return bool(state.current_state.label == "active")

        wait_for(active, name)

    def get_path(self, goal: Any) -> Any:
        planner = ActionClient(self.mission.node, ComputePathToPose, "compute_path_to_pose")
        result = self.mission.run_goal(planner, ComputePathToPose.Goal(goal=goal.pose))
        assert result.status == GoalStatus.STATUS_SUCCEEDED
        return result.result.path

    def go_to_pose(self, goal: Any, heard: list[Any]) -> Any:
        navigate = ActionClient(self.mission.node, NavigateToPose, "navigate_to_pose")
        handle = self.mission.send_goal(navigate, goal, lambda message: heard.append(message.feedback))
        assert handle.accepted
        return handle

    def clear_all_costmaps(self) -> None:
        for scope in ("local", "global"):
            name = f"{scope}_costmap/clear_entirely_{scope}_costmap"
            self.mission.call(ClearEntireCostmap, name, ClearEntireCostmap.Request())


@pytest.fixture
def client(mission: Mission, sim: SimProcess) -> Client:
    return Client(mission)


def ahead(client: Client, sim: SimProcess, metres: float, *, yaw: float | None = None) -> NavigateToPose.Goal:
    """A goal so far ahead of where the robot believes to stand (its true place is near enough)."""
    pose = sim.truth()["pose"]
    heading = pose["yaw"] if yaw is None else yaw
    goal = NavigateToPose.Goal()
    goal.pose.header.frame_id = "map"
    goal.pose.pose.position.x = pose["x"] + metres * math.cos(pose["yaw"])
    goal.pose.pose.position.y = pose["y"] + metres * math.sin(pose["yaw"])
    goal.pose.pose.orientation.z, goal.pose.pose.orientation.w = math.sin(heading / 2), math.cos(heading / 2)
    return goal


def test_waiting_until_nav2_is_active_comes_to_an_end(client: Client) -> None:
    client.wait_until_nav2_active()


def test_a_path_is_a_row_of_poses_close_together(client: Client, sim: SimProcess) -> None:
    path = client.get_path(ahead(client, sim, 0.5))
    xy = [(each.pose.position.x, each.pose.position.y) for each in path.poses]
    assert path.header.frame_id == "map"
    assert max(math.dist(a, b) for a, b in itertools.pairwise(xy)) < 0.026


def test_costmaps_are_cleared(client: Client) -> None:
    client.clear_all_costmaps()


def test_a_goal_nearer_than_the_tolerance_is_reached_without_a_move(client: Client, sim: SimProcess) -> None:
    before, heard = sim.truth(), []
    handle = client.go_to_pose(ahead(client, sim, 0.1), heard)
    result = done(handle.get_result_async())
    assert (result.status, result.result.error_code, result.result.error_msg) == (GoalStatus.STATUS_SUCCEEDED, 0, "")
    assert sim.truth()["path_length_m"] == pytest.approx(before["path_length_m"], abs=0.01)
    wait_for(lambda: heard, "feedback")
    assert heard[0].distance_remaining == 0.0


def test_a_second_goal_ends_the_first_without_a_code_and_cancelling_ends_the_second(
    client: Client, sim: SimProcess
) -> None:
    first = client.go_to_pose(ahead(client, sim, 0.9), [])
    heard: list[Any] = []
    second = client.go_to_pose(ahead(client, sim, 0.8), heard)
    preempted = done(first.get_result_async())
    assert preempted.status == GoalStatus.STATUS_ABORTED
    assert (preempted.result.error_code, preempted.result.error_msg) == (0, "")
    wait_for(lambda: heard and heard[-1].distance_remaining > 0.5, "the distance left")
    second.cancel_goal_async()
    assert done(second.get_result_async()).status == GoalStatus.STATUS_CANCELED


def test_an_occupied_goal_is_planned_to_the_nearest_free_point_with_its_own_heading(
    client: Client, mission: Mission, sim: SimProcess
) -> None:
    goal, robot = ahead(client, sim, 0.0), sim.truth()["pose"]
    wanted = goal.pose.pose.position
    mission.listen("map", OccupancyGrid, KEPT)
    x, y = occupied_places(mission.hear("map"))
    nearest = np.hypot(x - robot["x"], y - robot["y"]).argmin()
    wanted.x, wanted.y = float(x[nearest]), float(y[nearest])
    goal.pose.pose.orientation.z, goal.pose.pose.orientation.w = math.sin(0.5), math.cos(0.5)
    end = client.get_path(goal).poses[-1].pose
    assert 0.1 < math.hypot(end.position.x - wanted.x, end.position.y - wanted.y) < 0.75
    assert end.orientation.z == pytest.approx(math.sin(0.5))


def occupied_places(grid: OccupancyGrid) -> tuple[Any, Any]:
    """x and y of every occupied cell, in m."""
    rows, columns = np.nonzero(np.array(grid.data).reshape(grid.info.height, -1) == 100)
    origin, resolution = grid.info.origin.position, grid.info.resolution
    return origin.x + (columns + 0.5) * resolution, origin.y + (rows + 0.5) * resolution


def test_the_command_line_lists_every_lifecycle_node_by_its_real_name(mission: Mission) -> None:
    """`ros2 lifecycle nodes`: those with a `get_state` of the right type."""

    def found() -> set[str]:
        names = dict(mission.node.get_node_names_and_namespaces())
        return {name for name, space in names.items() if _has_state(mission, name, space)}

    wait_for(lambda: found() == LIFECYCLE, "the lifecycle nodes")


def test_the_command_line_lists_the_parameters_that_the_stand_in_keeps_to(mission: Mission) -> None:
    """`ros2 param list` and `get`."""
    listed = mission.call(ListParameters, "controller_server/list_parameters", ListParameters.Request())
    wanted = ["general_goal_checker.xy_goal_tolerance", "general_goal_checker.yaw_goal_tolerance"]
    assert set(wanted) <= set(listed.result.names)
    got = mission.call(GetParameters, "controller_server/get_parameters", GetParameters.Request(names=wanted))
    assert [value.double_value for value in got.values] == [0.25, 0.25]


def _has_state(mission: Mission, name: str, space: str) -> bool:
    services = mission.node.get_service_names_and_types_by_node(name, space)
    return any(kinds == ["lifecycle_msgs/srv/GetState"] for _, kinds in services)
