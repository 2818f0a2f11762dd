"""A search that keeps to some rooms: where it goes first, what it passes over, and what it says in the end."""

import numpy as np
import pytest

from bench.map_likeness import home_grid
from contracts.geometry import Point3D, Pose2D
from contracts.measuring import Measurement
from contracts.mission import EndCause, MissionState, Outcome, SearchedRoom, SeenElsewhere
from coordinator.belief.belief_map import BeliefMap
from coordinator.belief.clues import Clue
from coordinator.core import actions as do
from coordinator.core import events as ev
from coordinator.core import recording
from coordinator.core.area import SearchArea
from coordinator.core.rules import CoverageRule
from coordinator.coverage.areas import area_of, mask_of
from coordinator.coverage.coverage_tracker import CoverageTracker
from coordinator.coverage.explored_space import plan_coverage
from geometry.room_grids import RoomCells, decode, encode
from geometry.rooms import IN_FURNITURE_M, Rooms, rooms_of
from support.mission_script import TARGET, Script, box, rules_of

KITCHEN = SearchedRoom(id=3, name="kitchen")
BEYOND = SearchArea((KITCHEN,), Pose2D(x=2.0, y=-2.0, yaw=0.0), 0.5, tuple((row, 0, 8) for row in range(8)))
"""4 m by 4 m, 2 m ahead of where a script begins."""
HERE = SearchArea((KITCHEN,), Pose2D(x=-2.0, y=-2.0, yaw=0.0), 0.5, tuple((row, 0, 16) for row in range(8)))
IN_THE_BEDROOM = SeenElsewhere(
    label="bottle", colour="red", room="bedroom", place=Pose2D(x=9.0, y=0.0, yaw=0.0), stamp_s=40.0
)


def searching(area: SearchArea, *, elsewhere: tuple[SeenElsewhere, ...] = (), **rules: object) -> Script:
    return Script(**rules).feed(
        ev.MissionStarted("m1", "find the red bottle", TARGET, "rules", (), area=area, elsewhere=elsewhere)
    )


# the area


@pytest.mark.parametrize(
    ("x", "y", "within_m", "held"),
    [
        (2.1, 0.0, 0.0, True), (5.9, 1.9, 0.0, True), (1.9, 0.0, 0.0, False), (1.9, 0.0, 0.2, True),
        (6.2, 2.2, 0.2, False), (6.1, 2.1, 0.2, True), (-4.0, 0.0, 1.0, False),
    ],
)  # fmt: skip
def test_an_area_holds_its_cells_and_what_is_near_enough(x: float, y: float, within_m: float, *, held: bool) -> None:
    assert BEYOND.holds(x, y, within_m=within_m) is held


def test_a_turned_area_holds_what_lies_along_its_own_axes() -> None:
    turned = SearchArea((KITCHEN,), Pose2D(x=0.0, y=0.0, yaw=np.pi / 2), 1.0, ((0, 0, 3),))
    assert turned.holds(-0.5, 2.5)
    assert not turned.holds(2.5, 0.5)


def cut(seed: int = 7021) -> tuple[Rooms, RoomCells]:
    found = rooms_of(home_grid(seed))
    return found, decode(encode(found, {room.number: room.number for room in found.rooms}, map_id=""))


def test_the_area_of_a_room_has_its_floor_and_no_other_rooms() -> None:
    found, cells = cut()
    for room in found.rooms:
        area = area_of(cells, [SearchedRoom(id=room.number, name="room")])
        assert area is not None
        mask = mask_of(area, found.grid)
        assert mask[found.mask(room.number)].all()
        assert not mask[(found.labels > 0) & (found.labels != room.number)].any()


