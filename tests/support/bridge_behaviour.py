"""What robot_bridge does, whatever robot is behind it: one suite for the fake port and for real ROS 2.

A module that runs it defines the fixture `rig` and a class inheriting `BridgeBehaviour`.
"""

import asyncio
import contextlib
import io
import math
from collections.abc import AsyncIterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import httpx
import pytest
from asgi_lifespan import LifespanManager
from mcap.reader import make_reader

from contracts.causes import GoalCause, SafetyCause
from contracts.geometry import Pose2D, Twist2D
from contracts.motion import BaseEnd, DriveReply, MotionEnd, RotateReply
from contracts.obstacles import Obstacles
from contracts.recording import Recording, RecordingState
from contracts.robot import (
    BaseStopState,
    EmergencyStop,
    Goal,
    GoalStatus,
    NavigationState,
    PathReply,
    RobotState,
    VelocityReply,
)
from contracts.topics import (
    ROBOT_EMERGENCY_STOP,
    ROBOT_NAVIGATION,
    ROBOT_STATE,
)
from robot_bridge.app import create_app
from robot_bridge.arm.port import RobotArm
from robot_bridge.ports import LiveView, Robot
from robot_bridge.settings import Settings
from support.bus import MemoryBus
from support.toy_robot import DOCK, OCCUPIED, ToyRobot
from support.waiting import until, until_true

INSIDE = {"x": 4.0, "y": 3.0, "yaw": 0.5}
NEAR = {"x": 1.35, "y": 2.0, "yaw": 0.0}
"""A few decimetres ahead of where the robot begins."""
BY_THE_WALL = {"x": 2.5, "y": 0.35, "yaw": 0.0}
OCCUPIED_POSE = {"x": OCCUPIED[0], "y": OCCUPIED[1], "yaw": 0.0}
BY_THE_BASE = {"battery", "dock", "hazards"}
"""Told on change only: they hold as long as the base speaks, as its odometry shows."""
COASTED_RAD, COASTED_M = 0.2, 0.1
"""How far a robot may have gone on, on a machine that kept the bridge from its tick for a moment."""
LONG_S = 40.0
R = TypeVar("R", RotateReply, DriveReply)
"""For what a simulated robot has to drive for."""
OLD_READING = frozenset({MotionEnd.NO_ODOMETRY, MotionEnd.NO_SCAN, MotionEnd.PREEMPTED, MotionEnd.HELD_BACK})
"""For what a motion is given up on a stalled machine."""


@dataclass
class Rig:
    """The running app, a client of it, and the toy robot behind it."""

    client: httpx.AsyncClient
    toy: ToyRobot
    bus: MemoryBus
    settings: Settings

    async def post(self, path: str, body: dict[str, Any] | None = None) -> httpx.Response:
        return await self.client.post(path, json=body if body is not None else {})

    async def velocity(self, linear_x: float = 0.2, **more: Any) -> httpx.Response:
        body = {"twist": {"linear_x": linear_x}, "source": "test", "epoch": 0, "duration_s": 1.0} | more
        return await self.post("/velocity", body)

    async def moved(self, path: str, reply: type[R], **body: float) -> tuple[R, float, float]:
        """A motion to its end and the robot at rest again: the reply, and x (m) and yaw (rad) before it.

        On a stalled machine a motion is given up for an old reading, as it should; it is asked for again then.
        """
        async with asyncio.timeout(2 * LONG_S):
            while True:
                before = self.toy.x, self.toy.yaw
                answer = await self.post(path, body | {"epoch": 0})
                told = reply.model_validate_json(answer.content)
                await until(lambda: self.toy.at_rest)
                if told.end.completed:
                    return told, *before
                assert told.end in OLD_READING, told

    async def held(self, *causes: SafetyCause) -> VelocityReply:
        """The reply to a lease that is given, and held back for one of these; also where a reading is old just then."""
        async with asyncio.timeout(LONG_S):
            while not set(causes).intersection((reply := await self.lease()).causes):
                pass
        return reply

    async def lease(self) -> VelocityReply:
        return VelocityReply.model_validate_json((await self.velocity()).content)

    async def state(self) -> RobotState:
        return RobotState.model_validate_json((await self.client.get("/state")).content)

    async def obstacles(self) -> Obstacles:
        return Obstacles.model_validate_json((await self.client.get("/obstacles")).content)

    async def stands_before_a_wall(self) -> None:
        self.toy.wall_ahead_m = 0.25

        async def seen() -> bool:
            return (await self.obstacles()).emergency

        await until_true(seen)

    async def goal(self, pose: dict[str, float] = INSIDE, **more: Any) -> httpx.Response:
        return await self.post("/navigation/goals", {"candidates": [{"pose": pose}], "epoch": 0} | more)

    async def goal_status(self, goal_id: str) -> GoalStatus:
        return Goal.model_validate_json((await self.client.get(f"/navigation/goals/{goal_id}")).content).status

    async def ended(self, goal_id: str, status: GoalStatus) -> Goal:
        """The goal as it was last told of, once it has ended like this."""

        def told() -> list[Goal]:
            return [goal for goal in self.bus.of(ROBOT_NAVIGATION) if goal.id == goal_id and goal.status is status]

        await until(lambda: bool(told()), timeout_s=LONG_S)
        return told()[-1]

    async def ready(self) -> None:
        """Waits until every sensor is in and Nav2 is active."""
        answer = await self.client.get("/ready")
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(LONG_S):
                while (answer := await self.client.get("/ready")).status_code != 200:  # noqa: ASYNC110 - it is polled
                    await asyncio.sleep(0.02)
        assert answer.status_code == 200, answer.text


