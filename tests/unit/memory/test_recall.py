"""The order in which remembered places are looked at (requirement A5)."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from contracts.geometry import Pose2D
from contracts.memory import Embedding, Observation, RecalledView, RecallRequest, RecallRule
from memory.objects import MapObject
from memory.ports import Candidates, StoredView
from memory.recall import SAME_PLACE_M, Weights, labels_to_search
from memory.recall import rank as rank_by
from support.observations import asking, observations, seen, view

RED_BOTTLE = asking("bottle", description="red bottle")
A5 = RecallRule.CONFIDENCE
NOW_S = 1.0
PLAIN = Weights()


def rank(
    request: RecallRequest,
    of_memory_object: list[StoredView],
    of_label: list[StoredView],
    *things: MapObject,
    rule: RecallRule = A5,
    now_s: float = NOW_S,
    weights: Weights = PLAIN,
) -> tuple[RecalledView, ...]:
    found = {request.memory_object or "": Candidates(views=tuple(of_memory_object))}
    found[request.target.label] = Candidates({one.id: one for one in things}, tuple(of_label))
    return rank_by(request, found, rule=rule, weights=weights, now_s=now_s)


def ids(request: RecallRequest, of_memory_object: list[StoredView], of_label: list[StoredView]) -> list[int]:
    return [one.view.id for one in rank(request, of_memory_object, of_label)]


def test_the_memory_objects_views_come_before_the_labels_own() -> None:
    request = asking("cup", memory_object="bottle")
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
    assert ids(asking("bottle"), [], views) == [1, 2, 4, 3]


def test_the_reason_says_what_was_seen_and_how_its_colour_goes_with_the_one_asked_for() -> None:
    views = [view(1, seen(colour="red")), view(2, seen(x=2.0)), view(3, seen(x=4.0, colour="blue"))]
    reasons = [one.reason for one in rank(RED_BOTTLE, [], views)]
    assert reasons == [
        "saw red bottle from here with confidence 0.50: the colour asked for; 86% sure it is still there",
        "saw bottle from here with confidence 0.50: colour not known; 86% sure it is still there",
        "saw blue bottle from here with confidence 0.50: not the colour asked for; 86% sure it is still there",
    ]


def test_views_close_together_that_look_the_same_way_count_once() -> None:
    views = [
        view(1, seen(confidence=0.9)),
        view(2, seen(x=0.7, confidence=0.8)),
        view(3, seen(x=0.7, yaw=math.radians(61.0), confidence=0.7)),
        view(4, seen(x=0.8, confidence=0.6)),
        view(5, seen(yaw=math.radians(359.0), confidence=0.5)),
    ]
    assert ids(asking("bottle"), [], views) == [1, 3, 4]


def test_a_place_remembered_for_both_things_is_visited_once() -> None:
    request = asking("cup", memory_object="bottle", min_separation_m=0.0)
    assert ids(request, [view(1, seen("bottle"))], [view(2, seen("cup")), view(3, seen("cup", x=1.0))]) == [1, 3]


def test_a_memory_object_that_is_the_thing_itself_changes_nothing() -> None:
    views = [view(1, seen()), view(2, seen(x=3.0))]
    plain = rank(asking("bottle"), [], views)
    assert rank(asking("bottle", memory_object="bottle"), views, views) == plain


def test_of_equal_views_the_nearer_is_first() -> None:
    views = [view(1, seen(x=5.0)), view(2, seen(x=1.0))]
    assert ids(asking("bottle", pose=Pose2D(x=0.0, y=0.0, yaw=0.0)), [], views) == [2, 1]


def test_no_more_than_the_limit_are_named() -> None:
    views = [view(k, seen(x=2.0 * k)) for k in range(10)]
    assert ids(asking("bottle", limit=3), [], views) == [0, 1, 2]


def views_from(first: int) -> st.SearchStrategy[list[StoredView]]:
    def numbered(all_of: list[Observation]) -> list[StoredView]:
        return [view(first + k, one) for k, one in enumerate(all_of)]

    return st.lists(observations, max_size=25).map(numbered)


@given(
    of_memory_object=views_from(0),
    of_label=views_from(100),
    separation_m=st.sampled_from([0.0, 0.3, 0.75, 3.0]),
    description=st.sampled_from(["", "red bottle", "blue"]),
)
def test_chosen_places_differ_and_every_other_view_is_close_to_a_chosen_one(
    of_memory_object: list[StoredView], of_label: list[StoredView], separation_m: float, description: str
) -> None:
    request = asking("bottle", memory_object="cup", min_separation_m=separation_m, description=description, limit=200)
    numbers = [one.view.id for one in rank(request, of_memory_object, of_label)]
    chosen = [one for one in (*of_memory_object, *of_label) if one.id in numbers]
    near_m = max(separation_m, SAME_PLACE_M)

    def alike(one: StoredView, other: StoredView) -> bool:
        turn = abs(math.remainder(one.pose.yaw - other.pose.yaw, 2.0 * math.pi))
        away_m = math.hypot(one.pose.x - other.pose.x, one.pose.y - other.pose.y)
        return turn < math.radians(60.0) and away_m < near_m

    assert not any(alike(one, other) for one in chosen for other in chosen if one.id != other.id)
    left_out = [one for one in (*of_memory_object, *of_label) if one not in chosen]
    assert all(any(alike(one, other) for other in chosen) for one in left_out)


def thing(number: int, x: float, *, belief: float = 0.9, colour: str | None = None, **known: float) -> MapObject:
    return MapObject(
        id=number,
        label="bottle",
        x=x,
        y=1.0,
        z=0.3,
        variance_m2=0.01,
        belief=belief,
        believed_s=known.get("believed_s", NOW_S),
        confidence=0.8,
        first_seen_s=0.0,
        last_seen_s=known.get("believed_s", NOW_S),
        colours={colour: 1.0} if colour else {},
    )


def by_belief(request: RecallRequest, views: list[StoredView], *things: MapObject, now_s: float = NOW_S) -> list[int]:
    return [one.view.id for one in rank(request, [], views, *things, rule=RecallRule.BELIEF, now_s=now_s)]


def test_what_is_surely_there_comes_before_what_is_doubtful_though_it_was_seen_less_clearly() -> None:
    views = [view(1, seen(confidence=0.9), 7), view(2, seen(x=3.0, confidence=0.6), 8)]
    assert by_belief(asking("bottle"), views, thing(7, 0.0, belief=0.3), thing(8, 3.0)) == [2, 1]


def test_what_was_looked_for_and_not_there_is_not_recalled_but_by_the_plain_rule() -> None:
    views = [view(1, seen(confidence=0.9), 7), view(2, seen(x=3.0, confidence=0.6), 8)]
    things = thing(7, 0.0, belief=0.05), thing(8, 3.0)
    request = asking("bottle")
    assert by_belief(request, views, *things) == [2]
    assert [one.view.id for one in rank(request, [], views, *things, rule=A5)] == [1, 2]


def test_age_alone_makes_doubtful_but_never_forgets() -> None:
    old = thing(7, 0.0, believed_s=0.0)
    (only,) = rank(asking("bottle"), [], [view(1, seen(), 7)], old, rule=RecallRule.BELIEF, now_s=86_400.0 * 300)
    assert only.parts is not None
    assert only.parts.belief == pytest.approx(0.18, abs=0.01)


def test_the_other_colour_comes_last_however_sure_it_is() -> None:
    views = [view(1, seen(confidence=0.9), 7), view(2, seen(x=3.0, confidence=0.5), 8)]
    assert by_belief(RED_BOTTLE, views, thing(7, 0.0, colour="blue"), thing(8, 3.0, belief=0.5, colour="red")) == [2, 1]


def test_the_embedding_says_which_of_two_alike_is_meant() -> None:
    wanted = Embedding(model="clip", vector=(1.0, *(0.0,) * 7))
    near = replace(thing(8, 3.0), embedding_model="clip", embedding=(0.9, 0.436, *(0.0,) * 6))
    far = replace(thing(7, 0.0), embedding_model="clip", embedding=(0.1, 0.995, *(0.0,) * 6))
    request = asking("bottle", description="the one with the label", embedding=wanted)
    views = [view(1, seen(confidence=0.9), 7), view(2, seen(x=3.0, confidence=0.5), 8)]
    assert by_belief(request, views, near, far) == [2, 1]


def test_the_robot_is_sent_to_where_it_was_seen_from_turned_to_face_it() -> None:
    (only,) = rank(asking("bottle"), [], [view(1, seen(x=1.0, yaw=0.2), 7)], thing(7, 1.0))
    assert only.pose == Pose2D(x=1.0, y=0.0, yaw=math.pi / 2)
    assert only.view.pose.yaw == 0.2


def test_a_second_view_of_one_thing_waits_for_the_first_view_of_another() -> None:
    views = [
        view(1, seen(confidence=0.9), 7),
        view(2, seen(x=2.0, confidence=0.9), 7),
        view(3, seen(x=4.0, confidence=0.6), 8),
    ]
    assert by_belief(asking("bottle"), views, thing(7, 0.0), thing(8, 4.0)) == [1, 3, 2]


def test_without_its_weight_a_second_view_of_one_thing_is_as_good_as_the_first() -> None:
    views = [view(1, seen(confidence=0.9), 7), view(2, seen(x=2.0, confidence=0.9), 7), view(3, seen(x=4.0), 8)]
    things, request = (thing(7, 0.0), thing(8, 4.0)), asking("bottle")
    found = rank(request, [], views, *things, rule=RecallRule.BELIEF, weights=Weights(again=0.0))
    assert [one.view.id for one in found] == [1, 2, 3]
    assert found[0].score == found[1].score


def test_the_colour_said_is_the_things_and_not_the_memory_objects() -> None:
    request = asking("cup", memory_object="bottle", description="red cup")
    near = [view(1, seen("bottle", colour="red", confidence=0.5)), view(2, seen("bottle", x=4.0, colour="blue"))]
    first, other = rank(request, near, [], rule=RecallRule.BELIEF)
    assert first.score == other.score
    assert "colour" not in first.reason
    assert labels_to_search(request) == {"cup": {"red"}, "bottle": set()}
    assert labels_to_search(asking("cup", description="gray cup")) == {"cup": {"grey", "gray"}}


def test_of_two_equally_good_places_the_nearer_is_first_and_the_score_is_the_product_of_its_parts() -> None:
    request = asking("bottle", pose=Pose2D(x=6.0, y=0.0, yaw=0.0))
    best, other = rank(request, [], [view(1, seen()), view(2, seen(x=6.0))], rule=RecallRule.BELIEF)
    assert (best.view.id, other.view.id) == (2, 1)
    parts = other.parts
    assert parts is not None
    assert parts.travel < 1.0
    assert other.score == pytest.approx(parts.belief * parts.confidence**0.5 * parts.travel**0.25)


def test_the_things_own_places_come_before_those_of_the_memory_object() -> None:
    request = asking("cup", memory_object="bottle")
    first = [view(1, seen("bottle", confidence=0.9))]
    answer = rank(request, first, [view(2, seen("cup", x=5.0, confidence=0.5))], rule=RecallRule.BELIEF)
    assert [(one.view.id, one.source) for one in answer] == [(2, "label"), (1, "memory_object")]
