"""Which thing a sighting is of, and what becomes of things that are not seen where they should be."""

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from contracts.geometry import Pose2D
from contracts.memory import ObjectState, Observation
from memory.frames import Frame, Miss, frames_of, not_after
from memory.object_association import Ledger
from memory.objects import MapObject
from support.observations import observations, seen


def ledger_after(*batches: list[Observation]) -> Ledger:
    """The things have ids from 1, as if they had been stored."""
    ledger = Ledger.of([])
    for batch in batches:
        for frame in frames_of(batch):
            ledger.apply(frame)
        ledger = Ledger.of(replace(one, id=abs(one.id)) for one in ledger.things.values())
    return ledger


def things(ledger: Ledger) -> list[MapObject]:
    return sorted(ledger.things.values(), key=lambda one: one.id)


def missing(ledger: Ledger, number: int, *places: float, stamp_s: float = 10.0) -> None:
    for x in places:
        for _ in range(4):
            thing = ledger.things[number]
            pose = Pose2D(x=x, y=5.0, yaw=0.0)
            ledger.apply(Frame(pose, stamp_s, misses=(Miss(number, thing.label, 0.8),), is_look=True))


def test_the_same_label_near_by_is_one_thing_and_far_off_another() -> None:
    known = things(ledger_after([seen(at=(1.0, 0.0))], [seen(at=(1.2, 0.1), stamp_s=2.0)], [seen(at=(2.5, 0.0))]))
    assert [one.times_seen for one in known] == [2, 1]


def test_two_boxes_of_one_frame_are_two_things_however_near() -> None:
    together = [seen(at=(1.0, 0.0)), seen(at=(1.1, 0.0))]
    assert len(things(ledger_after(together))) == 2
    assert [one.times_seen for one in things(ledger_after(together, together))] == [2, 2]


def test_a_label_alone_makes_no_identity_and_another_label_none_at_all() -> None:
    assert len(things(ledger_after([seen("cup", at=(1.0, 0.0))], [seen("bottle", at=(1.0, 0.0))]))) == 2


def test_a_place_too_far_for_depth_makes_a_view_but_no_thing() -> None:
    ledger = ledger_after([seen(at=(3.5, 0.0))])
    assert things(ledger) == []


def test_of_two_near_things_the_one_of_the_colour_is_meant() -> None:
    red, green = seen(at=(1.0, 0.0), colour="red"), seen(at=(1.3, 0.0), colour="green")
    again = seen(at=(1.17, 0.0), colour="red", stamp_s=2.0)
    assert [one.times_seen for one in things(ledger_after([red, green], [again]))] == [2, 1]


def test_a_better_measured_place_counts_more_and_the_place_gets_surer() -> None:
    far = seen(at=(2.4, 0.0)).model_copy(update={"sigma_m": 0.25})
    near = seen(x=1.5, at=(2.1, 0.0), stamp_s=2.0).model_copy(update={"sigma_m": 0.01})
    (thing,) = things(ledger_after([far], [near]))
    assert thing.x == pytest.approx(2.1, abs=0.05)
    assert math.sqrt(thing.variance_m2) < 0.07


def test_a_thing_missing_from_two_places_is_lost_and_recovers_when_it_is_seen_again() -> None:
    ledger = ledger_after([seen(at=(1.0, 0.0), confidence=0.9)], [seen(at=(1.0, 0.0), confidence=0.9, stamp_s=2.0)])
    missing(ledger, 1, 0.0)
    assert ledger.things[1].state_at(10.0) is ObjectState.DOUBTFUL
    missing(ledger, 1, 2.0)
    assert ledger.things[1].state_at(10.0) is ObjectState.LOST
    ledger.apply(Frame(Pose2D(x=0.0, y=0.0, yaw=0.0), 11.0, (seen(at=(1.0, 0.0), confidence=0.9, stamp_s=11.0),)))
    assert ledger.things[1].state_at(11.0) is ObjectState.PRESENT


def test_a_lost_thing_that_turns_up_elsewhere_has_moved() -> None:
    ledger = ledger_after([seen(at=(1.0, 0.0), colour="red")])
    missing(ledger, 1, 0.0, 2.0)
    ledger.apply(Frame(Pose2D(x=5.0, y=0.0, yaw=0.0), 11.0, (seen(x=5.0, at=(6.0, 0.0), stamp_s=11.0),)))
    old, new = ledger.things[1], ledger.things[-2]
    assert (old.moved_to, new.moved_from) == (-2, 1)
    assert old.state_at(11.0) is ObjectState.MOVED


def test_a_thing_seen_elsewhere_first_and_then_missed_has_moved_too() -> None:
    ledger = ledger_after([seen(at=(1.0, 0.0))], [seen(x=5.0, at=(6.0, 0.0), stamp_s=5.0)])
    missing(ledger, 1, 0.0, 2.0)
    assert (ledger.things[1].moved_to, ledger.things[2].moved_from) == (2, 1)


def test_what_looks_different_is_not_what_was_lost() -> None:
    ledger = ledger_after([seen(at=(1.0, 0.0), colour="red")])
    missing(ledger, 1, 0.0, 2.0)
    other = seen(x=5.0, at=(6.0, 0.0), stamp_s=11.0, colour="green")
    ledger.apply(Frame(other.pose, 11.0, (other,)))
    assert ledger.things[1].moved_to is None


def test_what_a_frame_shows_is_not_missing_from_it() -> None:
    ledger = ledger_after([seen(at=(1.0, 0.0))])
    again = seen(at=(1.0, 0.0), stamp_s=2.0)
    ledger.apply(Frame(again.pose, 2.0, (again,), misses=(Miss(1, "bottle", 0.8),), is_look=True))
    assert (ledger.things[1].times_seen, ledger.things[1].times_missed) == (2, 0)


def test_a_look_older_than_the_last_sighting_proves_nothing() -> None:
    ledger = ledger_after([seen(at=(1.0, 0.0), stamp_s=20.0)])
    missing(ledger, 1, 0.0, 2.0, stamp_s=10.0)
    assert ledger.things[1].times_missed == 0


def test_a_stamp_from_the_future_is_taken_as_now() -> None:
    frame = not_after(frames_of([seen(stamp_s=1e9)])[0], 50.0)
    assert (frame.stamp_s, frame.seen[0].stamp_s) == (50.0, 50.0)


@given(st.lists(st.lists(observations, max_size=6), max_size=8))
def test_every_sighting_is_counted_once_and_every_belief_is_a_probability(batches: list[list[Observation]]) -> None:
    ledger = Ledger.of([])
    frames = [frame for batch in batches for frame in frames_of(batch)]
    for frame in frames:
        ledger.apply(frame)
    assert sum(one.count for one in ledger.sightings.values()) == sum(len(frame.seen) for frame in frames)
    assert all(0.0 < one.belief < 1.0 and one.variance_m2 > 0.0 for one in ledger.things.values())
