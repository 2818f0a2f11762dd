"""What robot_bridge does, whatever robot is behind it: one suite for the fake port and for real ROS 2.

A module that runs it defines the fixture `rig` and a class inheriting `BridgeBehaviour`.
"""

import asyncio
import contextlib
import math
from collections.abc import AsyncIterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx
from asgi_lifespan import LifespanManager

from contracts.robot import EmergencyStop, Goal, GoalStatus, MotionReply, RobotState, VelocityReply
from contracts.topics import ROBOT_EMERGENCY_STOP, ROBOT_NAVIGATION, ROBOT_OBSTACLES, ROBOT_STATE
from robot_bridge.app import create_app
from robot_bridge.ports import Robot
from robot_bridge.settings import Settings
from support.bus import MemoryBus
from support.toy_robot import ToyRobot
from support.waiting import until, until_true

INSIDE = {"x": 4.0, "y": 3.0, "yaw": 0.5}


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

    async def goal(self, **more: Any) -> httpx.Response:
        return await self.post("/navigation/goals", {"pose": INSIDE, "epoch": 0} | more)

    async def goal_status(self, goal_id: str) -> GoalStatus:
        return Goal.model_validate_json((await self.client.get(f"/navigation/goals/{goal_id}")).content).status

    async def ready(self) -> None:
        """Waits until every sensor is in and Nav2 is active."""
        answer = await self.client.get("/ready")
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(60.0):
                while (answer := await self.client.get("/ready")).status_code != 200:  # noqa: ASYNC110 - it is polled
                    await asyncio.sleep(0.02)
        assert answer.status_code == 200, answer.text


@contextlib.asynccontextmanager
async def running(tmp_path: Path, toy: ToyRobot, robot: Robot | None, **changes: Any) -> AsyncIterator[Rig]:
    """The app with an in-memory bus; `robot` none means the real ROS adapter."""
    settings = Settings(state_dir=tmp_path, **changes)
    bus = MemoryBus()
    async with LifespanManager(create_app(settings, bus=bus, robot=robot), startup_timeout=60) as manager:
        transport = httpx.ASGITransport(app=manager.app)
        async with httpx.AsyncClient(transport=transport, base_url="http://bridge", timeout=45) as client:
            rig = Rig(client, toy, bus, settings)
            await rig.ready()
            yield rig


