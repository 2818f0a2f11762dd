"""Episodes are drawn alike each time, hold what their set promises, and are counted honestly."""

import math
from typing import Any

import pytest

from bench.search.episode import Episode
from bench.search.floor import Ways
from bench.search.policies import POLICIES, deciding
from bench.search.report import figures, is_false_find, is_found, spl, table
from bench.search.sets import SETS, TUNE_HOMES, episode, site
from coordinator.core.rules import ApproachRule, CoverageRule
from coordinator.settings import Settings
from sim.home import Home
from sim.home.rearrange import room_of


def drawn(set_name: str) -> Episode:
    return episode(set_name, 0, TUNE_HOMES)


@pytest.mark.parametrize("set_name", SETS)
def test_an_episode_is_the_same_each_time_and_can_be_written_down(set_name: str) -> None:
    one = drawn(set_name)
    assert drawn(set_name) == one
    assert Episode.model_validate_json(one.model_dump_json()) == one


def test_what_was_moved_stands_in_another_room() -> None:
    one = drawn("moved")
    home, (carried,) = Home.generate(one.home_seed), one.since_tour
    before = next(thing for thing in home.things if thing.id == carried.thing_id)
    after = next(thing for thing in carried.done_to(home).things if thing.id == carried.thing_id)
    assert room_of(home, after) not in {None, room_of(home, before)}


def test_what_was_removed_or_never_held_is_not_there() -> None:
    for one in (drawn("removed"), drawn("absent")):
        home = Home.generate(one.home_seed)
        for carried in one.since_tour:
            home = carried.done_to(home)
        (asked,) = one.commands[0].asked
        assert (asked.kind, asked.colour) not in {(thing.kind, thing.colour) for thing in home.things}
        assert not asked.there


def test_a_distractor_is_nearer_than_the_right_one() -> None:
    one = drawn("distractor")
    at, (asked,) = site(one.home_seed), one.commands[0].asked
    ways = Ways(at.world, one.start)
    alike = [thing for thing in at.world.truth.things if thing.kind == asked.kind]
    others_m = [ways.to_find_m(thing, 1.0) for thing in alike if thing.colour != asked.colour]
    (right_m,) = (ways.to_find_m(thing, 1.0) for thing in alike if thing.colour == asked.colour)
    assert min(others_m) < right_m < math.inf


def test_a_longer_reach_is_a_shorter_way() -> None:
    one = drawn("mapped")
    at, (asked,) = site(one.home_seed), one.commands[0].asked
    (thing,) = (each for each in at.world.truth.things if (each.kind, each.colour) == (asked.kind, asked.colour))
    ways = Ways(at.world, one.start)
    assert 0.0 < ways.to_find_m(thing, 1.0) <= ways.to_find_m(thing, 0.45) < math.inf


def row(outcome: str = "found", *, there: bool = True, near: bool = True, false_find: bool = False) -> dict[str, Any]:
    return {
        "outcome": outcome, "there": there, "seconds": 40.0, "metres": 8.0, "reason": "",
        "shortest_m": {"0.45": 4.0, "1.0": 3.5}, "floor_s": {"0.45": 13.0, "1.0": 11.0},
        "score": {"within": {"0.45": near, "1.0": True}, "false_find": false_find},
    }  # fmt: skip


def record(*rows: dict[str, Any]) -> dict[str, Any]:
    return {
        "episode": {"policy": "viewpoints", "set_name": "mapped"}, "missions": list(rows), "problems": [],
        "activity": {"SCANNING: turn": 3.0, "CENTERING: turn": 1.0}, "standing_s": 2.0,
        "wall": {"simulated_s": 50.0, "cpu_s": 12.0, "tour_cpu_s": 2.0},
    }  # fmt: skip


def test_a_find_counts_by_where_the_robot_stands() -> None:
    assert is_found(row(), "0.45")
    assert not is_found(row(near=False), "0.45")
    assert is_found(row(near=False), "1.0")
    assert not is_found(row("not_found"), "1.0")
    assert spl(row()) == 0.5
    assert spl(row("unsure")) == 0.0


def test_a_find_of_what_is_not_there_is_false() -> None:
    nothing: dict[str, Any] = {**row(there=False), "score": {}}
    assert is_false_find(nothing)
    assert not is_false_find(row("not_found", there=False))


def test_figures_add_up() -> None:
    told = figures([record(row(), row("not_found", there=False)), record(row(near=False))])
    assert told["found_0.45"]["n"] == 1
    assert told["found_1.0"]["of"] == 2
    assert told["honest_without"]["share"] == 1.0
    assert told["over_floor_s"]["median"] == 27.0
    assert told["activity_s"] == {"turn": 8.0}
    assert told["standing_share"] == 0.5
    assert told["real_time"] == 5.0
    assert "1/2" in table({"viewpoints/mapped": told})


@pytest.mark.parametrize("policy", POLICIES)
def test_every_policy_is_settings_that_the_coordinator_takes(policy: str) -> None:
    assert deciding(Settings(), policy, ()).mission_timeout_s == 900.0


def test_a_policy_can_be_changed_by_name_and_an_unknown_name_is_refused() -> None:
    changed = deciding(Settings(), "atom", ("approach_rule=localized", "reach_m=0.5"))
    assert changed.coverage_rule is CoverageRule.LAWNMOWER
    assert changed.approach_rule is ApproachRule.LOCALIZED
    assert changed.reach_m == 0.5
    with pytest.raises(KeyError, match="approach_rul"):
        deciding(Settings(), "atom", ("approach_rul=localized",))
    one = drawn("mapped").model_copy(update={"changes": ("reach_m=0.5",), "detector": "coco"})
    assert one.name == "belief+reach_m=0.5+detector=coco/mapped/0000"