def test_a_thing_in_furniture_is_in_the_room_that_memory_says() -> None:
    found, cells = cut()
    rng = np.random.default_rng(1)
    areas = {r.number: area_of(cells, [SearchedRoom(id=r.number, name="room")]) for r in found.rooms}
    rows, columns = np.nonzero(found.grid.occupied)
    some = rng.choice(len(rows), 200, replace=False)
    told = shared = 0
    for row, column in zip(rows[some].tolist(), columns[some].tolist(), strict=True):
        x, y = found.grid.centre(row, column)
        room = found.at(x, y, within_m=IN_FURNITURE_M)
        held = {number for number, area in areas.items() if area is not None and area.holds(x, y)}
        told += (room is None and not held) or (room is not None and room.number in held)
        shared += len(held) > 1
    assert told >= 195
    assert shared <= 5  # as near to two rooms


def test_a_room_that_no_cell_is_of_has_no_area() -> None:
    assert area_of(cut()[1], [SearchedRoom(id=99, name="attic")]) is None


def test_only_rooms_that_the_map_shows_are_said_to_be_looked_in() -> None:
    found, cells = cut()
    rooms = [SearchedRoom(id=found.rooms[0].number, name="kitchen"), SearchedRoom(id=99, name="attic")]
    area = area_of(cells, rooms)
    assert area is not None
    assert area.called == "the kitchen"


# the plan


@pytest.mark.parametrize("rule", [CoverageRule.VIEWPOINTS, CoverageRule.LAWNMOWER, CoverageRule.FRONTIER])
def test_a_plan_by_any_rule_keeps_to_the_room(rule: CoverageRule) -> None:
    found, cells = cut()
    room, other = found.rooms[1], found.rooms[0]
    area = area_of(cells, [SearchedRoom(id=room.number, name="room")])
    assert area is not None
    space = CoverageTracker(found.grid, mask_of(area, found.grid))
    start = Pose2D(x=other.x_m, y=other.y_m, yaw=0.0)
    plan = plan_coverage(space, rules_of(coverage_rule=rule), 0.17, start, ())
    assert plan.points
    assert {found.at(p.x, p.y, within_m=0.1) for p in plan.points} == {room}


def test_the_share_looked_at_is_of_the_room() -> None:
    found, cells = cut()
    room = found.rooms[1]
    area = area_of(cells, [SearchedRoom(id=room.number, name="room")])
    assert area is not None
    space = CoverageTracker(found.grid, mask_of(area, found.grid))
    other = found.rooms[0]
    space.mark(Pose2D(x=other.x_m, y=other.y_m, yaw=0.0), hfov_rad=6.2, reach_m=1.0)
    assert space.share == pytest.approx(0.0, abs=0.02)
    space.seen |= found.mask(room.number)
    assert space.share == pytest.approx(1.0, abs=0.01)


def test_a_belief_is_of_the_room_alone_and_a_clue_beside_it_moves_nothing_into_it() -> None:
    found, cells = cut()
    room = found.rooms[1]
    area = area_of(cells, [SearchedRoom(id=room.number, name="room")])
    assert area is not None
    near = Clue(room.x_m, room.y_m, 0.5, 2.0, "near the oven", itself=False)
    belief = BeliefMap(
        found.grid, label="bottle", clues=(near,), radius_m=0.17, start=None, within=mask_of(area, found.grid)
    )
    rows, columns = np.nonzero(belief.cells)
    places = [belief.point(int(r), int(c)) for r, c in zip(rows, columns, strict=True)]
    assert places
    assert all(area.holds(*place, within_m=0.1) for place in places)
    assert belief.cells.sum() == pytest.approx(1.0 - belief.absent)


# the mission


def test_a_robot_outside_the_room_goes_there_before_it_looks_round() -> None:
    script = searching(BEYOND)
    assert script.mission.state is MissionState.MOVING_TO_SCAN
    assert script.asked(do.PlanCoverage)
    assert "in the kitchen only" in script.said()


def test_a_robot_in_the_room_looks_round_at_once() -> None:
    assert searching(HERE).mission.state is MissionState.SCANNING