@contextlib.asynccontextmanager
async def running(
    tmp_path: Path,
    toy: ToyRobot,
    robot: Robot | None,
    *,
    live_view: LiveView | None = None,
    arm_given: RobotArm | None = None,
    **changes: Any,
) -> AsyncIterator[Rig]:
    """The app with an in-memory bus; `robot` none means the real ROS adapter."""
    settings = Settings(state_dir=tmp_path, **changes)
    bus = MemoryBus()
    app = create_app(settings, bus=bus, robot=robot, live_view=live_view, arm=arm_given)
    async with LifespanManager(app, startup_timeout=60) as manager:
        transport = httpx.ASGITransport(app=manager.app)
        async with httpx.AsyncClient(transport=transport, base_url="http://bridge", timeout=45) as client:
            rig = Rig(client, toy, bus, settings)
            await rig.ready()
            yield rig


class BridgeBehaviour:
    """The suite."""

    async def test_the_state_tells_where_the_robot_is_and_how_old_every_sensor_is(self, rig: Rig) -> None:
        state = await rig.state()
        async with asyncio.timeout(LONG_S):
            while state.stale:
                state = await rig.state()
        assert state.pose is not None
        assert (round(state.pose.x, 2), round(state.pose.y, 2)) == (1.0, 2.0)
        assert state.battery is not None
        assert state.battery.percentage is not None
        assert math.isclose(state.battery.percentage, 80.0, abs_tol=0.01)
        assert set(state.sensors) == {
            *("scan", "odom", "rgb", "rgb_info", "depth", "depth_info", "pose", "map", "battery", "dock", "hazards")
        }
        assert all(sensor.valid for sensor in state.sensors.values())

    async def test_stale_data_is_named_and_has_no_value(self, rig: Rig) -> None:
        rig.toy.silent |= {"odom", "rgb"}
        await until(lambda: set(rig.bus.of(ROBOT_STATE)[-1].stale) == {"odom", "rgb", *BY_THE_BASE})
        state = rig.bus.of(ROBOT_STATE)[-1]
        assert (state.odometry, state.twist) == (None, Twist2D())
        assert not state.sensors["odom"].valid
        assert state.sensors["odom"].age_s > 0.4

    async def test_facts_are_published_and_the_kept_ones_are_there_for_late_listeners(self, rig: Rig) -> None:
        await until(lambda: len(rig.bus.of(ROBOT_STATE)) > 2)
        assert await rig.bus.last(ROBOT_EMERGENCY_STOP) == EmergencyStop(latched=False, epoch=0)

    async def test_what_stands_round_the_robot_is_told_to_whoever_asks(self, rig: Rig) -> None:
        seen = await rig.obstacles()
        front_m = seen.sectors_m["front"]
        assert front_m is not None
        assert math.isclose(front_m, rig.toy.wall_ahead_m - 0.189, abs_tol=0.06)
        assert (len(seen.ring), seen.ring[0].label) == (12, "CLEAR")
        assert seen.affordances.forward == 1.0

    async def test_a_lease_moves_the_robot_and_its_end_stops_it(self, rig: Rig) -> None:
        reply = VelocityReply.model_validate_json((await rig.velocity(duration_s=1.5)).content)
        assert reply.accepted
        await until(lambda: rig.toy.has_driven)
        await until(lambda: rig.toy.at_rest)

    async def test_nothing_drives_into_a_wall(self, rig: Rig) -> None:
        await rig.stands_before_a_wall()
        reply = await rig.held(SafetyCause.OBSTACLE)
        assert reply.accepted
        assert reply.sent.linear_x == 0.0

    async def test_a_bumped_robot_does_not_push_on(self, rig: Rig) -> None:
        rig.toy.hazards.add("BUMP")
        await until(lambda: "BUMP" in rig.bus.of(ROBOT_STATE)[-1].hazards)
        assert (await rig.held(SafetyCause.HAZARD)).sent.linear_x == 0.0

    async def test_without_a_fresh_scan_the_robot_does_not_translate(self, rig: Rig) -> None:
        rig.toy.silent.add("scan")
        await until(lambda: not rig.bus.of(ROBOT_STATE)[-1].sensors["scan"].valid)
        assert (await rig.held(SafetyCause.OLD_SCAN, SafetyCause.NO_SCAN)).sent.linear_x == 0.0

    async def test_the_emergency_stop_sends_ten_zeros_and_keeps_the_robot_stopped(self, rig: Rig) -> None:
        await rig.velocity(duration_s=2.0)
        await until(lambda: rig.toy.has_driven)
        response = await rig.client.post("/emergency-stop")
        assert response.json()["state"]["latched"]
        assert response.json()["first_zero_ms"] >= 0.0
        before = len(rig.toy.velocities)
        await until(lambda: rig.toy.at_rest and len(rig.toy.velocities) > before + 12)
        assert rig.toy.velocities[-10:] == [(0.0, 0.0)] * 10
        await until(lambda: rig.toy.base_stop is True)
        assert (await rig.velocity(epoch=1)).status_code == 409
        assert (await rig.goal(epoch=1)).status_code == 409
        assert (await rig.post("/rotate", {"angle_rad": 1.0, "epoch": 1})).status_code == 409

    async def test_a_reset_permits_but_resumes_nothing(self, rig: Rig) -> None:
        await rig.velocity(duration_s=2.0)
        await rig.client.post("/emergency-stop")
        await rig.client.post("/emergency-stop/reset")
        await until(lambda: rig.toy.base_stop_asks[-1:] == [False])
        before = len(rig.toy.velocities)
        await until(lambda: len(rig.toy.velocities) > before + 5)
        assert set(rig.toy.velocities[before:]) == {(0.0, 0.0)}
        assert (await rig.velocity(epoch=0)).status_code == 409
        assert (await rig.velocity(epoch=1)).json()["accepted"]

    async def test_a_stop_and_a_reset_ask_the_base_once_each(self, rig: Rig) -> None:
        await rig.client.post("/emergency-stop")
        await until(lambda: rig.bus.of(ROBOT_STATE)[-1].base_stop is BaseStopState.ENGAGED)
        await rig.client.post("/emergency-stop/reset")
        await until(lambda: rig.bus.of(ROBOT_STATE)[-1].base_stop is BaseStopState.RELEASED)
        assert rig.toy.base_stop_asks == [True, False]

    async def test_a_stop_pressed_at_the_robot_latches_and_no_reset_from_afar_undoes_it(self, rig: Rig) -> None:
        await until(lambda: rig.bus.of(ROBOT_STATE)[-1].base_stop is BaseStopState.RELEASED)
        await rig.velocity(duration_s=2.0)
        rig.toy.base_stop = True
        await until(lambda: rig.bus.of(ROBOT_STATE)[-1].emergency_stop.latched)
        state = (await rig.state()).emergency_stop
        assert (state.by, state.epoch) == ("the robot", 1)
        assert "pressed at the robot" in state.reason
        await rig.client.post("/emergency-stop/reset")
        await until(lambda: rig.bus.of(ROBOT_STATE)[-1].base_stop is BaseStopState.HELD)
        ready = await rig.client.get("/ready")
        assert ready.status_code == 503
        told = {each["name"]: each for each in ready.json()["dependencies"]}
        assert told["base_stop"]["state"] == "not_ready"
        assert "let go there" in told["base_stop"]["detail"]
        assert False not in rig.toy.base_stop_asks
        rig.toy.base_stop = False
        await rig.ready()
        assert rig.toy.at_rest

    async def test_it_turns_by_the_angle_asked_for(self, rig: Rig) -> None:
        reply, _, before_rad = await rig.moved("/rotate", RotateReply, angle_rad=-0.6, speed_rad_s=1.5)
        assert math.isclose(reply.turned_rad, -0.6, abs_tol=0.052)
        assert abs(math.remainder(rig.toy.yaw - before_rad + 0.6, math.tau)) < COASTED_RAD

    async def test_a_u_turn_ends_within_3_degrees(self, rig: Rig) -> None:
        reply, _, before_rad = await rig.moved("/rotate", RotateReply, angle_rad=math.pi, speed_rad_s=1.9)
        assert abs(reply.turned_rad - math.pi) < math.radians(3.0)
        assert abs(math.remainder(rig.toy.yaw - before_rad - math.pi, math.tau)) < COASTED_RAD

    async def test_it_drives_the_distance_asked_for(self, rig: Rig) -> None:
        reply, before_m, _ = await rig.moved("/drive", DriveReply, distance_m=0.2, speed_m_s=0.3)
        assert math.isclose(reply.driven_m, 0.2, abs_tol=0.03)
        assert math.isclose(rig.toy.x - before_m, 0.2, abs_tol=COASTED_M)

    async def test_a_drive_against_a_wall_ends_and_says_so(self, rig: Rig) -> None:
        await rig.stands_before_a_wall()

        async def told_of_the_wall() -> bool:
            """Every time it is tried; on a busy machine the scan's age may be the reason now and then."""
            answer = await rig.post("/drive", {"distance_m": 1.0, "epoch": 0})
            reply = DriveReply.model_validate_json(answer.content)
            assert not reply.end.completed
            return reply.end is MotionEnd.BLOCKED

        await until_true(told_of_the_wall)

    async def test_a_turn_can_be_cancelled(self, rig: Rig) -> None:
        end, ended = None, {}
        async with asyncio.timeout(2 * LONG_S):
            while end != MotionEnd.CANCELED:  # for an old reading, on a stalled machine: another one is begun
                assert end in {None, *OLD_READING}
                turning = asyncio.create_task(rig.post("/rotate", {"angle_rad": 6.0, "epoch": 0}))
                await until(lambda turning=turning: rig.toy.angular_z > 0.5 or turning.done())
                ended = (await rig.client.delete("/motion")).json()
                end = (await turning).json()["end"]
                await until(lambda: rig.toy.at_rest)
        assert ended["turned_rad"] is not None

    async def test_nav2_drives_only_for_a_goal_of_ours_and_only_until_it_is_cancelled(self, rig: Rig) -> None:
        goal = (await rig.goal()).json()
        assert goal["status"] == "EXECUTING"
        await until(lambda: not rig.toy.at_rest)
        await until(lambda: any((g.distance_remaining_m or 0.0) >= 1.5 for g in rig.bus.of(ROBOT_NAVIGATION)))
        ended = (await rig.client.delete(f"/navigation/goals/{goal['id']}")).json()
        assert ended["status"] == "CANCELED"
        await until(lambda: rig.toy.at_rest)
        statuses = [g.status for g in rig.bus.of(ROBOT_NAVIGATION)]
        assert statuses[:2] == [GoalStatus.PENDING, GoalStatus.EXECUTING]
        await until(lambda: rig.bus.of(ROBOT_NAVIGATION)[-1].status is GoalStatus.CANCELED)

    async def test_a_goal_reached_rejected_and_aborted_are_told_apart(self, rig: Rig) -> None:
        rig.toy.navigation = "succeeds"
        reached = (await rig.goal(pose=NEAR, clear_costmaps=False)).json()["id"]
        await rig.ended(reached, GoalStatus.SUCCEEDED)
        rig.toy.give_ups = 9
        aborted = (await rig.goal(clear_costmaps=False)).json()["id"]
        goal = await rig.ended(aborted, GoalStatus.ABORTED)
        assert (goal.error_code, goal.error_name, goal.error_msg) == (104, "PATIENCE_EXCEEDED", "PATIENCE_EXCEEDED")
        assert goal.attempt == 3
        rig.toy.navigation = "rejects"
        assert (await rig.goal(clear_costmaps=False)).json()["status"] == "REJECTED"

    async def test_a_goal_no_path_leads_to_is_aborted_with_the_planners_code_and_never_driven(self, rig: Rig) -> None:
        rig.toy.planner_code = 208
        goal = (await rig.goal()).json()
        assert (goal["status"], goal["error_code"], goal["error_name"]) == ("ABORTED", 208, "NO_VALID_PATH")
        assert not rig.toy.goals
        assert rig.toy.at_rest

    async def test_a_goal_where_something_stands_becomes_the_nearest_reachable_pose_round_it(self, rig: Rig) -> None:
        goal = Goal.model_validate_json((await rig.goal(pose=OCCUPIED_POSE, clear_costmaps=False)).content)
        assert goal.status is GoalStatus.EXECUTING
        assert goal.wanted == Pose2D(**OCCUPIED_POSE)
        assert 0.3 < math.hypot(goal.pose.x - OCCUPIED[0], goal.pose.y - OCCUPIED[1]) < 0.61
        body = {"goal": OCCUPIED_POSE, "ring_radius_m": 0.6, "look_at": {"x": OCCUPIED[0], "y": OCCUPIED[1], "z": 0.1}}
        path = PathReply.model_validate_json((await rig.post("/navigation/path", body)).content)
        assert path.reachable
        assert path.error_name in {"GOAL_OCCUPIED", "NO_VALID_PATH"}  # without a planner tolerance, and with one
        assert path.goal is not None
        facing = math.atan2(OCCUPIED[1] - path.goal.y, OCCUPIED[0] - path.goal.x)
        assert math.isclose(math.remainder(facing - path.goal.yaw, math.tau), 0.0, abs_tol=1e-6)
        exactly = (await rig.goal(pose=OCCUPIED_POSE, clear_costmaps=False, ring_radius_m=0.0)).json()
        assert (exactly["status"], exactly["error_code"]) == ("ABORTED", path.error_code)

    async def test_a_goal_nav2_gave_up_under_way_is_tried_again_from_where_the_robot_stands(self, rig: Rig) -> None:
        rig.toy.navigation, rig.toy.give_ups = "succeeds", 1
        goal = (await rig.goal(pose=NEAR, clear_costmaps=False)).json()["id"]
        ended = await rig.ended(goal, GoalStatus.SUCCEEDED)
        assert ended.attempt == 2
        assert any(each.error_code == 104 and each.attempt == 2 for each in rig.bus.of(ROBOT_NAVIGATION))
        assert rig.toy.cleared >= 1
        assert rig.toy.goals[0] == rig.toy.goals[1]

    async def test_an_abort_without_a_code_is_tried_again_and_told_in_words(self, rig: Rig) -> None:
        rig.toy.navigation, rig.toy.give_ups, rig.toy.give_up_code = "succeeds", 1, 0
        goal = (await rig.goal(pose=NEAR, clear_costmaps=False)).json()["id"]
        assert (await rig.ended(goal, GoalStatus.SUCCEEDED)).attempt == 2
        rig.toy.give_ups = 9
        lost = (await rig.goal(clear_costmaps=False)).json()["id"]
        ended = await rig.ended(lost, GoalStatus.ABORTED)
        assert (ended.attempt, ended.error_code, ended.cause) == (3, 0, GoalCause.NAV2_SILENT)
        assert "waited too long for a server" in ended.error_msg

    async def test_the_third_try_goes_to_a_roomier_pose_on_the_ring(self, rig: Rig) -> None:
        rig.toy.give_ups = 2
        goal = (await rig.goal(pose=BY_THE_WALL, clear_costmaps=False)).json()["id"]
        await until(lambda: len(rig.toy.goals) == 3, timeout_s=LONG_S)
        await rig.client.delete(f"/navigation/goals/{goal}")
        ended = await rig.ended(goal, GoalStatus.CANCELED)
        assert ended.attempt == 3
        assert ended.pose.y > BY_THE_WALL["y"] + 0.2
        assert ended.wanted == Pose2D(**BY_THE_WALL)

    async def test_of_the_lowest_rank_with_a_path_the_cheapest_candidate_is_taken(self, rig: Rig) -> None:
        dear, cheap, far = NEAR, INSIDE, BY_THE_WALL
        candidates = [
            {"pose": OCCUPIED_POSE},
            {"pose": dear, "cost_m": 50.0, "rank": 1},
            {"pose": cheap, "rank": 1},
            {"pose": far, "rank": 2},
        ]
        goal = Goal.model_validate_json((await rig.goal(candidates=candidates, clear_costmaps=False)).content)
        assert (goal.status, goal.candidate) == (GoalStatus.EXECUTING, 2)
        assert (goal.pose, goal.wanted) == (Pose2D(**cheap), Pose2D(**OCCUPIED_POSE))

    async def test_a_goal_waits_for_nav2_to_become_active(self, rig: Rig) -> None:
        rig.toy.navigation = "is_inactive"
        await until(lambda: rig.bus.of(ROBOT_STATE)[-1].navigation is NavigationState.INACTIVE)
        sending = asyncio.create_task(rig.goal(clear_costmaps=False))
        await until(lambda: len(rig.bus.of(ROBOT_STATE)) > 0)
        rig.toy.navigation = "drives"
        assert (await sending).json()["status"] == "EXECUTING"

    async def test_costmaps_are_cleared_before_a_goal_unless_it_says_not_to(self, rig: Rig) -> None:
        await rig.goal(clear_costmaps=False)
        assert rig.toy.cleared == 0
        await rig.goal()
        assert rig.toy.cleared >= 1

    async def test_a_goal_past_its_time_is_cancelled_and_called_timed_out(self, rig: Rig) -> None:
        goal = (await rig.goal(timeout_s=0.3, clear_costmaps=False)).json()
        await until(lambda: any(g.status is GoalStatus.TIMED_OUT for g in rig.bus.of(ROBOT_NAVIGATION)))
        assert await rig.goal_status(goal["id"]) is GoalStatus.TIMED_OUT
        await until(lambda: rig.toy.at_rest)

    async def test_the_emergency_stop_cancels_the_goal(self, rig: Rig) -> None:
        goal = (await rig.goal(clear_costmaps=False)).json()
        await until(lambda: not rig.toy.at_rest)
        await rig.client.post("/emergency-stop", json={"reason": "smoke", "by": "a person"})
        assert await rig.goal_status(goal["id"]) is GoalStatus.CANCELED
        await until(lambda: rig.toy.at_rest and rig.toy.cancelled > 0)
        state = EmergencyStop.model_validate_json((await rig.client.get("/emergency-stop")).content)
        assert (state.reason, state.by, state.epoch) == ("smoke", "a person", 1)

    async def test_a_path_is_planned_without_moving(self, rig: Rig) -> None:
        path = (await rig.post("/navigation/path", {"goal": INSIDE})).json()
        assert path["reachable"]
        assert math.hypot(3.0, 1.0) - 0.01 < path["length_m"] < 4.01
        rig.toy.planner_code = 208
        path = (await rig.post("/navigation/path", {"goal": INSIDE})).json()
        assert (path["reachable"], path["error_code"], path["error_name"]) == (False, 208, "NO_VALID_PATH")
        assert rig.toy.at_rest

    async def test_depth_is_of_the_thing_in_the_box_not_of_the_wall_behind(self, rig: Rig) -> None:
        bbox, depth_m, (x, y) = rig.toy.face_the_thing()
        box = {"bbox_xyxy": bbox, "image_width_px": 250, "image_height_px": 250}

        async def measured() -> bool:
            distance_m = (await rig.post("/depth", box)).json()["distance_m"]
            return distance_m is not None and math.isclose(distance_m, depth_m, abs_tol=0.02)

        await until_true(measured)
        reply = (await rig.post("/depth", box)).json()
        assert reply["samples"] > 12
        assert reply["spread_m"] < 0.03
        assert reply["holes"] < 0.2
        assert reply["age_s"] < 5.0

        boxes = {"boxes_xyxy": [bbox], "image_width_px": 250, "image_height_px": 250}

        async def located() -> bool:
            return (await rig.post("/localize", boxes)).json()["measurements"][0]["map_point"] is not None

        await until_true(located)
        place = (await rig.post("/localize", boxes)).json()["measurements"][0]
        assert math.isclose(place["base_point"]["x"], depth_m + rig.toy.camera_x_m, abs_tol=0.02)
        assert math.isclose(place["map_point"]["x"], x, abs_tol=0.03)
        assert math.isclose(place["map_point"]["y"], y, abs_tol=0.03)
        assert abs(place["bearing_rad"]) < 0.02
        assert place["sigma_m"] == pytest.approx(0.012 * place["depth_m"] ** 3.461)
        assert place["cause"] is None

    async def test_boxes_of_one_picture_are_measured_together_each_with_its_own_cause(self, rig: Rig) -> None:
        bbox, depth_m, _ = rig.toy.face_the_thing()
        boxes = [bbox, (900, 900, 950, 950), (50, 50, 10, 10), bbox]
        request = {"boxes_xyxy": boxes, "image_width_px": 250, "image_height_px": 250}

        async def measurements() -> list[dict[str, Any]]:
            return (await rig.post("/localize", request)).json()["measurements"]

        async def measured() -> bool:
            found = (await measurements())[0]["depth_m"]
            return found is not None and math.isclose(found, depth_m, abs_tol=0.02)

        await until_true(measured)
        first, outside, empty, again = await measurements()
        assert (outside["cause"], empty["cause"]) == ("outside_picture", "no_area")
        assert outside["distance_m"] is None
        assert again["distance_m"] == pytest.approx(first["distance_m"], abs=0.05)

    async def test_frames_come_with_their_stamp_and_pose_and_only_newer_ones_on_demand(self, rig: Rig) -> None:
        first = await rig.client.get("/camera/frame", params={"after": 0.0, "wait_s": 5})
        assert first.headers["content-type"] == "image/jpeg"
        assert (first.headers["x-width"], first.headers["x-height"]) == ("250", "250")
        pose = [float(value) for value in first.headers["x-pose"].split(",")]
        assert (round(pose[0], 2), round(pose[1], 2)) == (1.0, 2.0)
        second = await rig.client.get("/camera/frame", params={"after": first.headers["x-stamp-s"], "wait_s": 3})
        assert float(second.headers["x-stamp-s"]) > float(first.headers["x-stamp-s"])
        later = float(second.headers["x-stamp-s"]) + 1000.0
        assert (await rig.client.get("/camera/frame", params={"after": later})).status_code == 204

    async def test_the_map_is_served_as_data_and_as_a_picture(self, rig: Rig) -> None:
        the_map = (await rig.client.get("/map")).json()
        assert (the_map["height"], the_map["width"]) == rig.toy.cells().shape
        picture = await rig.client.get("/map.png")
        assert picture.content.startswith(b"\x89PNG")

    async def test_it_cannot_dock_where_the_dock_is_neither_known_nor_seen(self, rig: Rig) -> None:
        refused = await rig.post("/dock")
        assert refused.status_code == 409
        assert "where the dock is, is not known" in refused.json()["detail"]
        assert (await rig.post("/undock")).json()["detail"] == "it is not docked"

    async def test_it_drives_in_front_of_its_dock_docks_and_undocks(self, rig: Rig) -> None:
        rig.toy.put_on_dock()
        await until(lambda: rig.bus.of(ROBOT_STATE)[-1].dock is not None)
        assert (await rig.post("/dock")).json()["end"] == BaseEnd.ALREADY_THERE
        rig.toy.put_away()
        await until(lambda: rig.bus.of(ROBOT_STATE)[-1].docked is False)
        rig.toy.navigation, rig.toy.dock_visible = "succeeds", True
        assert (await rig.post("/dock")).json()["end"] == BaseEnd.COMPLETED
        before = next(goal.wanted for goal in rig.bus.of(ROBOT_NAVIGATION))
        assert math.isclose(before.x, DOCK.x + 0.6, abs_tol=0.05)
        assert math.isclose(abs(before.yaw), math.pi, abs_tol=0.05)
        await until(lambda: rig.bus.of(ROBOT_STATE)[-1].docked is True)
        assert (await rig.post("/undock")).json()["end"] == BaseEnd.COMPLETED
        await until(lambda: rig.bus.of(ROBOT_STATE)[-1].docked is False)

    async def test_a_dock_that_cannot_be_reached_or_driven_onto_is_told_with_the_reason(self, rig: Rig) -> None:
        rig.toy.put_on_dock()
        await until(lambda: rig.bus.of(ROBOT_STATE)[-1].dock is not None)
        rig.toy.put_away()
        await until(lambda: rig.bus.of(ROBOT_STATE)[-1].docked is False)
        rig.toy.planner_code = 206
        away = (await rig.post("/dock")).json()
        assert away["end"] == BaseEnd.NOT_BEFORE_DOCK
        assert "did not get in front of the dock: ABORTED" in away["text"]
        rig.toy.planner_code, rig.toy.navigation, rig.toy.can_dock = 0, "succeeds", False
        assert (await rig.post("/dock")).json()["end"] == BaseEnd.DOCK_NOT_SEEN
        rig.toy.dock_visible = True
        await until(lambda: rig.bus.of(ROBOT_STATE)[-1].dock_visible is True)
        assert (await rig.post("/dock")).json()["end"] == BaseEnd.GAVE_UP
        assert rig.toy.republisher_deaths == 0

    async def test_success_is_celebrated_once_with_six_notes_in_2_3_seconds(self, rig: Rig) -> None:
        assert (await rig.post("/celebrate")).json()["end"] == BaseEnd.COMPLETED
        await until(lambda: len(rig.toy.notes) == 6)
        assert [hz for hz, _ in rig.toy.notes] == [262, 330, 392, 523, 659, 784]
        assert math.isclose(sum(seconds for _, seconds in rig.toy.notes), 2.3)
        assert all(0.3 <= round(seconds, 6) <= 0.6 for _, seconds in rig.toy.notes)
        await until(lambda: rig.toy.leds is not None)
        assert rig.toy.leds == (2, ((0, 255, 0),) * 6, 3.0)
        assert (await rig.post("/celebrate")).status_code == 409

    async def test_a_recording_of_the_meshs_topics_reads_back(self, rig: Rig) -> None:
        started = Recording.model_validate_json((await rig.post("/recordings", {"name": "search"})).content)
        assert started.state is RecordingState.RECORDING
        url = f"/recordings/{started.id}"
        assert (await rig.post("/recordings")).status_code == 409
        assert (await rig.client.get(f"{url}/file")).status_code == 409

        async def heard() -> bool:
            topics = Recording.model_validate_json((await rig.client.get(url)).content).topics
            return {"robot.state", "robot.emergency_stop"} <= topics.keys()

        await until_true(heard, timeout_s=LONG_S)
        stopped = Recording.model_validate_json((await rig.post(f"{url}/stop")).content)
        assert (stopped.state, stopped.reason, stopped.dropped) == (RecordingState.FINISHED, "stopped", 0)
        file = await rig.client.get(f"{url}/file")
        assert len(file.content) == stopped.size_bytes
        messages = list(make_reader(io.BytesIO(file.content)).iter_messages())
        assert len(messages) == stopped.messages
        state = next(message for _, channel, message in messages if channel.topic == "robot.state")
        assert "scan" in RobotState.model_validate_json(state.data).sensors
        schemas = {schema.name for schema, _, _ in messages if schema is not None and schema.encoding == "jsonschema"}
        assert {"RobotState", "EmergencyStop"} <= schemas
        assert started.id in {each["id"] for each in (await rig.client.get("/recordings")).json()}
        assert (await rig.client.delete(url)).status_code == 204
        assert (await rig.client.get(url)).status_code == 404
