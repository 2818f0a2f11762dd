"""The bench of fetches: what is drawn, and how it is told."""

from typing import Any

from bench.fetch.__main__ import report
from bench.fetch.play import episodes
from bench.fetch.scene import KINDS, PLACES


def row(kind: str, *, grasped: bool, cause: str = "", false: bool = False) -> dict[str, Any]:
    return {
        "kind": kind, "place": "floor", "end": "delivered" if grasped else "not_taken", "cause": cause,
        "grasped": grasped, "brought": grasped, "said_held_without_it": false, "slipped_mm": 0.5,
    }  # fmt: skip


def test_every_kind_stands_at_every_place_and_the_same_seed_is_the_same_episode() -> None:
    drawn = episodes(len(KINDS) * len(PLACES))
    assert {(each.setting.kind, each.setting.place) for each in drawn} == {(k, p) for k in KINDS for p in PLACES}
    assert episodes(3, first=7) == episodes(3, first=7)
    assert episodes(1, first=7) != episodes(1, first=8)


def test_the_report_has_an_interval_and_a_cause_for_each_failure() -> None:
    told = report([row("cup", grasped=True), row("cup", grasped=False, cause="slipped"), row("ball", grasped=True)])
    assert "| cup | 1 of 2 | 9 to 91 % | 1 | slipped 1 |" in told
    assert "| all | 2 of 3 |" in told
    assert "0 said to be held that were not, slipped 0.5 mm at most while held." in told


def test_what_was_said_to_be_held_and_was_not_is_told() -> None:
    assert "1 said to be held that were not" in report([row("cup", grasped=False, cause="dropped", false=True)])
