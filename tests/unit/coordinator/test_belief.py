"""One belief over where the target can be, and the next view by what it is worth a second."""

import math
import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from contracts.geometry import Pose2D
from coordinator.belief.belief_map import BeliefMap, Glance, box_bearings
from coordinator.belief.clues import Clue
from coordinator.belief.detection_probability import KINDS, OFF_AXIS, across, by_distance
from coordinator.belief.next_view import Choice, MotionTimes, next_view
from geometry.grids import OccupancyGrid

HFOV_RAD = 0.94
PACE = MotionTimes(speed_m_s=0.3, turn_rad_s=1.0, hfov_rad=HFOV_RAD, step_rad=0.733)
RADIUS_M = 0.17


def flat(rooms: int = 3, side: int = 80) -> OccupancyGrid:
    """Rooms of 4 m in a row, a door of 1 m between each two."""
    cells = np.zeros((side, rooms * side), dtype=np.int8)
    cells[:2], cells[-2:], cells[:, :2], cells[:, -2:] = 100, 100, 100, 100
    for k in range(1, rooms):
        cells[:, k * side - 1 : k * side + 1] = 100
        cells[30:50, k * side - 1 : k * side + 1] = 0
    return OccupancyGrid(cells, 0.05, Pose2D(x=0.0, y=0.0, yaw=0.0))


GRID = flat()
START = Pose2D(x=2.0, y=2.0, yaw=0.0)
CUP = Clue(10.0, 0.5, 0.3, 0.8, "a red cup seen before")


def belief_of(*clues: Clue, grid: OccupancyGrid = GRID) -> BeliefMap:
    return BeliefMap(grid, label="cup", clues=clues, radius_m=RADIUS_M, start=START)


def in_the_last_room(*, of: OccupancyGrid = GRID) -> BeliefMap:
    within = np.zeros(of.cells.shape, dtype=bool)
    within[:, 160:] = True
    return BeliefMap(of, label="cup", clues=(), radius_m=RADIUS_M, start=START, within=within)


def total(belief: BeliefMap) -> float:
    return float(belief.cells.sum()) + belief.absent


poses = st.builds(Pose2D, x=st.floats(0.3, 11.7), y=st.floats(0.3, 3.7), yaw=st.floats(-3.1, 3.1))
glances = st.builds(
    Glance,
    poses,
    st.just(HFOV_RAD),
    st.one_of(st.just(()), st.tuples(st.floats(-0.4, 0.0).map(lambda low: (low, low + 0.1)))),
)


def after(looks: list[Glance], *clues: Clue) -> BeliefMap:
    belief = belief_of(*clues)
    for look in looks:
        belief.look(look)
    return belief


@settings(max_examples=25, deadline=None)
@given(st.lists(glances, max_size=5), poses)
def test_probabilities_sum_to_one_whatever_was_looked_at(looks: list[Glance], refused: Pose2D) -> None:
    belief = after(looks, CUP)
    belief.refuse(refused.x, refused.y)
    assert total(belief) == pytest.approx(1.0)
    assert (belief.cells >= 0).all()


@settings(max_examples=25, deadline=None)
@given(st.lists(glances, max_size=3), poses)
def test_a_look_in_vain_raises_nothing_of_what_it_saw_beside_the_rest(looks: list[Glance], pose: Pose2D) -> None:
    belief = after(looks, CUP)
    before, absent = belief.cells, belief.absent
    belief.look(Glance(pose, HFOV_RAD))
    assert (belief.cells / belief.absent <= before / absent + 1e-12).all()
    assert belief.absent >= absent - 1e-12


@settings(max_examples=15, deadline=None)
@given(st.lists(glances, min_size=2, max_size=4))
def test_the_order_of_looks_is_no_matter_and_none_counts_twice(looks: list[Glance]) -> None:
    once, turned = after(looks, CUP), after([*reversed(looks), *looks], CUP)
    assert np.allclose(once.cells, turned.cells)


def test_a_cell_in_sight_loses_by_what_the_detector_sees_there() -> None:
    belief = belief_of()
    cell = belief.cell(Pose2D(x=3.5, y=2.0, yaw=0.0))
    assert cell is not None
    before = belief.cells[cell] / belief.absent
    belief.look(Glance(START, HFOV_RAD))
    chance = float(by_distance("cup", np.array([1.5]))[0])
    assert belief.cells[cell] / belief.absent == pytest.approx(before * (1 - chance), rel=0.05)


