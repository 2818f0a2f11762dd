"""Which sightings are the same view, what is kept of them, and what is never kept."""

import math
from collections.abc import Iterable

import pytest
from hypothesis import given
from hypothesis import strategies as st

from contracts.memory import Observation
from contracts.vision import Detection, Detections
from memory.frames import Exclusion, worth_keeping
from memory.views import AggregatedView, ViewCell, merged, view_cell, view_of
from support.observations import observations, seen


def merge(given_: Iterable[Observation]) -> dict[ViewCell, AggregatedView]:
    found: dict[ViewCell, AggregatedView] = {}
    for new in map(view_of, given_):
        found[new.place] = merged(found[new.place], new) if new.place in found else new
    return found


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (seen(x=0.01), seen(x=0.24)),
        (seen(y=-0.01), seen(y=-0.24)),
        (seen(yaw=0.01), seen(yaw=math.radians(29.9))),
        (seen(yaw=-0.1), seen(yaw=2.0 * math.pi - 0.1)),
        (seen(colour="red", confidence=0.1), seen(colour="red", confidence=0.9)),
    ],
)
def test_the_same_thing_from_the_same_cell_and_sector_is_one_view(one: Observation, other: Observation) -> None:
    assert view_cell(one) == view_cell(other)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (seen("bottle"), seen("cup")),
        (seen(colour="red"), seen(colour="blue")),
        (seen(colour="red"), seen(colour=None)),
        (seen(x=0.24), seen(x=0.26)),
        (seen(x=-0.01), seen(x=0.01)),
        (seen(yaw=math.radians(29.0)), seen(yaw=math.radians(31.0))),
        (seen(yaw=-0.01), seen(yaw=0.01)),
    ],
)
def test_another_label_colour_cell_or_sector_is_another_view(one: Observation, other: Observation) -> None:
    assert view_cell(one) != view_cell(other)


def test_a_view_keeps_the_best_pose_the_last_time_and_the_count() -> None:
    best = seen(x=0.2, confidence=0.9, stamp_s=5.0)
    (kept,) = merge([seen(x=0.1, stamp_s=7.0), best, seen(x=0.05, confidence=0.6, stamp_s=6.0)]).values()
    assert (kept.pose, kept.confidence, kept.last_seen_s, kept.count) == (best.pose, 0.9, 7.0, 3)


@given(st.lists(observations, max_size=40))
def test_merging_agrees_with_a_plain_dict_of_lists(given_: list[Observation]) -> None:
    model: dict[object, list[Observation]] = {}
    for one in given_:
        model.setdefault(view_cell(one), []).append(one)
    kept = merge(given_)
    assert kept.keys() == model.keys()
    for place, all_of in model.items():
        best = max(all_of, key=lambda one: one.confidence)
        assert kept[place].pose == best.pose  # type: ignore[index]
        assert kept[place].confidence == best.confidence  # type: ignore[index]
        assert kept[place].last_seen_s == max(one.stamp_s for one in all_of)  # type: ignore[index]
        assert kept[place].count == len(all_of)  # type: ignore[index]


@given(observations)
def test_every_heading_has_one_of_twelve_sectors(one: Observation) -> None:
    assert 0 <= view_cell(one).sector < 12


@pytest.mark.parametrize("label", ["person", "Person", " person ", "PERSON", "ｐｅｒｓｏｎ"])
def test_an_excluded_label_cannot_be_spelled_round(label: str) -> None:
    assert label in Exclusion.of(["person"])


def frame(*detections: Detection) -> Detections:
    return Detections(stamp_s=3.0, image_width_px=250, image_height_px=250, detections=detections)


def box(label: str, confidence: float = 0.8, colour: str | None = None) -> Detection:
    return Detection(label=label, confidence=confidence, bbox_xyxy=(0.0, 0.0, 9.0, 9.0), colour=colour)


def test_of_a_frame_people_and_guesses_are_left_out() -> None:
    told = worth_keeping(
        frame(box("bottle", colour="red"), box("person"), box("cup", 0.1)), Exclusion.of(["person"]), 0.3
    )
    assert told == [box("bottle", colour="red")]


def test_a_thing_boxed_twice_counts_once_with_its_surer_box_but_two_things_count_twice() -> None:
    twice = Detection(label="bottle", confidence=0.6, bbox_xyxy=(0.0, 0.0, 9.0, 8.0))
    beside = Detection(label="bottle", confidence=0.5, bbox_xyxy=(6.0, 0.0, 15.0, 9.0))
    assert worth_keeping(frame(twice, box("bottle"), beside), Exclusion.of([]), 0.3) == [box("bottle"), beside]
