"""The order in which remembered places are looked at (requirement A5)."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from contracts.geometry import Pose2D
from contracts.memory import Observation, RecallRequest, View
from memory.recall import SAME_PLACE_M, colours_in, rank
from support.observations import observations, seen, view

RED_BOTTLE = RecallRequest(label="bottle", description="red bottle")


def ids(request: RecallRequest, of_memory_object: list[View], of_label: list[View]) -> list[int]:
    return [one.view.id for one in rank(request, of_memory_object, of_label)]


def test_the_memory_objects_views_come_before_the_labels_own() -> None:
    request = RecallRequest(label="cup", memory_object="bottle")
    answer = rank(
        request, [view(1, seen("bottle", x=1.0, confidence=0.4))], [view(2, seen("cup", x=5.0, confidence=0.9))]
    )
    assert [(one.view.id, one.source) for one in answer] == [(1, "memory_object"), (2, "label")]


def test_within_a_source_the_colour_asked_for_comes_first_and_another_colour_last() -> None:
    views = [
        view(1, seen(x=0.0, colour="blue", confidence=0.9)),
        view(2, seen(x=2.0, colour=None, confidence=0.8)),
        view(3, seen(x=4.0, colour="red", confidence=0.3)),
        view(4, seen(x=6.0, colour="red", confidence=0.6)),
    ]
    assert ids(RED_BOTTLE, [], views) == [4, 3, 2, 1]
    assert ids(RecallRequest(label="bottle"), [], views) == [1, 2, 4, 3]


def test_the_reason_says_what_was_seen_and_how_its_colour_goes_with_the_one_asked_for() -> None:
    views = [view(1, seen(colour="red")), view(2, seen(x=2.0)), view(3, seen(x=4.0, colour="blue"))]
    reasons = [one.reason for one in rank(RED_BOTTLE, [], views)]
    assert reasons == [
        "saw red bottle from here with confidence 0.50: the colour asked for",
        "saw bottle from here with confidence 0.50: colour not known",
        "saw blue bottle from here with confidence 0.50: not the colour asked for",
    ]


def test_views_close_together_that_look_the_same_way_count_once() -> None:
    views = [
        view(1, seen(confidence=0.9)),
        view(2, seen(x=0.7, confidence=0.8)),
        view(3, seen(x=0.7, yaw=math.radians(61.0), confidence=0.7)),
        view(4, seen(x=0.8, confidence=0.6)),
        view(5, seen(yaw=math.radians(359.0), confidence=0.5)),
    ]
    assert ids(RecallRequest(label="bottle"), [], views) == [1, 3, 4]


def test_a_place_remembered_for_both_things_is_visited_once() -> None:
    request = RecallRequest(label="cup", memory_object="bottle", min_separation_m=0.0)
    assert ids(request, [view(1, seen("bottle"))], [view(2, seen("cup")), view(3, seen("cup", x=1.0))]) == [1, 3]


def test_a_memory_object_that_is_the_thing_itself_changes_nothing() -> None:
    views = [view(1, seen()), view(2, seen(x=3.0))]
    plain = rank(RecallRequest(label="bottle"), [], views)
    assert rank(RecallRequest(label="bottle", memory_object="bottle"), views, views) == plain


def test_of_equal_views_the_nearer_is_first() -> None:
    views = [view(1, seen(x=5.0)), view(2, seen(x=1.0))]
    assert ids(RecallRequest(label="bottle", pose=Pose2D(x=0.0, y=0.0, yaw=0.0)), [], views) == [2, 1]


def test_no_more_than_the_limit_are_named() -> None:
    views = [view(k, seen(x=2.0 * k)) for k in range(10)]
    assert ids(RecallRequest(label="bottle", limit=3), [], views) == [0, 1, 2]


@pytest.mark.parametrize(
    ("description", "label", "wanted"),
    [
        ("Red bottle", "bottle", {"red"}),
        ("red or gray cup", "cup", {"red", "grey"}),
        ("the reddish one", "cup", set[str]()),
        ("ripe orange", "orange", set[str]()),
        ("orange orange", "orange", {"orange"}),
        ("orange cup", "cup", {"orange"}),
        ("", "cup", set[str]()),
    ],
)
def test_colour_words_are_read_from_the_description(description: str, label: str, wanted: set[str]) -> None:
    assert colours_in(description, label) == wanted


def views_from(first: int) -> st.SearchStrategy[list[View]]:
    def numbered(all_of: list[Observation]) -> list[View]:
        return [view(first + k, one) for k, one in enumerate(all_of)]

    return st.lists(observations, max_size=25).map(numbered)


@given(
    of_memory_object=views_from(0),
    of_label=views_from(100),
    separation_m=st.sampled_from([0.0, 0.3, 0.75, 3.0]),
    description=st.sampled_from(["", "red bottle", "blue"]),
)
def test_chosen_places_differ_and_every_other_view_is_close_to_a_chosen_one(
    of_memory_object: list[View], of_label: list[View], separation_m: float, description: str
) -> None:
    request = RecallRequest(
        label="bottle", memory_object="cup", min_separation_m=separation_m, description=description, limit=200
    )
    chosen = [one.view for one in rank(request, of_memory_object, of_label)]
    near_m = max(separation_m, SAME_PLACE_M)

    def alike(one: View, other: View) -> bool:
        turn = abs(math.remainder(one.pose.yaw - other.pose.yaw, 2.0 * math.pi))
        away_m = math.hypot(one.pose.x - other.pose.x, one.pose.y - other.pose.y)
        return turn < math.radians(60.0) and away_m < near_m

    assert not any(alike(one, other) for one in chosen for other in chosen if one.id != other.id)
    left_out = [one for one in (*of_memory_object, *of_label) if one not in chosen]
    assert all(any(alike(one, other) for other in chosen) for one in left_out)