@pytest.mark.parametrize(
    ("x", "sigma_m", "state"),
    [
        (1.0, 0.02, MissionState.MOVING_TO_SCAN), (3.0, 0.02, MissionState.CENTERING),
        (1.9, 0.02, MissionState.CENTERING), (1.4, 0.4, MissionState.CENTERING),
    ],
)  # fmt: skip
def test_what_surely_stands_outside_the_room_is_passed_over(x: float, sigma_m: float, state: MissionState) -> None:
    script = searching(BEYOND).planned(Pose2D(x=4.0, y=0.0, yaw=0.0))
    measured = Measurement(
        distance_m=x - 0.06,
        sigma_m=sigma_m,
        base_point=Point3D(x=x, y=0.0, z=0.1),
        map_point=Point3D(x=x, y=0.0, z=0.1),
    )
    for _ in range(2):
        script.see(box().model_copy(update={"measurement": measured}))
    assert script.mission.state is state


def test_what_is_seen_outside_the_room_is_kept_the_newest_of_each_place() -> None:
    known = IN_THE_BEDROOM.model_copy(update={"place": Pose2D(x=0.9, y=0.0, yaw=0.0)})
    script = searching(BEYOND, elsewhere=(known,)).planned(Pose2D(x=4.0, y=0.0, yaw=0.0))
    for x in (1.0, 1.05, 0.0):
        place = Point3D(x=x, y=1.0 if x == 0.0 else 0.0, z=0.1)
        script.see(
            box().model_copy(
                update={"measurement": Measurement(distance_m=1.0, sigma_m=0.02, base_point=place, map_point=place)}
            )
        )
    kept = script.mission.elsewhere
    assert [(one.place.x, one.room) for one in kept] == [(0.0, ""), (1.05, "bedroom")]
    assert kept[1].stamp_s > known.stamp_s


def test_an_ending_says_which_rooms_were_looked_in_and_what_is_known_of_elsewhere() -> None:
    script = searching(BEYOND, elsewhere=(IN_THE_BEDROOM,)).planned(Pose2D(x=4.0, y=0.0, yaw=0.0))
    script.feed(ev.CoverageLooked(0.8)).unreachable().planned()
    report = script.mission.report
    assert report is not None
    assert script.mission.outcome is Outcome.NOT_FOUND
    assert report.rooms == (KITCHEN,)
    assert report.elsewhere == (IN_THE_BEDROOM,)
    assert "I looked in the kitchen only" in report.text
    assert "one was seen in the bedroom a minute ago" in report.text


def test_a_room_that_nobody_can_see_into_was_not_looked_at() -> None:
    report = searching(BEYOND).planned().mission.report
    assert report is not None
    assert report.ended_by is EndCause.NO_PLACE_LEFT
    assert "no place in the kitchen could be reached" in report.text


def test_a_search_of_the_whole_home_says_nothing_of_rooms() -> None:
    script = Script().feed(ev.MissionStarted("m1", "find the red bottle", TARGET, "rules", ()))
    assert script.mission.state is MissionState.SCANNING
    script.feed(ev.CancelRequested())
    report = script.mission.report
    assert report is not None
    assert (report.rooms, report.elsewhere) == ((), ())


def test_the_rooms_it_keeps_to_are_in_its_recording_and_it_is_decided_the_same_way() -> None:
    script = Script()
    lines = [recording.header_line(recording.header_of(script.mission, "m1", script.now_s))]
    began = ev.MissionStarted(
        "m1", "find the red bottle", TARGET, "rules", (), area=BEYOND, elsewhere=(IN_THE_BEDROOM,)
    )
    script.feed(began)
    lines.append(recording.step_line(recording.Step(script.now_s, began, tuple(script.actions), script.mission.state)))
    again = list(recording.replay(recording.read(lines)))
    assert [one.same for one in again] == [True]
    assert again[-1].after.area == BEYOND
