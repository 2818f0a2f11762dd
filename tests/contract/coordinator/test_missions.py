"""Whole missions through the front door, in fake time."""

import math
from itertools import pairwise

from contracts.geometry import Pose2D
from contracts.mission import MissionState, Outcome
from contracts.robot import GoalStatus
from contracts.topics import MISSION_EVENTS, MISSION_STATE, MISSION_TARGET
from geometry.poses import apart_m
from support.coordinator_mesh import OpenMesh
from support.coordinator_world import Thing, thing

RED = Thing("bottle", "red", 3.5, 2.5)
BLUE = Thing("bottle", "blue", 3.0, 3.2)
HIGH = Thing("bottle", "red", 8.5, 6.8, near_limit_m=0.8)


async def test_a_bottle_in_the_room_is_found_and_driven_up_to(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        mission = await mesh.until_over((await mesh.post_mission()).id)
        assert mission.outcome is Outcome.FOUND
        assert mission.measured_distance_m is not None
        assert mission.measured_distance_m <= 0.5
        assert mesh.away_m(RED) <= 0.5
        assert abs(mesh.bearing_rad(RED)) < 0.15
        assert [vote.verdict.value for vote in mission.votes] == ["yes", "yes", "abstain"]
        assert mission.target_pose is not None
        assert math.hypot(mission.target_pose.x - RED.x, mission.target_pose.y - RED.y) < 0.05
        assert mission.metres_driven_m > 0.5
        assert mesh.robot.celebrations == 1
        await mesh.until_state(MissionState.IDLE, within_s=3.0)


async def test_something_high_that_leaves_the_picture_is_finished_on_odometry(open_mesh: OpenMesh) -> None:
    async with open_mesh(HIGH) as mesh:
        mission = await mesh.until_over((await mesh.post_mission()).id)
        assert mission.outcome is Outcome.FOUND
        assert mesh.away_m(HIGH) <= 0.5
        assert abs(mesh.bearing_rad(HIGH)) < 0.15


async def test_a_table_in_the_way_ends_it_as_near_as_the_map_allows(open_mesh: OpenMesh) -> None:
    async with open_mesh(HIGH, keep_out=((HIGH.x, HIGH.y, 0.7),)) as mesh:
        mission = await mesh.until_over((await mesh.post_mission()).id)
        assert mission.outcome is Outcome.FOUND
        assert "as near as the map allows" in mission.reason
        assert 0.5 < mesh.away_m(HIGH) < 1.0
        assert abs(mesh.bearing_rad(HIGH)) < 0.2


async def test_the_right_one_is_found_beside_a_wrong_one_of_unknown_colour(open_mesh: OpenMesh) -> None:
    wrong = Thing("bottle", "grey", 3.4, 1.2)
    async with open_mesh(wrong, Thing("bottle", "red", 3.2, 2.6), colours_unknown=True) as mesh:
        mission = await mesh.until_over((await mesh.post_mission()).id)
        assert mission.outcome is Outcome.FOUND
        assert mesh.away_m(mesh.world.things[1]) <= 0.5
        assert any("refused" in event.text for event in await mesh.timeline(mission.id))


async def test_a_house_without_it_is_searched_and_the_share_is_told(open_mesh: OpenMesh) -> None:
    async with open_mesh(BLUE) as mesh:
        mission = await mesh.until_over((await mesh.post_mission()).id)
        assert mission.outcome is Outcome.NOT_FOUND
        assert "% of the free space" in mission.reason
        last = (await mesh.timeline(mission.id))[-1]
        assert (last.data.looked_share or 0.0) > 0.9
        assert mesh.inference.validations == 0


async def test_a_remembered_view_is_tried_first_and_saves_the_search(open_mesh: OpenMesh) -> None:
    view = Pose2D(x=7.5, y=6.0, yaw=0.7)
    async with open_mesh(HIGH, views=(view,)) as mesh:
        mission = await mesh.until_over((await mesh.post_mission()).id, within_s=120.0)
        assert mission.outcome is Outcome.FOUND
        status = (await mesh.client.get("/state")).json()
        assert len(status["scan_points_done"]) == 0


async def test_a_thing_remembered_with_its_place_is_driven_to_itself_not_to_where_it_was_seen_from(
    open_mesh: OpenMesh,
) -> None:
    view = Pose2D(x=6.0, y=4.5, yaw=0.7)
    async with open_mesh(HIGH, views=(view,)) as mesh:
        mesh.memory.things = (thing(1, "bottle", HIGH.x, HIGH.y, "red"),)
        mission = await mesh.until_over((await mesh.post_mission()).id, within_s=120.0)
        assert mission.outcome is Outcome.FOUND
        first = mesh.robot.goals["goal-0"].pose
        assert math.hypot(first.x - HIGH.x, first.y - HIGH.y) < 1.51
        assert apart_m(first, view) > 1.0


async def test_a_thing_that_moved_since_it_was_remembered_is_still_found(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED, views=(Pose2D(x=7.5, y=6.0, yaw=0.7),)) as mesh:
        mission = await mesh.until_over((await mesh.post_mission()).id)
        assert mission.outcome is Outcome.FOUND
        assert mesh.away_m(RED) <= 0.5


async def test_a_place_that_nav2_gives_up_is_skipped_with_its_code_and_the_search_goes_on(open_mesh: OpenMesh) -> None:
    async with open_mesh(HIGH, views=(Pose2D(x=7.5, y=6.0, yaw=0.7),)) as mesh:
        mesh.robot.aborts = [(GoalStatus.ABORTED, 104)]
        mission = await mesh.until_over((await mesh.post_mission()).id)
        assert mission.outcome is Outcome.FOUND
        assert any("ABORTED 104" in event.text for event in await mesh.timeline(mission.id))


async def test_a_narrow_refusal_makes_the_ending_unsure_with_its_votes(open_mesh: OpenMesh) -> None:
    async with open_mesh(BLUE, colours_unknown=True) as mesh:
        mesh.inference.narrow = True
        mission = await mesh.until_over((await mesh.post_mission()).id)
        assert mission.outcome is Outcome.UNSURE
        assert mission.votes


async def test_the_plain_rules_find_it_too(open_mesh: OpenMesh) -> None:
    plain = {"coverage_rule": "lawnmower", "centering_rule": "proportional", "approach_rule": "straight"}
    async with open_mesh(RED, **plain) as mesh:
        mission = await mesh.until_over((await mesh.post_mission()).id)
        assert mission.outcome is Outcome.FOUND
        assert mesh.away_m(RED) <= 0.5


async def test_a_belief_finds_it_too_and_says_each_choice_in_one_line(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED, coverage_rule="belief") as mesh:
        mission = await mesh.until_over((await mesh.post_mission()).id)
        assert mission.outcome is Outcome.FOUND
        events = (await mesh.client.get(f"/missions/{mission.id}/events")).json()
        choices = [one["text"] for one in events if "that it is here" in one["text"]]
        assert choices
        assert all("to see it, in" in text and "\n" not in text for text in choices)


async def test_it_leaves_the_dock_first(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        mesh.world.docked = True
        await mesh.clock.advance(0.3)
        mission = await mesh.until_over((await mesh.post_mission()).id)
        assert mission.outcome is Outcome.FOUND
        assert mesh.world.moves[0] == "undock"


async def test_passing_failures_of_every_service_are_outlived(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED, views=(Pose2D(x=7.5, y=6.0, yaw=0.7),)) as mesh:
        mesh.memory.away = True
        mesh.robot.fail_next = {"map": 1, "navigate": 2, "rotate": 2, "drive": 1}
        mesh.world.unmeasured = 1
        mesh.inference.fail_next = 1
        mission = await mesh.until_over((await mesh.post_mission()).id)
        assert mission.outcome is Outcome.FOUND


async def test_a_bridge_that_stays_away_aborts_it_with_the_cause(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        mesh.robot.fail_next = {"rotate": 1000}
        mission = await mesh.until_over((await mesh.post_mission()).id, within_s=120.0)
        assert mission.outcome is Outcome.ABORTED
        assert "robot_bridge" in mission.reason


async def test_without_pictures_it_aborts_instead_of_searching_blind(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        mesh.world.sees = False
        mission = await mesh.until_over((await mesh.post_mission()).id, within_s=120.0)
        assert mission.outcome is Outcome.ABORTED
        assert "no picture" in mission.reason


async def test_the_topics_tell_the_whole_mission(open_mesh: OpenMesh) -> None:
    async with open_mesh(RED) as mesh:
        mission = await mesh.until_over((await mesh.post_mission()).id)
        await mesh.until_state(MissionState.IDLE, within_s=3.0)
        await mesh.clock.advance(0.5)
        targets = mesh.bus.of(MISSION_TARGET)
        assert targets[0].target is None
        assert targets[-1].target is None
        wanted = [t for t in targets if t.target is not None]
        assert {t.mission_id for t in wanted} == {mission.id}
        assert {t.fast for t in wanted} == {True}  # it looks from where it stands: no drive between places
        states = [s.state for s in mesh.bus.of(MISSION_STATE)]
        assert {states[0], states[-1]} == {MissionState.IDLE}
        assert MissionState.DONE in states
        stamps = [s.stamp_s for s in mesh.bus.of(MISSION_STATE)]
        assert max(b - a for a, b in pairwise(stamps)) <= 0.51
        ids = [e.id for e in mesh.bus.of(MISSION_EVENTS)]
        assert ids == list(range(len(ids)))
