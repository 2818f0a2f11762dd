"""What memory says of where the target is, as clues of the belief."""

import math

import pytest

from contracts.geometry import Pose2D
from contracts.memory import RecalledView, RememberedObject, ScoreParts, View
from contracts.vision import Target
from coordinator.belief.clues import clues
from support.coordinator_world import thing

TARGET = Target(label="cup", description="red cup")
CUP = thing(1, "cup", 5.0, 2.0, "red")


def view(x: float, y: float, yaw: float, seen: RememberedObject | None = None) -> RecalledView:
    at = View(id=1, label="cup", confidence=0.9, pose=Pose2D(x=x, y=y, yaw=yaw), stamp_s=1.0)
    return RecalledView(view=at, source="label", thing=seen)


def test_what_was_measured_stands_where_it_was_measured() -> None:
    (clue,) = clues(TARGET, [view(4.0, 2.0, 0.0, CUP), view(5.0, 1.0, math.pi / 2, CUP)], [])
    assert (clue.x, clue.y, clue.weight) == (5.0, 2.0, pytest.approx(0.85))


@pytest.mark.parametrize(("x", "y", "yaw", "more"), [
    (1.0, 2.0, 0.0, 0),  # towards it
    (1.0, 2.0, 0.5, 0),  # it is at the edge of the picture
    (1.0, 2.0, math.pi, 1),  # away from it
    (-5.0, 2.0, 0.0, 1),  # too far away to be seen
])  # fmt: skip
def test_a_view_without_a_distance_is_no_second_thing_where_the_first_lies_in_its_direction(
    x: float, y: float, yaw: float, more: int
) -> None:
    assert len(clues(TARGET, [view(4.0, 2.0, 0.0, CUP), view(x, y, yaw)], [])) == 1 + more


def test_many_views_without_a_distance_are_no_many_things() -> None:
    (one,) = clues(TARGET, [view(1.0, 2.0, 0.0)], [])
    many = clues(TARGET, [view(float(k), 2.0, 0.0) for k in range(12)], [])
    assert len(many) == 12
    assert 1.0 - math.prod(1.0 - clue.weight for clue in many) <= one.weight


def test_a_view_without_a_distance_says_less_than_a_place() -> None:
    (placed,) = clues(TARGET, [view(4.0, 2.0, 0.0, CUP)], [])
    (seen,) = clues(TARGET, [view(1.0, 2.0, 0.0)], [])
    assert seen.weight < placed.weight
    assert seen.sigma_m > placed.sigma_m
    assert 1.0 < seen.x < 5.0


def remembered(seen: RememberedObject, agreement: float) -> RecalledView:
    at = Pose2D(x=seen.position.x - 1.0, y=seen.position.y, yaw=0.0)
    parts = ScoreParts(
        belief=seen.belief, agreement=agreement, relation=1.0, confidence=0.9, recency=1.0, travel=1.0, again=1.0
    )
    return view(at.x, at.y, at.yaw, seen).model_copy(update={"parts": parts})


BLUE = thing(2, "cup", 9.0, 2.0, "blue")


@pytest.mark.parametrize(("agreement", "left"), [(0.15, 0.15), (0.6, 1.0)])
def test_where_memory_has_what_was_asked_for_one_of_another_colour_is_hardly_it(agreement: float, left: float) -> None:
    (alone,) = clues(TARGET, [remembered(BLUE, agreement)], [])
    red, beside = clues(TARGET, [remembered(CUP, 1.0), remembered(BLUE, agreement)], [])
    assert red.weight == pytest.approx(0.85)
    assert beside.weight == pytest.approx(alone.weight * left)