def test_a_wall_hides_what_lies_behind_it() -> None:
    belief = belief_of()
    cell = belief.cell(Pose2D(x=5.5, y=0.5, yaw=0.0))
    assert cell is not None
    before = belief.cells[cell] / belief.absent
    belief.look(Glance(Pose2D(x=2.5, y=0.5, yaw=0.0), HFOV_RAD))
    assert belief.cells[cell] / belief.absent == pytest.approx(before)


def test_a_box_of_its_class_raises_what_lies_behind_it_until_it_is_refused() -> None:
    belief = belief_of()
    before = belief.cells
    belief.look(Glance(START, HFOV_RAD, ((-0.1, 0.1),)))
    cell = belief.cell(Pose2D(x=3.9, y=2.0, yaw=0.0))
    assert cell is not None
    raised = belief.cells[cell]
    belief.refuse(3.9, 2.0)
    assert raised > before[cell] * 3
    assert belief.cells[cell] < before[cell]


def cabinet(grid: OccupancyGrid) -> OccupancyGrid:
    """In the last room; the laser saw a gap of 0.6 m in the middle of it, through which nothing fits or looks."""
    cells = grid.cells.copy()
    cells[30:54, 190:214] = 100
    cells[36:48, 196:208] = 0
    return OccupancyGrid(cells, grid.resolution_m, grid.origin)


