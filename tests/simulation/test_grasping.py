"""Grasps by physics on the simulated arm: contacts and friction alone, nothing is welded; ground truth judges."""

import pytest

from bench.fetch.play import world_of
from bench.fetch.scene import Setting
from bench.fetch.shell import FetchShell, brought, grasped
from contracts.manipulation import FetchCause, FetchEnd, Holding
from coordinator.manipulation.recoveries import FetchRecovery

BOTTLE = Setting("bottle", "floor", ahead_m=0.27, left_m=0.03)


def test_a_bottle_on_the_floor_is_raised_by_10_cm_held_for_2_s_and_brought_by_friction() -> None:
    with world_of(BOTTLE) as world:
        world.advance(0.5)
        shell = FetchShell(world, BOTTLE, seed=1)
        finish = shell.run()
        assert grasped(shell), shell.truth
        assert shell.truth.slipped_m < 0.005
        assert brought(shell)
        assert finish.end is FetchEnd.DELIVERED
        assert world.truth.collisions <= 1, "the arm touched the bottle, and nothing else"


def test_without_friction_it_is_not_held_and_nobody_says_that_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    with world_of(BOTTLE) as world:
        model = world._body.model
        model.geom_friction[model.body("thing").geomadr[0]] = 0.0
        shell = FetchShell(world, BOTTLE, seed=1)
        finish = shell.run()
    assert not grasped(shell)
    assert finish.end is FetchEnd.NOT_TAKEN
    assert finish.cause is not None
    assert FetchRecovery.LOOK_AGAIN in shell.fetch.used, "it noticed, and looked again"
    assert shell.fetch.holding is Holding.EMPTY


def test_what_is_out_of_reach_is_left_and_the_end_says_why() -> None:
    far = Setting("bottle", "floor", ahead_m=0.6, left_m=0.0)
    with world_of(far) as world:
        shell = FetchShell(world, far, seed=1)
        before = shell.thing_at()
        assert shell.run().cause is FetchCause.OUT_OF_REACH
        assert shell.thing_at() == pytest.approx(before, abs=3e-3)
