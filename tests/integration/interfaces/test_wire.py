"""Two processes exchange every interface of ours over DDS."""

from typing import Any

from action_msgs.msg import GoalStatus
from builtin_interfaces.msg import Duration
from geometry_msgs.msg import PoseStamped, TransformStamped
from irobot_create_msgs.action import Dock, LedAnimation, Undock
from irobot_create_msgs.msg import (
    AudioNote,
    AudioNoteVector,
    DockStatus,
    HazardDetection,
    HazardDetectionVector,
    LedColor,
    LightringLeds,
)
from irobot_create_msgs.srv import EStop
from nav2_msgs.action import ComputePathToPose, NavigateToPose
from nav2_msgs.srv import ClearEntireCostmap
from tf2_msgs.msg import TFMessage


def pose_at(x_m: float, frame_id: str = "map") -> PoseStamped:
    pose = PoseStamped()
    pose.header.frame_id = frame_id
    pose.pose.position.x = x_m
    return pose


def ring(blue: int) -> LightringLeds:
    return LightringLeds(leds=[LedColor(red=index, blue=blue) for index in range(6)], override_system=True)


def test_a_navigation_goal_gives_feedback_and_succeeds(wire: Any) -> None:
    goal = NavigateToPose.Goal(pose=pose_at(1.25), behavior_tree="a tree")
    handle, feedback = wire.start_goal_with_feedback(NavigateToPose, "navigate_to_pose", goal)
    status, result = wire.outcome(handle)
    assert status == GoalStatus.STATUS_SUCCEEDED
    assert (result.error_code, result.error_msg) == (NavigateToPose.Result.NONE, "a tree")
    assert feedback == [
        NavigateToPose.Feedback(
            current_pose=pose_at(1.25),
            navigation_time=Duration(sec=3),
            estimated_time_remaining=Duration(nanosec=500),
            number_of_recoveries=-1,
            distance_remaining=1.5,
        )
    ]


def test_a_navigation_goal_can_be_canceled_under_way(wire: Any) -> None:
    goal = NavigateToPose.Goal(pose=pose_at(2.0, "wait"))
    handle, _ = wire.start_goal_with_feedback(NavigateToPose, "navigate_to_pose", goal)
    assert len(wire.answer(handle.cancel_goal_async).goals_canceling) == 1
    assert wire.outcome(handle)[0] == GoalStatus.STATUS_CANCELED


def test_a_rejected_goal_is_told_apart_from_an_aborted_one(wire: Any) -> None:
    rejected, _ = wire.start_goal(NavigateToPose, "navigate_to_pose", NavigateToPose.Goal(pose=pose_at(1.0, "reject")))
    assert not rejected.accepted
    aborting = NavigateToPose.Goal(pose=pose_at(1.0, "abort"))
    status, result = wire.finish_goal(NavigateToPose, "navigate_to_pose", aborting)
    assert status == GoalStatus.STATUS_ABORTED
    assert (result.error_code, result.error_msg) == (104, "patience exceeded")


def test_a_planning_goal_brings_back_a_path_and_an_error_code(wire: Any) -> None:
    goal = ComputePathToPose.Goal(start=pose_at(1.0), goal=pose_at(2.0), planner_id="GridBased", use_start=True)
    status, result = wire.finish_goal(ComputePathToPose, "compute_path_to_pose", goal)
    assert status == GoalStatus.STATUS_ABORTED
    assert result.error_code == ComputePathToPose.Result.GOAL_OCCUPIED
    assert result.path.poses == [pose_at(1.0), pose_at(2.0)]
    assert result.planning_time.nanosec == 7


def test_docking_reports_that_the_dock_is_seen_and_then_that_the_robot_is_on_it(wire: Any) -> None:
    handle, feedback = wire.start_goal_with_feedback(Dock, "dock", Dock.Goal())
    status, result = wire.outcome(handle)
    assert (status, result.is_docked) == (GoalStatus.STATUS_SUCCEEDED, True)
    assert feedback[0].sees_dock
    status, result = wire.finish_goal(Undock, "undock", Undock.Goal())
    assert (status, result.is_docked) == (GoalStatus.STATUS_SUCCEEDED, False)


def test_a_light_animation_carries_six_colours_and_a_duration(wire: Any) -> None:
    goal = LedAnimation.Goal(
        animation_type=LedAnimation.Goal.SPIN_LIGHTS, lightring=ring(blue=42), max_runtime=Duration(sec=5)
    )
    handle, feedback = wire.start_goal_with_feedback(LedAnimation, "led_animation", goal)
    status, result = wire.outcome(handle)
    assert (status, result.runtime.sec) == (GoalStatus.STATUS_SUCCEEDED, 42)
    assert feedback[0].remaining_runtime == Duration(sec=5)


def test_services_answer(wire: Any) -> None:
    name = "clear_entirely_global_costmap"
    assert wire.call(ClearEntireCostmap, name, ClearEntireCostmap.Request()) == ClearEntireCostmap.Response()
    answer = wire.call(EStop, "e_stop", EStop.Request(e_stop_on=True))
    assert (answer.success, answer.message) == (True, "e-stop True")


def test_messages_come_back_as_they_were_sent(wire: Any) -> None:
    notes = [AudioNote(frequency=frequency_hz, max_runtime=Duration(nanosec=250)) for frequency_hz in (440, 880)]
    transform = TransformStamped(child_frame_id="base_link")
    transform.header.frame_id = "odom"
    transform.transform.translation.x = 0.5
    for message in (
        AudioNoteVector(notes=notes, append=True),
        DockStatus(dock_visible=True),
        HazardDetectionVector(detections=[HazardDetection(type=HazardDetection.CLIFF)]),
        ring(blue=255),
        TFMessage(transforms=[transform]),
    ):
        assert wire.echo(message) == message