def test_what_no_place_sees_holds_nothing_and_a_thing_in_it_is_looked_for_where_it_can_be_seen() -> None:
    grid = cabinet(GRID)
    inside = Clue(10.1, 2.1, 0.15, 0.8, "a red cup seen before")
    belief = belief_of(inside, grid=grid)
    gap = belief.cells[36 // 3 : 48 // 3, 196 // 3 + 1 : 208 // 3]
    assert (gap == 0.0).all()
    x, y = belief.most_likely()
    assert math.hypot(x - inside.x, y - inside.y) < 0.8
    room = np.s_[:, 160 // 3 + 1 :]
    assert belief.cells[room].sum() > 0.8
    for at_x in (8.7, 10.1, 11.3):
        for at_y in (0.8, 2.1, 3.4):
            for yaw in (0.0, 0.8, 1.6, 2.4, 3.1, -0.8, -1.6, -2.4):
                belief.look(Glance(Pose2D(x=at_x, y=at_y, yaw=yaw), HFOV_RAD))
    assert belief.cells[room].sum() < 0.2


def test_a_box_in_passing_is_still_to_be_looked_at() -> None:
    """Nobody stops for one picture; standing before it a look that shows the box is not taken again."""
    boxed = ((-0.1, 0.1),)
    gains = list[float]()
    for moving in (True, False):
        belief = belief_of()
        belief.look(Glance(START, HFOV_RAD, boxed, moving=moving))
        cell = belief.cell(Pose2D(x=3.9, y=2.0, yaw=0.0))
        assert cell is not None
        gains.append(float(belief.looked[:, *cell].max()))
    assert gains[0] == 0.0 < gains[1]


def test_memory_says_where_and_how_surely() -> None:
    belief = belief_of(CUP)
    x, y = belief.most_likely()
    assert math.hypot(x - CUP.x, y - CUP.y) < 0.4
    near = sum(float(belief.cells[belief.cell(Pose2D(x=CUP.x + dx, y=CUP.y + dy, yaw=0.0)) or (0, 0)])
               for dx in (-0.3, -0.15, 0.0, 0.15, 0.3) for dy in (-0.15, 0.0, 0.15, 0.3))  # fmt: skip
    assert near > 0.4
    assert belief.absent == pytest.approx(0.2 * 0.15)


def test_what_stands_near_what_draws_without_being_sure() -> None:
    sink = Clue(10.0, 2.0, 1.2, 2.5, "near the sink", itself=False)
    drawn, plain = belief_of(sink), belief_of()
    cell = plain.cell(Pose2D(x=10.0, y=2.0, yaw=0.0))
    assert cell is not None
    assert drawn.cells[cell] > 1.5 * plain.cells[cell]
    assert drawn.absent == pytest.approx(plain.absent)


def test_the_robot_is_sent_to_look_at_what_memory_is_sure_of() -> None:
    choice = next_view(belief_of(CUP), START, PACE)
    assert choice.view is not None
    pose = choice.view.pose
    assert choice.view.gain > 0.5
    assert math.hypot(pose.x - CUP.x, pose.y - CUP.y) < 4.5
    assert any(abs(math.remainder(math.atan2(CUP.y - pose.y, CUP.x - pose.x) - h, 2 * math.pi)) < HFOV_RAD / 2
               for h in choice.view.headings)  # fmt: skip
    assert "a red cup seen before" in choice.why


def test_a_turn_is_no_wider_than_it_is_worth() -> None:
    """In a corner facing the wall: the quarter that shows the room."""
    choice = next_view(belief_of(), Pose2D(x=0.35, y=0.35, yaw=math.pi / 4), PACE)
    assert choice.view is not None
    assert len(choice.view.headings) <= 4


@settings(max_examples=3, deadline=None)
@given(st.lists(glances, max_size=3), poses)
def test_the_same_belief_gives_the_same_choice(looks: list[Glance], here: Pose2D) -> None:
    first, again = (next_view(after(looks, CUP), here, PACE) for _ in range(2))
    assert first == again
    assert "\n" not in first.why


def searched(belief: BeliefMap, here: Pose2D, views_max: int = 60) -> tuple[Choice, list[float], float]:
    """Looks in vain until it ends: the last choice, how probable it was here before each view, and the seconds."""
    left: list[float] = []
    seconds = 0.0
    for _ in range(views_max):
        choice = next_view(belief, here, PACE)
        left.append(choice.here)
        if choice.view is None:
            break
        seconds += choice.view.seconds
        for heading in choice.view.headings:
            here = Pose2D(x=choice.view.pose.x, y=choice.view.pose.y, yaw=heading)
            belief.look(Glance(here, HFOV_RAD))
    return next_view(belief, here, PACE), left, seconds


def test_a_search_in_vain_ends_and_says_how_sure_it_is() -> None:
    last, left, seconds = searched(belief_of(grid=flat(rooms=1)), START)
    assert last.view is None
    assert last.here < 0.45
    assert left == sorted(left, reverse=True)
    assert seconds < 400
    assert "sure that it is not here" in last.why


def test_a_place_that_cannot_be_reached_is_not_chosen_again() -> None:
    first = next_view(belief_of(CUP), START, PACE)
    assert first.view is not None
    other = next_view(belief_of(CUP), START, PACE, avoid=(first.view.pose,))
    assert other.view is not None
    assert math.hypot(other.view.pose.x - first.view.pose.x, other.view.pose.y - first.view.pose.y) > 0.3


def test_the_edge_of_the_unknown_draws() -> None:
    cells = GRID.cells.copy()
    cells[:, 161:] = -1
    half = OccupancyGrid(cells, 0.05, GRID.origin)
    belief = belief_of(grid=half)
    door = belief.cell(Pose2D(x=7.95, y=2.0, yaw=0.0))
    middle = belief.cell(Pose2D(x=6.0, y=2.0, yaw=0.0))
    assert door is not None
    assert middle is not None
    assert belief.cells[door[0], door[1] - 1 : door[1] + 2].max() > 2.5 * belief.cells[middle]


def test_a_map_without_free_space_is_no_trouble() -> None:
    nothing = OccupancyGrid(np.full((40, 40), -1, dtype=np.int8), 0.05, Pose2D(x=0.0, y=0.0, yaw=0.0))
    choice = next_view(belief_of(grid=nothing), Pose2D(x=1.0, y=1.0, yaw=0.0), PACE)
    assert choice.view is None
    assert choice.here == pytest.approx(0.0)


def test_a_large_map_takes_bounded_time() -> None:
    belief = belief_of(grid=flat(rooms=12, side=160))
    began_s = time.process_time()
    assert next_view(belief, START, PACE).view is not None
    assert time.process_time() - began_s < 20.0


def test_the_chances_are_chances_and_end_with_the_picture() -> None:
    far = np.linspace(0.0, 12.0, 60)
    for kind in (*KINDS, "zebra"):
        chances = by_distance(kind, far)
        assert ((chances >= 0) & (chances <= 0.9)).all()
        assert chances[-1] == 0
    assert across(np.array([0.0, 0.5, 0.95, OFF_AXIS[-1] + 0.01])) == pytest.approx([1.0, 1.0, 0.684, 0.0], abs=0.01)


def test_a_box_spans_its_bearings() -> None:
    right, left = box_bearings(125.0, 250.0, 250, HFOV_RAD)
    assert right == pytest.approx(-HFOV_RAD / 2)
    assert left == pytest.approx(0.0)


def boxed_when_facing(thing: tuple[float, float], pose: Pose2D) -> Glance:
    """A look of which the box is what stands there, when that is in the picture."""
    bearing = math.remainder(math.atan2(thing[1] - pose.y, thing[0] - pose.x) - pose.yaw, 2 * math.pi)
    boxes = ((bearing - 0.1, bearing + 0.1),) * (abs(bearing) < HFOV_RAD / 2)
    return Glance(pose, HFOV_RAD, boxes)


@pytest.mark.parametrize("refused", [((3.0, 2.6),), ()], ids=["refused", "lost, or refused without a place"])
def test_the_search_moves_on_from_a_box_that_is_not_it_and_ends(refused: tuple[tuple[float, float], ...]) -> None:
    belief, here = belief_of(grid=flat(rooms=1)), START
    views: list[tuple[Pose2D, tuple[float, ...]]] = []
    while len(views) < 40 and (view := next_view(belief, here, PACE).view) is not None:
        views.append((view.pose, view.headings))
        for heading in view.headings:
            here = Pose2D(x=view.pose.x, y=view.pose.y, yaw=heading)
            belief.look(boxed_when_facing((3.0, 2.6), here))
        for x, y in refused:
            belief.refuse(x, y)
    assert len(views) < 40
    assert len(set(views)) == len(views)


def test_a_refused_box_leaves_what_lies_before_and_behind_it_as_looked_at_in_vain() -> None:
    boxed, vain = belief_of(), belief_of()
    boxed.look(Glance(START, HFOV_RAD, ((-0.1, 0.1),)))
    boxed.refuse(3.0, 2.0)
    vain.look(Glance(START, HFOV_RAD))
    vain.refuse(3.0, 2.0)
    assert np.allclose(boxed.cells, vain.cells)


def test_where_the_votes_confirmed_it_it_is_expected_until_it_is_refused() -> None:
    belief = belief_of(CUP)
    before = belief.cells[belief.cell(Pose2D(x=6.0, y=3.0, yaw=0.0))]
    belief.expect(6.0, 3.0)
    after = belief.cells[belief.cell(Pose2D(x=6.0, y=3.0, yaw=0.0))]
    assert after > 20 * before
    belief.look(Glance(Pose2D(x=5.0, y=3.0, yaw=0.0), HFOV_RAD))
    assert belief.cells[belief.cell(Pose2D(x=6.0, y=3.0, yaw=0.0))] > before
    belief.refuse(6.0, 3.0)
    assert belief.cells[belief.cell(Pose2D(x=6.0, y=3.0, yaw=0.0))] < before


def test_a_thing_inside_furniture_is_looked_for_at_the_edge_nearest_to_it() -> None:
    """One look at that edge says most of what there is to say; the furniture's other sides hold next to nothing."""
    cells = GRID.cells.copy()
    cells[36:52, 36:64] = 100  # 0.8 m by 1.4 m
    grid = OccupancyGrid(cells, 0.05, GRID.origin)
    belief = belief_of(Clue(2.5, 2.0, 0.15, 0.8, "a cup seen before"), grid=grid)
    likely = np.argwhere(belief.cells > 0.2 * belief.cells.max())
    assert max(belief.point(*map(int, cell))[1] for cell in likely) < 2.0
    before = belief.absent
    belief.look(Glance(Pose2D(x=2.5, y=0.8, yaw=math.pi / 2), HFOV_RAD))
    assert belief.absent > 1.8 * before
    assert belief_of(Clue(2.5, -5.0, 0.15, 0.8, "beyond the wall")).absent == pytest.approx(belief_of().absent)


def test_what_is_looked_for_in_one_room_is_not_looked_for_from_another() -> None:
    beside_the_door = Pose2D(x=7.6, y=2.0, yaw=0.0)
    for here in (START, beside_the_door):
        view = next_view(in_the_last_room(), here, PACE).view
        assert view is not None
        assert view.pose.x > 8.0


def test_a_room_that_nobody_can_stand_in_is_looked_into_from_outside() -> None:
    cells = GRID.cells.copy()
    cells[:, 166:] = 100
    view = next_view(in_the_last_room(of=OccupancyGrid(cells, 0.05, GRID.origin)), START, PACE).view
    assert view is not None
    assert view.pose.x < 8.0