class BridgeBehaviour:
    """The suite."""

    async def test_the_state_tells_where_the_robot_is_and_how_old_every_sensor_is(self, rig: Rig) -> None:
        state = RobotState.model_validate_json((await rig.client.get("/state")).content)
        assert state.pose is not None
        assert (round(state.pose.x, 2), round(state.pose.y, 2)) == (1.0, 2.0)
        assert state.battery is not None
        assert math.isclose(state.battery.percentage, 80.0, abs_tol=0.01)
        assert set(state.sensors) == {"scan", "odom", "rgb", "depth", "pose", "map", "battery"}
        assert all(sensor.valid for sensor in state.sensors.values())

    async def test_facts_are_published_and_the_kept_ones_are_there_for_late_listeners(self, rig: Rig) -> None:
        await until(lambda: len(rig.bus.of(ROBOT_STATE)) > 2 and len(rig.bus.of(ROBOT_OBSTACLES)) > 0)
        assert await rig.bus.last(ROBOT_EMERGENCY_STOP) == EmergencyStop(latched=False, epoch=0)
        front_m = rig.bus.of(ROBOT_OBSTACLES)[-1].sectors_m["front"]
        assert math.isclose(front_m, 3.0 - 0.189, abs_tol=0.05)

    async def test_a_lease_moves_the_robot_and_its_end_stops_it(self, rig: Rig) -> None:
        reply = VelocityReply.model_validate_json((await rig.velocity(duration_s=0.4)).content)
        assert reply.accepted
        await until(lambda: rig.toy.linear_x == 0.2)
        await until(lambda: rig.toy.at_rest)

    async def test_nothing_drives_into_a_wall(self, rig: Rig) -> None:
        rig.toy.wall_ahead_m = 0.25
        await until(lambda: rig.bus.of(ROBOT_OBSTACLES)[-1].emergency)
        reply = VelocityReply.model_validate_json((await rig.velocity()).content)
        assert reply.accepted
        assert reply.sent.linear_x == 0.0
        assert reply.reason == "obstacle ahead"

    async def test_a_bumped_robot_does_not_push_on(self, rig: Rig) -> None:
        rig.toy.hazards.add("BUMP")
        await until(lambda: "BUMP" in rig.bus.of(ROBOT_STATE)[-1].hazards)
        reply = VelocityReply.model_validate_json((await rig.velocity()).content)
        assert (reply.sent.linear_x, reply.reason) == (0.0, "hazard: BUMP")

    async def test_without_a_fresh_scan_the_robot_does_not_translate(self, rig: Rig) -> None:
        rig.toy.silent.add("scan")
        await until(lambda: not rig.bus.of(ROBOT_STATE)[-1].sensors["scan"].valid)
        reply = VelocityReply.model_validate_json((await rig.velocity()).content)
        assert reply.sent.linear_x == 0.0
        assert "laser scan" in reply.reason

    async def test_the_emergency_stop_sends_ten_zeros_and_keeps_the_robot_stopped(self, rig: Rig) -> None:
        await rig.velocity(duration_s=2.0)
        await until(lambda: rig.toy.linear_x == 0.2)
        response = await rig.client.post("/emergency-stop")
        assert response.json()["state"]["latched"]
        assert response.json()["first_zero_ms"] < 50.0
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
        await until(lambda: rig.toy.base_stop is False)
        before = len(rig.toy.velocities)
        await until(lambda: len(rig.toy.velocities) > before + 5)
        assert set(rig.toy.velocities[before:]) == {(0.0, 0.0)}
        assert (await rig.velocity(epoch=0)).status_code == 409
        assert (await rig.velocity(epoch=1)).json()["accepted"]

    async def test_it_turns_by_the_angle_asked_for(self, rig: Rig) -> None:
        reply = MotionReply.model_validate_json(
            (await rig.post("/rotate", {"angle_rad": -0.6, "speed_rad_s": 1.5, "epoch": 0})).content
        )
        assert reply.completed
        await until(lambda: rig.toy.at_rest)
        assert math.isclose(rig.toy.yaw, -0.6, abs_tol=0.052)

    async def test_it_drives_the_distance_asked_for(self, rig: Rig) -> None:
        reply = MotionReply.model_validate_json(
            (await rig.post("/drive", {"distance_m": 0.2, "speed_m_s": 0.3, "epoch": 0})).content
        )
        assert reply.completed
        await until(lambda: rig.toy.at_rest)
        assert math.isclose(rig.toy.x, 0.2, abs_tol=0.03)

    async def test_a_drive_against_a_wall_ends_and_says_so(self, rig: Rig) -> None:
        rig.toy.wall_ahead_m = 0.25
        await until(lambda: rig.bus.of(ROBOT_OBSTACLES)[-1].emergency)

        async def told_of_the_wall() -> bool:
            """Every time it is tried; on a busy machine the scan's age may be the reason now and then."""
            answer = await rig.post("/drive", {"distance_m": 1.0, "epoch": 0})
            reply = MotionReply.model_validate_json(answer.content)
            assert not reply.completed
            return reply.reason == "obstacle ahead"

        await until_true(told_of_the_wall)

    async def test_a_turn_can_be_cancelled(self, rig: Rig) -> None:
        turning = asyncio.create_task(rig.post("/rotate", {"angle_rad": 6.0, "epoch": 0}))
        await until(lambda: rig.toy.angular_z > 0.5)
        assert (await rig.client.delete("/motion")).json()["completed"]
        assert (await turning).json()["reason"] == "cancelled"
        await until(lambda: rig.toy.at_rest)

    async def test_nav2_drives_only_for_a_goal_of_ours_and_only_until_it_is_cancelled(self, rig: Rig) -> None:
        goal = (await rig.goal()).json()
        assert goal["status"] == "EXECUTING"
        await until(lambda: rig.toy.linear_x == 0.2)
        await until(lambda: any(g.distance_remaining_m == 1.5 for g in rig.bus.of(ROBOT_NAVIGATION)))
        ended = (await rig.client.delete(f"/navigation/goals/{goal['id']}")).json()
        assert ended["status"] == "CANCELED"
        await until(lambda: rig.toy.at_rest)
        statuses = [g.status for g in rig.bus.of(ROBOT_NAVIGATION)]
        assert statuses[:2] == [GoalStatus.PENDING, GoalStatus.EXECUTING]
        await until(lambda: rig.bus.of(ROBOT_NAVIGATION)[-1].status is GoalStatus.CANCELED)

    async def test_a_goal_reached_rejected_and_aborted_are_told_apart(self, rig: Rig) -> None:
        rig.toy.navigation = "succeeds"
        reached = (await rig.goal(clear_costmaps=False)).json()["id"]
        await until(lambda: any(g.status is GoalStatus.SUCCEEDED for g in rig.bus.of(ROBOT_NAVIGATION)))
        assert await rig.goal_status(reached) is GoalStatus.SUCCEEDED
        rig.toy.navigation = "rejects"
        assert (await rig.goal(clear_costmaps=False)).json()["status"] == "REJECTED"
        rig.toy.navigation = "aborts"
        aborted = (await rig.goal(clear_costmaps=False)).json()["id"]
        await until(lambda: any(g.status is GoalStatus.ABORTED for g in rig.bus.of(ROBOT_NAVIGATION)))
        goal = (await rig.client.get(f"/navigation/goals/{aborted}")).json()
        assert (goal["error_code"], goal["error_msg"]) == (104, "patience exceeded")

    async def test_costmaps_are_cleared_before_a_goal_unless_it_says_not_to(self, rig: Rig) -> None:
        rig.toy.navigation = "succeeds"
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
        await until(lambda: rig.toy.linear_x == 0.2)
        await rig.client.post("/emergency-stop", json={"reason": "smoke", "by": "a person"})
        assert await rig.goal_status(goal["id"]) is GoalStatus.CANCELED
        await until(lambda: rig.toy.at_rest and rig.toy.cancelled > 0)
        state = EmergencyStop.model_validate_json((await rig.client.get("/emergency-stop")).content)
        assert (state.reason, state.by, state.epoch) == ("smoke", "a person", 1)

    async def test_a_path_is_planned_without_moving(self, rig: Rig) -> None:
        path = (await rig.post("/navigation/path", {"goal": INSIDE})).json()
        assert path["reachable"]
        assert math.isclose(path["length_m"], 4.0, abs_tol=0.01)
        rig.toy.navigation = "aborts"
        path = (await rig.post("/navigation/path", {"goal": INSIDE})).json()
        assert (path["reachable"], path["error_code"], path["error_name"]) == (False, 208, "NO_VALID_PATH")
        assert rig.toy.at_rest

    async def test_depth_is_of_the_thing_in_the_box_not_of_the_wall_behind(self, rig: Rig) -> None:
        box = {"bbox_xyxy": [105, 105, 145, 145], "image_width_px": 250, "image_height_px": 250}
        reply = (await rig.post("/depth", box)).json()
        assert math.isclose(reply["distance_m"], 2.5, abs_tol=0.01)
        place = (await rig.post("/localize", box)).json()
        assert math.isclose(place["base_point"]["x"], 2.56, abs_tol=0.02)
        assert math.isclose(place["map_point"]["x"], 3.56, abs_tol=0.02)
        assert math.isclose(place["map_point"]["y"], 2.0, abs_tol=0.02)
        assert abs(place["bearing_rad"]) < 0.02

    async def test_frames_come_with_their_stamp_and_pose_and_only_newer_ones_on_demand(self, rig: Rig) -> None:
        first = await rig.client.get("/camera/frame")
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
        assert (the_map["width"], the_map["height"]) == (80, 60)
        picture = await rig.client.get("/map.png")
        assert picture.content.startswith(b"\x89PNG")

    async def test_it_docks_undocks_and_says_when_it_cannot(self, rig: Rig) -> None:
        assert (await rig.post("/dock")).json()["completed"]
        assert rig.toy.docked
        assert (await rig.post("/undock")).json()["completed"]
        rig.toy.can_dock = False
        assert not (await rig.post("/dock")).json()["completed"]

    async def test_success_is_celebrated_once_with_six_notes_in_2_3_seconds(self, rig: Rig) -> None:
        assert (await rig.post("/celebrate")).json()["completed"]
        await until(lambda: len(rig.toy.notes) == 6)
        assert [hz for hz, _ in rig.toy.notes] == [262, 330, 392, 523, 659, 784]
        assert math.isclose(sum(seconds for _, seconds in rig.toy.notes), 2.3)
        assert (await rig.post("/celebrate")).status_code == 409
